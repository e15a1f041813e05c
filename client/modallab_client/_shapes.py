"""Pictures of mode shapes, for every result that has shapes."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client._shape_plot import Moved, MovingShape
    from modallab_client.models import ComplexArray, FloatArray
    from modallab_client.results import StructureGeometry


class ShapePictures:
    """Mode shapes, still and moving."""

    if TYPE_CHECKING:
        shapes: ComplexArray
        dofs: tuple[str, ...]

        @property
        def frequencies(self) -> FloatArray:
            """(n_modes,) Hz."""
            ...

    def plot_shape(self, layout: "StructureGeometry", mode: int = 1) -> "Axes":
        """Draw a mode shape over the structure at rest; return the axes.

        Parameters
        ----------
        layout
            Nodes and members, from `lab.structures.layout(structure)`.
        mode
            Number of the mode, from 1.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        ValueError
            If there is no such mode.
        """
        from modallab_client import _shape_plot

        return _shape_plot.shape(*self._moved(layout, mode))

    def animate(self, layout: "StructureGeometry", mode: int = 1) -> "MovingShape":
        """Return a mode shape that moves; a notebook shows it, `save` writes a `.gif` or `.html` file.

        Parameters
        ----------
        layout, mode
            As of `plot_shape`.

        Raises
        ------
        ValueError
            If there is no such mode.
        """
        from modallab_client import _shape_plot

        return _shape_plot.MovingShape(*self._moved(layout, mode))

    def _moved(self, layout: "StructureGeometry", mode: int) -> "tuple[Moved, str]":
        n_modes = len(self.frequencies)
        if not 1 <= mode <= n_modes:
            raise ValueError(f"there is no mode {mode}: there are {n_modes}, counted from 1")
        from modallab_client import _shape_plot

        moving = _shape_plot.moved(layout, self.shapes[:, mode - 1], self.dofs)
        return moving, f"mode {mode}, {self.frequencies[mode - 1]:.4g} Hz"
