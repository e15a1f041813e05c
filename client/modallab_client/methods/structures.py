"""Structures: a table of computed modes."""

from typing import TYPE_CHECKING

from modallab_client import _tables
from modallab_client.models import FloatArray


class StructureModesMethods:
    """A table of elastic modes."""

    if TYPE_CHECKING:
        frequencies: FloatArray
        loss_factors: FloatArray
        n_rigid_body: int

    def table(self) -> str:
        """Return number, frequency and loss factor of each mode as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        modes = zip(self.frequencies, self.loss_factors, strict=True)
        rows = [(str(i), f"{f:.4g}", f"{eta:.4g}") for i, (f, eta) in enumerate(modes, 1)]
        return ("mode", "frequency Hz", "loss factor"), rows

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=f"{self.n_rigid_body} rigid-body modes not listed")
