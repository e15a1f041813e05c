"""Structure and coefficients to matrices, by a sparsity pattern that is found once."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.fe.damping import ModalDamping, StructuralDamping
from modallab.fe.element import ELEMENTS, Bar, ElementParts
from modallab.fe.losses import Losses
from modallab.fe.member_table import MemberTable
from modallab.fe.modal_damping import ModalLoss
from modallab.fe.shear import Shear
from modallab.fe.structure import PLANE, Material, Section, Structure
from modallab.fe.system import DynamicSystem


@dataclass(frozen=True, eq=False)
class Coefficients:
    """What multiplies each member's parts, (n_members,) each; 1 leaves section and material as given."""

    mass: FloatArray
    axial: FloatArray
    bending: FloatArray
    loss_factor: FloatArray  # eta of D_e = eta K_e, not a multiple


def coefficients_of(structure: Structure) -> Coefficients:
    """Return the coefficients that a structure's members carry."""
    law = structure.damping
    common = law.stiffness_coefficient if isinstance(law, StructuralDamping) else 0.0
    members = structure.members
    return Coefficients(
        mass=np.array([m.mass_factor for m in members]),
        axial=np.array([m.axial_factor for m in members]),
        bending=np.array([m.bending_factor for m in members]),
        loss_factor=np.array([common if m.loss_factor is None else m.loss_factor for m in members]),
    )


@lru_cache(maxsize=512)
def _parts(element: str, bar: Bar) -> ElementParts:
    return ELEMENTS[element](bar)


def _bar(length: float, section: Section, material: Material) -> Bar:
    return Bar(
        length,
        section.area,
        section.second_moment,
        material.modulus,
        material.density,
        material.shear_modulus,
        section.shear_coefficient,
    )


