"""Expanded modes and reduced models."""

from dataclasses import dataclass

from modallab_client import _tables
from modallab_client.models import FloatArray
from modallab_client.results import ModalModel


@dataclass(frozen=True, eq=False)
class Expansion:
    """Measured modes at all DoFs of a structure, and how far the structure goes along with them."""

    model: ModalModel
    fit_residuals: FloatArray  # (n_modes,) share of the measured shape that the expanded one does not have
    # (n_modes,) Hz, at which strain and kinetic energy of the structure balance in the expanded shape
    rayleigh_frequencies: FloatArray

    def table(self) -> str:
        """Return a table of each mode's fit residual, its measured and its Rayleigh frequency, as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        head = ("mode", "frequency Hz", "of the shape Hz", "residual", "flags")
        numbers = zip(self.model.modes, self.rayleigh_frequencies, self.fit_residuals, strict=True)
        rows = [
            (str(i), f"{mode.frequency:.2f}", f"{rayleigh:.2f}", f"{residual:.2g}", ", ".join(mode.flags))
            for i, (mode, rayleigh, residual) in enumerate(numbers, 1)
        ]
        return head, rows

    def _repr_html_(self) -> str:
        return _tables.html(*self._rows(), caption=f"Modes {self.model.id} at {len(self.model.dofs)} DoFs")


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """A structure at some of its DoFs: x = T x_master."""

    masters: tuple[str, ...]
    dofs: tuple[str, ...]
    transformation: FloatArray  # (n_dof, n_master)
    mass: FloatArray  # (n_master, n_master) kg
    stiffness: FloatArray  # (n_master, n_master) N/m
    frequencies: FloatArray  # (k,) Hz, of the reduced model
    shapes: FloatArray  # (n_master, k) 1/sqrt(kg)
    model_frequencies: FloatArray  # (n,) Hz, of the full model's first elastic modes
    frequency_errors: FloatArray  # (n,) of the reduced model for each of these, relative

    def table(self) -> str:
        """Return the frequencies of the full model and the errors of the reduced one as text."""
        return _tables.text(*self._rows())

    def _rows(self) -> _tables.Table:
        errors = zip(self.model_frequencies, self.frequency_errors, strict=True)
        rows = [
            (str(i), f"{frequency:.5g}", f"{error:.2g}") for i, (frequency, error) in enumerate(errors, 1)
        ]
        return ("mode", "frequency Hz", "relative error"), rows

    def _repr_html_(self) -> str:
        caption = f"{len(self.dofs)} DoFs reduced to {len(self.masters)}"
        return _tables.html(*self._rows(), caption=caption)
