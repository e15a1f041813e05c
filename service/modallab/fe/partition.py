"""Partition of a structure's matrices into master and slave degrees of freedom."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import LinearOperator, onenormest, splu

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.lowest_modes import count_below
from modallab.fe.modes import ModalBasis, first_basis, rigid_body_modes, undamped_basis
from modallab.fe.settings import EIGENSOLUTION, REDUCTION
from modallab.fe.system import DynamicSystem

StaticSolver = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Partition:
    """A system with the master DoFs of a reduction; all other DoFs are slaves."""

    system: DynamicSystem  # attachments are folded into the matrices
    masters: tuple[Dof, ...]

    @classmethod
    def of(cls, system: DynamicSystem, masters: tuple[Dof, ...]) -> "Partition":
        """Return the partition of a system, its attachments folded into the matrices.

        Raises
        ------
        UnknownDofError
            If the system has no such DoF.
        InvalidInputError
            If there are no masters, or one is named twice.
        """
        points = tuple(dof.point for dof in masters)
        if not points or len(set(points)) < len(points):
            raise InvalidInputError(
                "a reduction keeps at least one degree of freedom, and each of them once",
                field="masters",
                value=[str(dof) for dof in masters[:20]],
                allowed="one or more, no two alike",
            )
        for point in points:
            system.index(point)
        return cls(system.folded(), points)

    @cached_property
    def rows(self) -> IntArray:
        """(n_master,) rows of the masters."""
        return np.array([self.system.index(dof) for dof in self.masters])

    @cached_property
    def slaves(self) -> IntArray:
        """(n_slave,) all other rows, internal coordinates of attachments among them."""
        is_master = np.zeros(self.system.mass.shape[0], bool)
        is_master[self.rows] = True
        return np.flatnonzero(~is_master)

    def with_masters(self, slaves: FloatArray) -> FloatArray:
        """Return a transformation (n, n_master) from its rows at the slaves; masters follow themselves."""
        transformation = np.zeros((self.system.mass.shape[0], len(self.rows)))
        transformation[self.rows, np.arange(len(self.rows))] = 1.0
        transformation[self.slaves] = slaves
        return transformation

    def static(self) -> StaticSolver:
        """Return the static solver: slave displacements for forces on the slaves, masters fixed.

        Raises
        ------
        InvalidInputError
            If the slaves can move without strain while the masters are fixed.
        """
        bodies = rigid_body_modes(self.system.mass, self.system.stiffness, self.system.rigid)
        free = np.linalg.matrix_rank(
            bodies[self.rows], tol=REDUCTION.min_master_motion * np.abs(bodies).max(initial=1.0)
        )
        if free < bodies.shape[1]:
            raise self._loose(f"{bodies.shape[1] - free} of {bodies.shape[1]} rigid-body motions")
        return self._solver(0.0)

    def dynamic(self, omega: float) -> StaticSolver:
        """Return the solver of the slaves' dynamic stiffness at `omega`, rad/s; see `static`.

        Raises
        ------
        InvalidInputError
            If the slaves resonate there while the masters are fixed.
        """
        return self._solver(omega)

    def _solver(self, omega: float) -> StaticSolver:
        if not len(self.slaves):
            return lambda forces: forces
        block = np.ix_(self.slaves, self.slaves)
        k, m = (csc_array(csc_array(a)[block]) for a in (self.system.stiffness, self.system.mass))
        size = np.abs(k.diagonal()) + omega**2 * np.abs(m.diagonal())
        # Equilibration: rotations and translations differ by powers of the length unit.
        scale = 1 / np.sqrt(np.where(size > 0, size, 1.0))
        scaling = diags_array(scale)
        matrix = csc_array(scaling @ (k - omega**2 * m) @ scaling)
        try:
            factor = splu(matrix)
        except RuntimeError:  # a pivot of exactly zero
            raise self._unsolvable(omega) from None
        n = len(scale)
        inverse = LinearOperator(
            (n, n), matvec=factor.solve, rmatvec=lambda x: factor.solve(x, "T"), dtype=float
        )
        # t=1: with more columns the estimate starts from random ones.
        condition = onenormest(inverse, t=1) * float(abs(matrix).sum(axis=0).max())
        if not condition < REDUCTION.max_condition:  # NaN fails too
            raise self._unsolvable(omega)
        return lambda forces: scale[:, None] * factor.solve(scale[:, None] * forces)

    def _unsolvable(self, omega: float) -> InvalidInputError:
        if omega == 0:
            return self._loose("a part of it")
        frequency = omega / (2 * np.pi)
        return InvalidInputError(
            f"held at the masters the structure resonates at {frequency:.6g} Hz: no reduction there",
            field="reduction",
            value=frequency,
            allowed="a frequency between the resonances of the held structure",
        )

    def _loose(self, motions: str) -> InvalidInputError:
        return InvalidInputError(
            f"held at the {len(self.masters)} masters the structure can still move without strain "
            f"({motions}): the other degrees of freedom have no static answer",
            field="reduction",
            value=[str(dof) for dof in self.masters[:10]],
            allowed="masters that hold every rigid-body motion, `dynamic` above 0 Hz, or `serep`",
        )

    def lowest(self, count: int, highest: float = np.inf) -> ModalBasis:
        """Return rigid-body modes and undamped elastic ones: `count` or more, or all up to `highest`, Hz.

        At least one elastic mode; all modes of a small structure.
        """
        mass, stiffness, rigid = self.system.mass, self.system.stiffness, self.system.rigid
        if mass.shape[0] < EIGENSOLUTION.dense_dofs:
            return undamped_basis(mass, stiffness, rigid)
        if np.isfinite(highest):
            bodies = rigid_body_modes(mass, stiffness, rigid).shape[1]
            n_below = count_below(mass, stiffness, (2 * np.pi * highest) ** 2)
            count = min(count, max(n_below - bodies, 1)) if n_below is not None else count
        return first_basis(mass, stiffness, rigid, count)
