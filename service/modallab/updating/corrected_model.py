"""Corrected model: matrices, their derivatives and the structure at given coefficients."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.fe.assembly import Assembly, Coefficients, coefficients_of
from modallab.fe.members import AnyMember
from modallab.fe.section_size import resized, size
from modallab.fe.structure import Structure
from modallab.fe.system import DynamicSystem
from modallab.updating.nodal_elements import node_matrices, with_scaled_nodes
from modallab.updating.parameterisation import Parameterisation, Part, member_coefficients
from modallab.updating.sensitivity import PartMatrices, elements_of_part, part_matrices


class CorrectedModel:
    """Structure whose matrices, loss factors and properties depend on coefficients.

    Raises
    ------
    InvalidInputError
        If the structure lacks a member, or a member a property.
    """

    def __init__(self, assembly: Assembly, parameterisation: Parameterisation) -> None:
        self.parameterisation, self._assembly = parameterisation, assembly
        self._base = coefficients_of(assembly.structure)
        self._groups = parameterisation.groups(assembly.structure)
        self._cached_parts: tuple[PartMatrices, ...] | None = None

    @property
    def size(self) -> int:
        """Size of the model's matrices: its degrees of freedom, and joint rotations behind them."""
        return self._assembly.size

    @property
    def initial(self) -> Structure:
        """Structure without correction."""
        return self._assembly.structure

    def coefficients(self, values: FloatArray) -> Coefficients:
        """Return the factors of each member's matrices at `values` (n_params,), without sizes."""
        return member_coefficients(self.parameterisation, self._groups, values, self._base)

    def assembly(self, values: FloatArray) -> Assembly:
        """Return the element matrices at `values` (n_params,), without factors."""
        members = self._resized_members(values)
        assembly = self._assembly.resized(members) if members else self._assembly
        structure = self._with_nodal_values(values)
        return assembly if structure is self.initial else assembly.loaded(structure)

    def system(self, values: FloatArray) -> DynamicSystem:
        """Return the model's matrices at `values` (n_params,)."""
        return self.assembly(values).system(self.coefficients(values))

    def structure(self, values: FloatArray) -> Structure:
        """Return the structure corrected to `values` (n_params,).

        A negative loss factor, which no member can have, becomes zero.
        """
        coefficients = self.coefficients(values)
        is_corrected = coefficients.loss_factor != self._base.loss_factor
        return self._with_nodal_values(values).of_members(
            replace(
                member,
                mass_factor=float(m),
                axial_factor=float(a),
                bending_factor=float(b),
                loss_factor=max(float(eta), 0.0) if has_new_loss else member.loss_factor,
            )
            for member, m, a, b, eta, has_new_loss in zip(
                self.assembly(values).members,
                coefficients.mass,
                coefficients.axial,
                coefficients.bending,
                coefficients.loss_factor,
                is_corrected,
                strict=True,
            )
        )

    def count_negative_loss_factors(self, values: FloatArray, tolerance: float) -> int:
        """Return the number of members with a negative loss factor at `values` (n_params,)."""
        return int((self.coefficients(values).loss_factor < -tolerance).sum())

    def parts(self, values: FloatArray, *, damped: bool = False) -> tuple[PartMatrices, ...]:
        """Return derivatives of M and of K, or K + iD, at the coefficients `values` (n_params,).

        Without damping and properties they are the same at any coefficients, and cached.
        """
        if self._cached_parts is not None:
            return self._cached_parts
        coefficients, assembly = self.coefficients(values), self.assembly(values)
        matrices = part_matrices(
            assembly, self._base, self.parameterisation, coefficients if damped else None
        )
        property_parts = [part for part in self.parameterisation.parts if part.is_property]
        for part in property_parts:
            matrices += self._property_matrices(part, assembly, coefficients, values, damped=damped)
        nodal_parts = [part for part in self.parameterisation.parts if part.is_nodal]
        matrices += tuple(
            self._nodal_matrices(part) for part in nodal_parts if part is not Part.JOINT_STIFFNESS
        )
        if Part.JOINT_STIFFNESS in nodal_parts:
            matrices += (self._joint_matrices(assembly, coefficients if damped else None),)
        if not damped and not property_parts:
            self._cached_parts = matrices
        return matrices

    def _resized_members(self, values: FloatArray) -> Mapping[int, AnyMember]:
        """Return the members with corrected sizes, by index among all."""
        members: dict[int, AnyMember] = {}
        for macro, row, value in zip(self.parameterisation.macros, self._groups, values, strict=True):
            if (shape := macro.part.section_size) is not None:
                for place in np.flatnonzero(row):
                    member = members.get(int(place), self._assembly.members[place])
                    members[int(place)] = resized(member, shape, value * size(member, shape))
        return members

    def _with_nodal_values(self, values: FloatArray) -> Structure:
        """Return the structure with nodal values at `values` (n_params,), and its initial members."""
        structure = self.initial
        for macro, value in zip(self.parameterisation.macros, values, strict=True):
            if macro.part.is_nodal:
                structure = with_scaled_nodes(structure, macro.part, macro.members, float(value))
        return structure

    def _nodal_matrices(self, part: Part) -> PartMatrices:
        """Return derivatives with respect to coefficients of nodal masses and springs."""
        params = [i for i, macro in enumerate(self.parameterisation.macros) if macro.part is part]
        groups = [self.parameterisation.macros[i].members for i in params]
        matrices, rows = node_matrices(self.initial, part, [node for group in groups for node in group])
        kind = Part.MASS if part is Part.POINT_MASS else Part.STIFFNESS
        starts = np.cumsum([0, *map(len, groups)])
        return PartMatrices(kind, matrices, rows, starts, np.array(params), lossless=True)

    def _joint_matrices(self, assembly: Assembly, damped: Coefficients | None) -> PartMatrices:
        """Return derivatives with respect to joint coefficients; a joint has the loss factor of its member.

        Parameters
        ----------
        damped
            Coefficients of a damped model, None without damping.
        """
        assert assembly.joint_rotations is not None
        place = {joint.node: i for i, joint in enumerate(self.initial.joints)}
        macros = self.parameterisation.macros
        params = [i for i, macro in enumerate(macros) if macro.part is Part.JOINT_STIFFNESS]
        used = np.array([place[node] for i in params for node in macros[i].members])
        stiffnesses = np.array([joint.stiffness for joint in self.initial.joints])[used]
        stiffness: FloatArray | ComplexArray = stiffnesses[:, None, None]
        if damped is not None:
            loss_factor = damped.loss_factor[assembly.joint_rotations.members[used]]
            stiffness = np.asarray((1 + 1j * loss_factor[:, None, None]) * stiffness, complex)
        starts = np.cumsum([0, *(len(macros[i].members) for i in params)])
        rows = (len(self.initial.dofs) + used)[:, None]
        return PartMatrices(Part.STIFFNESS, stiffness, rows, starts, np.array(params))

    def _property_matrices(
        self, part: Part, assembly: Assembly, coefficients: Coefficients, values: FloatArray, *, damped: bool
    ) -> tuple[PartMatrices, ...]:
        """Return derivatives of mass and stiffness with respect to a property: dX/dp = (dX / d log p) / p."""
        used, starts, params = elements_of_part(self.parameterisation, part, self._groups)
        if part.section_size is not None:
            mass, axial, bending = assembly.size_derivatives(used, part.section_size)
        else:
            mass, axial, bending = assembly.mass[used], assembly.axial[used], assembly.bending[used]
        inverse_value = np.repeat(1 / values[params], np.diff(starts))[:, None, None]
        axial_by, bending_by = (
            factor[used, None, None] for factor in (coefficients.axial, coefficients.bending)
        )
        stiffness: FloatArray | ComplexArray = (axial_by * axial + bending_by * bending) * inverse_value
        if damped:
            stiffness = np.asarray((1 + 1j * coefficients.loss_factor[used, None, None]) * stiffness, complex)
        inertia = coefficients.mass[used, None, None] * mass * inverse_value
        matrices = []
        if part is not Part.MODULUS:
            matrices.append(PartMatrices(Part.MASS, inertia, assembly.rows[used], starts, params))
        if part is not Part.DENSITY:
            matrices.append(PartMatrices(Part.STIFFNESS, stiffness, assembly.rows[used], starts, params))
        return tuple(matrices)
