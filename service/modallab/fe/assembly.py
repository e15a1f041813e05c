"""Assembly of a structure's matrices from coefficients, with a fixed sparsity pattern."""

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.fe.damping import ModalDamping, StructuralDamping
from modallab.fe.held_dofs import HeldDofs
from modallab.fe.joint_rotations import JointRotations
from modallab.fe.losses import Losses
from modallab.fe.member_matrices import bar_of, member_matrices
from modallab.fe.member_table import MemberTable
from modallab.fe.members import AnyMember
from modallab.fe.modal_damping import ModalLossFactors
from modallab.fe.section_size import SectionSize, size_derivatives
from modallab.fe.shear import Shear
from modallab.fe.structure import ACROSS, Member, Structure
from modallab.fe.system import DynamicSystem


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Factors of each member's matrices, (n_members,) each; 1 leaves section and material as given."""

    mass: FloatArray
    axial: FloatArray
    bending: FloatArray
    loss_factor: FloatArray  # eta of D_e = eta K_e, not a multiple


def coefficients_of(structure: Structure) -> Coefficients:
    """Return the coefficients that a structure's members carry."""
    law = structure.damping
    common = law.stiffness_coefficient if isinstance(law, StructuralDamping) else 0.0
    members = structure.all_members
    return Coefficients(
        mass=np.array([m.mass_factor for m in members]),
        axial=np.array([m.axial_factor for m in members]),
        bending=np.array([m.bending_factor for m in members]),
        loss_factor=np.array([common if m.loss_factor is None else m.loss_factor for m in members]),
    )


