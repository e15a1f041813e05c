"""A model at any coefficients: its matrices, how these move, and the structure they are of."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.fe.assembly import Assembly, Coefficients, coefficients_of
from modallab.fe.members import AnyMember
from modallab.fe.section_size import resized, size
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.updating.nodal_elements import multiplied, node_matrices
from modallab.updating.parameterisation import Parameterisation, Part, spread_over_members
from modallab.updating.sensitivity import PartMatrices, moved_by, part_matrices


class CorrectedModel:
    """A structure whose members' matrices, loss factors and properties move with coefficients.

    Raises
    ------
    InvalidInputError
        If the structure lacks a member, or a member a property.
    """

    def __init__(self, assembly: Assembly, parameterisation: Parameterisation) -> None:
        self.parameterisation, self._assembly = parameterisation, assembly
        self._base = coefficients_of(assembly.structure)
        self._groups = parameterisation.groups(assembly.structure)
        self._constant: tuple[PartMatrices, ...] | None = None

    @property
    def size(self) -> int:
        """Rows of the model's matrices: its degrees of freedom, and jumps at joints behind them."""
        return self._assembly.size

    @property
    def initial(self) -> Structure:
        """The structure without any correction."""
        return self._assembly.structure

    def coefficients(self, values: FloatArray) -> Coefficients:
        """Return what multiplies each member's parts at `values` (n_params,), their sizes left out."""
        return spread_over_members(self.parameterisation, self._groups, values, self._base)

    def assembly(self, values: FloatArray) -> Assembly:
        """Return the element matrices at `values` (n_params,), coefficients left out."""
        members = self._members(values)
        assembly = self._assembly.resized(members) if members else self._assembly
        attached = self._attached(values)
        return assembly if attached is self.initial else assembly.loaded(attached)

    def system(self, values: FloatArray) -> DynamicSystem:
        """Return the model's matrices at `values` (n_params,)."""
        return self.assembly(values).system(self.coefficients(values))

    def structure(self, values: FloatArray) -> Structure:
        """Return the structure with its members corrected to `values` (n_params,).

        A loss factor below zero, which no member can have, becomes zero.
        """
        to = self.coefficients(values)
        moved = to.loss_factor != self._base.loss_factor
        return self._attached(values).of_members(
            replace(
                member,
                mass_factor=float(m),
                axial_factor=float(a),
                bending_factor=float(b),
                loss_factor=max(float(eta), 0.0) if changed else member.loss_factor,
            )
            for member, m, a, b, eta, changed in zip(
                self.assembly(values).members,
                to.mass,
                to.axial,
                to.bending,
                to.loss_factor,
                moved,
                strict=True,
            )
        )

    def losses_below_zero(self, values: FloatArray, tolerance: float) -> int:
        """Return how many members have a loss factor below zero at `values` (n_params,)."""
        return int((self.coefficients(values).loss_factor < -tolerance).sum())

    def parts(self, values: FloatArray, *, damped: bool = False) -> tuple[PartMatrices, ...]:
        """Return derivatives of M and of K, or K + iD, by the coefficients at `values` (n_params,).

        Without damping and properties they are the same wherever the coefficients stand.
        """
        if self._constant is not None:
            return self._constant
        now, assembly = self.coefficients(values), self.assembly(values)
        found = part_matrices(assembly, self._base, self.parameterisation, now if damped else None)
        physical = [part for part in self.parameterisation.parts if part.physical]
        for part in physical:
            found += self._property(part, assembly, now, values, damped=damped)
        at_nodes = [part for part in self.parameterisation.parts if part.at_node]
        found += tuple(self._at_nodes(part) for part in at_nodes if part is not Part.JOINT_STIFFNESS)
        if Part.JOINT_STIFFNESS in at_nodes:
            found += (self._joints(assembly, now if damped else None),)
        if not damped and not physical:
            self._constant = found
        return found

    def _members(self, values: FloatArray) -> Mapping[int, AnyMember]:
        """Return the members whose sizes move, by their place among all."""
        members: dict[int, AnyMember] = {}
        for macro, row, value in zip(self.parameterisation.macros, self._groups, values, strict=True):
            if (shape := macro.part.shape) is not None:
                for place in np.flatnonzero(row):
                    member = members.get(int(place), self._assembly.members[place])
                    members[int(place)] = resized(member, shape, value * size(member, shape))
        return members

    def _attached(self, values: FloatArray) -> Structure:
        """Return the structure with what its nodes carry at `values` (n_params,), and its old members."""
        structure = self.initial
        for macro, value in zip(self.parameterisation.macros, values, strict=True):
            if macro.part.at_node:
                structure = multiplied(structure, macro.part, macro.members, float(value))
        return structure

    def _at_nodes(self, part: Part) -> PartMatrices:
        """Return derivatives by coefficients of what nodes carry: the matrices of it."""
        params = [i for i, macro in enumerate(self.parameterisation.macros) if macro.part is part]
        groups = [self.parameterisation.macros[i].members for i in params]
        matrices, rows = node_matrices(self.initial, part, [node for group in groups for node in group])
        kind = Part.MASS if part is Part.POINT_MASS else Part.STIFFNESS
        starts = np.cumsum([0, *map(len, groups)])
        return PartMatrices(kind, matrices, rows, starts, np.array(params), lossless=True)

    def _joints(self, assembly: Assembly, damped: Coefficients | None) -> PartMatrices:
        """Return derivatives by coefficients of joints, which lose what the member does that they hold.

        Parameters
        ----------
        damped
            Where a damped model stands.
        """
        assert assembly.jumps is not None
        place = {joint.node: i for i, joint in enumerate(self.initial.joints)}
        macros = self.parameterisation.macros
        params = [i for i, macro in enumerate(macros) if macro.part is Part.JOINT_STIFFNESS]
        used = np.array([place[node] for i in params for node in macros[i].members])
        own = np.array([joint.stiffness for joint in self.initial.joints])[used]
        stiffness: FloatArray | ComplexArray = own[:, None, None]
        if damped is not None:
            lost = damped.loss_factor[assembly.jumps.members[used]]
            stiffness = np.asarray((1 + 1j * lost[:, None, None]) * stiffness, complex)
        starts = np.cumsum([0, *(len(macros[i].members) for i in params)])
        rows = (len(self.initial.dofs) + used)[:, None]
        return PartMatrices(Part.STIFFNESS, stiffness, rows, starts, np.array(params))

    def _property(
        self, part: Part, assembly: Assembly, now: Coefficients, values: FloatArray, *, damped: bool
    ) -> tuple[PartMatrices, ...]:
        """Return derivatives by a property: dX/dp = (dX / d log p) / p, of mass and of stiffness."""
        used, starts, params = moved_by(self.parameterisation, part, self._groups)
        if part.shape is not None:
            mass, axial, bending = assembly.slopes(used, part.shape)
        else:
            mass, axial, bending = assembly.mass[used], assembly.axial[used], assembly.bending[used]
        over = np.repeat(1 / values[params], np.diff(starts))[:, None, None]
        axial_by, bending_by = (factor[used, None, None] for factor in (now.axial, now.bending))
        stiffness: FloatArray | ComplexArray = (axial_by * axial + bending_by * bending) * over
        if damped:
            stiffness = np.asarray((1 + 1j * now.loss_factor[used, None, None]) * stiffness, complex)
        inertia = now.mass[used, None, None] * mass * over
        halves = []
        if part is not Part.MODULUS:
            halves.append(PartMatrices(Part.MASS, inertia, assembly.rows[used], starts, params))
        if part is not Part.DENSITY:
            halves.append(PartMatrices(Part.STIFFNESS, stiffness, assembly.rows[used], starts, params))
        return tuple(halves)