class Assembly:
    """The element matrices of a structure in global axes and the pattern they add up in.

    `mass`, `axial`, `bending` are (n_members, 6, 6), DoFs (X, Y, RZ) at each end; `rows`
    (n_members, 6) gives their place in the system, -1 where a DoF is held.
    """

    def __init__(self, structure: Structure) -> None:
        self.structure = structure
        self.mass, self.axial, self.bending = self._global_parts()
        index = {(d.node, d.direction): i for i, d in enumerate(structure.dofs)}
        self.rows: IntArray = np.array(
            [[index.get((n, d), -1) for n in m.nodes for d in PLANE] for m in structure.members]
        )
        n = len(structure.dofs)
        grid_r = np.broadcast_to(self.rows[:, :, None], self.mass.shape)
        grid_c = np.broadcast_to(self.rows[:, None, :], self.mass.shape)
        self._kept = (grid_r >= 0) & (grid_c >= 0)
        keys = np.concatenate([(grid_c * n + grid_r)[self._kept], np.arange(n) * (n + 1)])
        unique, place = np.unique(keys, return_inverse=True)
        self._place: IntArray = place[:-n]
        self._diagonal: IntArray = place[-n:]
        self._indices = unique % n
        self._indptr = np.searchsorted(unique, np.arange(n + 1) * n)

    def _global_parts(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        structure = self.structure
        local, turns = [], []
        for member in structure.members:
            start, end = (np.array(structure.nodes[n]) for n in member.nodes)
            length = structure.length(member)
            c, s = (end - start) / length
            turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
            turns.append(np.kron(np.eye(2), turn))
            section, material = member.section, member.material
            local.append(_parts(member.element, _bar(length, section, material)))
        t = np.array(turns)

        def turned(parts: list[FloatArray]) -> FloatArray:
            return np.asarray(t.swapaxes(1, 2) @ np.array(parts) @ t)

        return (
            turned([p.mass for p in local]),
            turned([p.stiffness["axial"] for p in local]),
            turned([p.stiffness["bending"] for p in local]),
        )

    def matrix(self, parts: FloatArray, diagonal: FloatArray | None = None) -> csc_array:
        """Return the (n, n) sum of element matrices (n_members, 6, 6), plus a diagonal (n,)."""
        data = np.bincount(self._place, weights=parts[self._kept], minlength=len(self._indices))
        if diagonal is not None:
            data[self._diagonal] = data[self._diagonal] + diagonal
        n = len(self.structure.dofs)
        return csc_array((data, self._indices, self._indptr), shape=(n, n))

    @cached_property
    def _point_masses(self) -> FloatArray:
        diagonal = np.zeros(len(self.structure.dofs))
        for point in self.structure.masses:
            for i, dof in enumerate(self.structure.dofs):
                if dof.node == point.node and dof.translational:
                    diagonal[i] += point.mass
        return diagonal

    @cached_property
    def _ground(self) -> FloatArray:
        diagonal = np.zeros(len(self.structure.dofs))
        for spring in self.structure.springs:
            diagonal[self.structure.index(spring.dof)] += spring.stiffness
        return diagonal

    def system(self, coefficients: Coefficients | None = None) -> DynamicSystem:
        """Return the assembled system.

        Parameters
        ----------
        coefficients
            What multiplies each member's parts; by default what the structure's members carry.
        """
        use = coefficients_of(self.structure) if coefficients is None else coefficients
        mass = use.mass[:, None, None] * self.mass
        stiffness = use.axial[:, None, None] * self.axial + use.bending[:, None, None] * self.bending
        law = self.structure.damping
        losses = Losses.of(law, use.loss_factor)
        damping, viscous = losses.matrices(mass, stiffness)
        table = MemberTable(
            numbers=tuple(m.number for m in self.structure.members),
            ends=tuple(m.nodes for m in self.structure.members),
            points=np.array([[self.structure.nodes[n] for n in m.nodes] for m in self.structure.members]),
            rows=self.rows,
            mass=mass,
            axial=use.axial[:, None, None] * self.axial,
            bending=use.bending[:, None, None] * self.bending,
            losses=losses,
            law=law,
            shear=self._shear(use),
        )
        return DynamicSystem(
            mass=self.matrix(mass, self._point_masses),
            stiffness=self.matrix(stiffness, self._ground),
            damping=self.matrix(damping) if damping.any() else None,
            viscous=self.matrix(viscous) if viscous.any() else None,
            dofs=self.structure.dofs,
            rigid=self._rigid_shapes,
            members=table,
            modal=ModalLoss(law.loss_factors) if isinstance(law, ModalDamping) else None,
        )

    def _shear(self, use: Coefficients) -> Shear:
        structure = self.structure
        bars = [_bar(structure.length(m), m.section, m.material) for m in structure.members]
        lacking = np.array([m.element == "frame" for m in structure.members])
        return Shear(
            points=np.array([[structure.nodes[n] for n in m.nodes] for m in structure.members]),
            rigidity=use.bending * [bar.modulus * bar.second_moment for bar in bars],
            line_mass=use.mass * [bar.density * bar.area for bar in bars],
            flexibility=lacking * [bar.shear_flexibility for bar in bars],
            gyration=lacking * [bar.second_moment / bar.area for bar in bars],
            amount=np.zeros(len(bars)),
        )

    @cached_property
    def _rigid_shapes(self) -> FloatArray:
        """Return the (n, n_rigid) motions of the geometry that strain nothing but springs to ground."""
        structure = self.structure
        free: list[tuple[float, ...]] = []
        held: list[tuple[float, ...]] = []
        x0, y0 = np.mean(list(structure.nodes.values()), axis=0)
        known = set(structure.dofs)
        for node, (x, y) in structure.nodes.items():
            rows = {"X": (1.0, 0.0, y0 - y), "Y": (0.0, 1.0, x - x0), "RZ": (0.0, 0.0, 1.0)}
            for direction, row in rows.items():
                (free if Dof(node, direction) in known else held).append(row)
        shapes = np.array(free)
        if held:
            _, values, vh = np.linalg.svd(np.array(held), full_matrices=True)
            rank = int((values > 1e-9 * values[0]).sum()) if values[0] > 0 else 0
            shapes = shapes @ vh[rank:].T
        return shapes


def assemble(structure: Structure, coefficients: Coefficients | None = None) -> DynamicSystem:
    """Return the assembled system of a structure; see `Assembly` to assemble again and again."""
    return Assembly(structure).system(coefficients)