class Assembly:
    """Element matrices of a structure in global axes, with the sparsity pattern of the assembled matrices.

    `mass`, `axial` and `bending` are (n_members, w, w); bars have w = 6, DoFs (X, Y, RZ) at each end. `rows`
    (n_members, w) has their row numbers in the system, -1 for a fixed DoF or a member with fewer DoFs.

    Parameters
    ----------
    joint_rotations
        True: joint rotations are rows of the system, after its DoFs. False: joints are left out, and
        `assemble` attaches them.
    """

    def __init__(self, structure: Structure, *, joint_rotations: bool = False) -> None:
        self.structure, self.members = structure, structure.all_members
        parts = member_matrices(structure)
        self.mass, self.axial, self.bending = parts.mass, parts.axial, parts.bending
        self.rows, self._bars = parts.rows, parts.bars
        n = self.size = len(structure.dofs)
        self.joint_rotations = (
            JointRotations(structure, self.rows.shape[1]) if joint_rotations and structure.joints else None
        )
        if self.joint_rotations is not None:
            n = self.size = self.size + len(structure.joints)
            all_members = np.arange(len(self.members))
            self.mass, self.axial, self.bending = (
                self.joint_rotations.widened(part, all_members)
                for part in (self.mass, self.axial, self.bending)
            )
            self.rows = self.joint_rotations.rows(self.rows, len(structure.dofs))
        grid_r = np.broadcast_to(self.rows[:, :, None], self.mass.shape)
        grid_c = np.broadcast_to(self.rows[:, None, :], self.mass.shape)
        self._in_system = (grid_r >= 0) & (grid_c >= 0)
        keys = np.concatenate([(grid_c * n + grid_r)[self._in_system], np.arange(n) * (n + 1)])
        unique, place = np.unique(keys, return_inverse=True)
        self._place: IntArray = place[:-n]
        self._diagonal: IntArray = place[-n:]
        self._indices = unique % n
        self._indptr = np.searchsorted(unique, np.arange(n + 1) * n)

    def resized(self, members: Mapping[int, AnyMember]) -> "Assembly":
        """Return the assembly with other sections or thicknesses of some members.

        Parameters
        ----------
        members
            Changed members by their index; their nodes are the same.
        """
        assembly, at = copy(self), list(members)
        resized_matrices = member_matrices(self.structure, list(members.values()), self._width)
        assembly.members = tuple(members.get(place, member) for place, member in enumerate(self.members))
        assembly.mass, assembly.axial, assembly.bending = (
            self.mass.copy(),
            self.axial.copy(),
            self.bending.copy(),
        )
        for matrices, new in (
            (assembly.mass, resized_matrices.mass),
            (assembly.axial, resized_matrices.axial),
            (assembly.bending, resized_matrices.bending),
        ):
            matrices[at] = self.widened(new, np.array(at))
        return assembly

    @property
    def _width(self) -> int:
        """Rows of a member without joint rotations."""
        return self.mass.shape[-1] if self.joint_rotations is None else self.joint_rotations.member_width

    def widened(self, parts: FloatArray, places: IntArray) -> FloatArray:
        """Return matrices (m, w, w) of members, by their index, with the rows of their joint rotations."""
        return parts if self.joint_rotations is None else self.joint_rotations.widened(parts, places)

    def size_derivatives(self, places: IntArray, shape: SectionSize) -> FloatArray:
        """Return derivatives of member matrices with respect to the logarithm of a size, (3, m, w, w).

        Of mass, axial and bending stiffness; see `shapes.size_derivatives`.
        """
        derivatives = size_derivatives(
            self.structure, [self.members[place] for place in places], shape, self._width
        )
        return np.array([self.widened(part, places) for part in derivatives])

    @cached_property
    def springs(self) -> FloatArray | float:
        """(n_members, w, w) N m/rad, stiffness of the joints at the joint rotations; 0 without any."""
        return 0.0 if self.joint_rotations is None else self.joint_rotations.springs(self.structure)

    def loaded(self, structure: Structure) -> "Assembly":
        """Return the assembly with the point masses and ground springs of a structure with the same DoFs."""
        assembly = copy(self)
        assembly.structure = structure
        for name in ("_point_masses", "_ground", "springs", "_held"):
            assembly.__dict__.pop(name, None)
        return assembly

    def matrix(self, parts: FloatArray, diagonal: FloatArray | None = None) -> csc_array:
        """Return the (n, n) sum of element matrices (n_members, w, w), plus a diagonal (n,)."""
        data = np.bincount(self._place, weights=parts[self._in_system], minlength=len(self._indices))
        if diagonal is not None:
            data[self._diagonal] = data[self._diagonal] + diagonal
        n = self.size
        return csc_array((data, self._indices, self._indptr), shape=(n, n))

    @cached_property
    def _point_masses(self) -> FloatArray:
        diagonal = np.zeros(self.size)
        for point in self.structure.masses:
            for i, dof in enumerate(self.structure.dofs):
                if dof.node == point.node and dof.translational:
                    diagonal[i] += point.mass
        return diagonal

    @cached_property
    def _ground(self) -> FloatArray:
        diagonal = np.zeros(self.size)
        for spring in self.structure.springs:
            diagonal[self.structure.index(spring.dof)] += spring.stiffness
        return diagonal

    def system(self, coefficients: Coefficients | None = None) -> DynamicSystem:
        """Return the assembled system.

        Parameters
        ----------
        coefficients
            Factors of each member's matrices; by default those of the structure's members.
        """
        factors = coefficients_of(self.structure) if coefficients is None else coefficients
        mass = factors.mass[:, None, None] * self.mass
        stiffness = factors.axial[:, None, None] * self.axial + factors.bending[:, None, None] * self.bending
        stiffness = stiffness + self.springs
        law = self.structure.damping
        losses = Losses.of(law, factors.loss_factor)
        damping, viscous = losses.matrices(mass, stiffness)
        table = MemberTable(
            numbers=tuple(m.number for m in self.structure.all_members),
            ends=tuple(m.nodes for m in self.structure.all_members),
            bars=self._bars,
            points=self._points,
            centres=self._centres,
            rows=self.rows,
            mass=mass,
            axial=factors.axial[:, None, None] * self.axial,
            bending=factors.bending[:, None, None] * self.bending,
            losses=losses,
            law=law,
            shear=self._shear(factors),
            held=self._held,
        )
        return DynamicSystem(
            mass=self.matrix(mass, self._point_masses),
            stiffness=self.matrix(stiffness, self._ground),
            damping=self.matrix(damping) if damping.any() else None,
            viscous=self.matrix(viscous) if viscous.any() else None,
            dofs=self.structure.dofs,
            rigid=np.pad(self._rigid_shapes, ((0, self.size - len(self.structure.dofs)), (0, 0))),
            members=table,
            modal=ModalLossFactors(law.loss_factors) if isinstance(law, ModalDamping) else None,
        )

    @cached_property
    def _held(self) -> HeldDofs:
        return HeldDofs.of(self.structure, self.rows.shape[1])

    @cached_property
    def _points(self) -> FloatArray:
        """(n_members, 2, 2) m, x and y of each end of a bar; of another member a bar of length 1."""
        nodes = self.structure.nodes
        unit_bar = np.array([[0.0, 0.0], [1.0, 0.0]])
        return np.array(
            [
                [nodes[n] for n in m.nodes] if isinstance(m, Member) else unit_bar
                for m in self.structure.all_members
            ]
        )

    @cached_property
    def _centres(self) -> FloatArray:
        """(n_members, 2 or 3) m, mean of each member's nodes."""
        nodes, members = self.structure.nodes, self.structure.all_members
        return np.array([np.mean([nodes[n] for n in member.nodes], axis=0) for member in members])

    def _shear(self, factors: Coefficients) -> Shear:
        n = len(self.members)
        rigidity, line_mass, flexibility, gyration = np.zeros((4, n))
        for i, member in enumerate(self.members):
            if not isinstance(member, Member):
                continue
            bar = bar_of(self.structure, member)
            rigidity[i] = bar.modulus * bar.second_moment
            line_mass[i] = bar.density * bar.area
            if member.element == "frame":
                flexibility[i] = bar.shear_flexibility
                gyration[i] = bar.second_moment / bar.area
        return Shear(
            points=self._points,
            rigidity=factors.bending * rigidity,
            line_mass=factors.mass * line_mass,
            flexibility=flexibility,
            gyration=gyration,
            amount=np.zeros(n),
        )

    @cached_property
    def _rigid_shapes(self) -> FloatArray:
        """Return the (n, n_rigid) rigid-body motions of the geometry; they may strain springs to ground."""
        structure = self.structure
        if structure.blocks:
            place = {dof: i for i, dof in enumerate(structure.blocks.dofs)}
            return structure.blocks.motions[[place[dof] for dof in structure.dofs]]
        free_rows: list[tuple[float, ...]] = []
        fixed_rows: list[tuple[float, ...]] = []
        x0, y0 = np.mean(list(structure.nodes.values()), axis=0)
        free_dofs = set(structure.dofs)
        across = any(dof.direction in ACROSS for dof in free_dofs)
        for node, (x, y) in structure.nodes.items():
            rows = _rigid_rows_across(x - x0, y - y0) if across else _rigid_rows_in_plane(x - x0, y - y0)
            for direction, row in rows.items():
                (free_rows if Dof(node, direction) in free_dofs else fixed_rows).append(row)
        shapes = np.array(free_rows)
        if fixed_rows:
            _, values, vh = np.linalg.svd(np.array(fixed_rows), full_matrices=True)
            rank = int((values > COMPARISON_ROUNDING * values[0]).sum()) if values[0] > 0 else 0
            shapes = shapes @ vh[rank:].T
        return shapes


def _rigid_rows_in_plane(x: float, y: float) -> dict[str, tuple[float, ...]]:
    """Return a node's rigid-body motion in the plane, by direction: along X, along Y, about Z."""
    return {"X": (1.0, 0.0, -y), "Y": (0.0, 1.0, x), "RZ": (0.0, 0.0, 1.0)}


def _rigid_rows_across(x: float, y: float) -> dict[str, tuple[float, ...]]:
    """Return a node's rigid-body motion across the plane, by direction: along Z, about X, about Y."""
    return {"Z": (1.0, y, -x), "RX": (0.0, 1.0, 0.0), "RY": (0.0, 0.0, 1.0)}


def assemble(structure: Structure, coefficients: Coefficients | None = None) -> DynamicSystem:
    """Return the assembled system of a structure; see `Assembly` for repeated assembly."""
    system = Assembly(structure).system(coefficients)
    for joint in structure.joints:
        system = system.add_joint(joint.node, 1 / joint.stiffness)
    return system
