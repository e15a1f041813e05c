"""Imported element matrices and their degrees of freedom."""

from dataclasses import dataclass

from modallab.core.arrays import FloatArray, IntArray, frozen
from modallab.core.dof import Dof
from modallab.core.errors import StructureError, bounds


@dataclass(frozen=True, eq=False)
class Blocks:
    """Mass and stiffness of elements, block by block, and all degrees of freedom there are.

    Stiffness is in two parts, so that either can be corrected; undivided stiffness counts as axial.

    Raises
    ------
    InvalidInputError
        If the arrays do not fit together or a value is not finite.
    """

    dofs: tuple[Dof, ...]  # (n,)
    rows: IntArray  # (n_blocks, w) place among `dofs`, -1 behind the DoFs of a smaller block
    mass: FloatArray  # (n_blocks, w, w) kg, kg m, kg m^2; zero where `rows` is -1
    axial: FloatArray  # (n_blocks, w, w) N/m, N, N m
    bending: FloatArray | None  # (n_blocks, w, w); None: no block has two parts
    motions: FloatArray  # (n, k) candidates for rigid-body motions; the matrices decide

    def __post_init__(self) -> None:
        n_blocks, width = self.rows.shape
        object.__setattr__(self, "rows", frozen(self.rows, int, (n_blocks, width), name="rows"))
        for name in ("mass", "axial", "bending"):
            if (part := getattr(self, name)) is not None:
                object.__setattr__(self, name, frozen(part, float, (n_blocks, width, width), name=name))
        motions = frozen(self.motions, float, (len(self.dofs), None), name="motions")
        object.__setattr__(self, "motions", motions)
        if not ((self.rows >= -1) & (self.rows < len(self.dofs))).all():
            raise StructureError(
                "a block has a degree of freedom that the table lacks",
                field="rows",
                value=int(self.rows.max()),
                allowed=bounds(0, len(self.dofs) - 1),
            )
