"""Structures: their size, and a table of computed modes."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar, cast

from modallab_client import _tables
from modallab_client.models import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client._generated.models import MemberNodes, PhysicsWarning, StructureGeometry


class StructureMethods:
    """A sentence and a table on a structure."""

    compared: ClassVar[bool] = True
    if TYPE_CHECKING:
        id: str
        name: str
        n_nodes: int
        n_dofs: int
        members: int
        groups: Mapping[str, tuple[int, ...]]
        warnings: Sequence[PhysicsWarning]

    def summary(self) -> str:
        """Return name and size in one sentence."""
        size = f"{self.n_nodes} nodes, {self.n_dofs} degrees of freedom, {self.members} members"
        return f"{self.name or 'structure'}: {size}"

    def _repr_html_(self) -> str:
        rows = [
            ("nodes", str(self.n_nodes)),
            ("degrees of freedom", str(self.n_dofs)),
            ("members", str(self.members)),
            *((f"group {name}", f"{len(numbers)} members") for name, numbers in self.groups.items()),
            *(("warning", f"{warning.field}: {warning.message}") for warning in self.warnings),
        ]
        return _tables.html((), rows, caption=f"Structure {self.id} {self.name}".rstrip())


class StructureGeometryMethods:
    """A picture and a table of nodes and members."""

    compared: ClassVar[bool] = True
    if TYPE_CHECKING:
        id: str
        name: str
        nodes: Mapping[int, tuple[float, ...]]
        members: Sequence[MemberNodes]
        dofs: tuple[str, ...]

    def plot(self) -> "Axes":
        """Draw nodes and members; return the axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        """
        from modallab_client import _shape_plot

        return _shape_plot.structure(cast("StructureGeometry", self))

    def _repr_html_(self) -> str:
        counted = [("nodes", self.nodes), ("members", self.members), ("degrees of freedom", self.dofs)]
        rows = [(name, str(len(things))) for name, things in counted]
        return _tables.html((), rows, caption=f"Geometry of {self.name or self.id}")


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
