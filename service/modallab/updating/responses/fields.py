"""Displacement fields of a model: receptances at the measured lines and their derivatives."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.fe.damping import ModalDamping, StructuralDamping, ViscousDamping
from modallab.fe.lowest_modes import factorised
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.system import DynamicSystem
from modallab.updating.corrected_model import CorrectedModel
from modallab.updating.parameterisation import Part
from modallab.updating.responses.settings import RESPONSE_PATH
from modallab.updating.responses.target import TargetResponses
from modallab.updating.sensitivity import PartMatrices

Solve = Callable[[ComplexArray], ComplexArray]  # forces (n_lines, n, k) to motions, the same shape


@dataclass(frozen=True, eq=False)
class FieldDamping:
    """Damping terms of dZ: a and omega a' times mass, omega b' times stiffness."""

    mass: float  # a, rad^2/s^2
    viscous_mass: float  # a', 1/s
    viscous_stiffness: float  # b', s


@dataclass(frozen=True, eq=False)
class Fields:
    """Displacement fields of a model under unit forces at sensors and inputs."""

    lines: IntArray  # (n_lines,) indices into the lines of the target
    omega: FloatArray  # (n_lines,) rad/s
    to_outputs: ComplexArray  # (n_lines, n, n_out) m/N: Z^-1 S, for symmetric Z the transpose of S^T Z^-1
    driven: ComplexArray  # (n_lines, n, n_in) m/N
    receptance: ComplexArray  # (n_lines, n_out, n_in) m/N
    load: FloatArray  # (n_lines, n) N/m or N m: |K_jj| + omega^2 M_jj, scale of the force residual
    solve: Solve
    parts: tuple[PartMatrices, ...]
    law: FieldDamping

    def derivatives(self, motion: ComplexArray) -> ComplexArray:
        """Return -S^T Z^-1 (dZ/dp) u for a motion u and every coefficient, (n_lines, n_out, n_in, n_params).

        For the model's own motion these are the exact derivatives of its receptances.

        Parameters
        ----------
        motion
            (n_lines, n, n_in) m/N.
        """
        n_params = 1 + max(int(part.params.max()) for part in self.parts)
        derivative = np.zeros((*self.receptance.shape, n_params), complex)
        i_omega = 1j * self.omega[:, None, None, None]
        for part in self.parts:
            output_fields, motions = (_local(part.rows, field) for field in (self.to_outputs, motion))
            loads = part.matrices @ motions
            if part.part is Part.MASS:
                mass_damping = 0.0 if part.lossless else 1j * self.law.mass + i_omega * self.law.viscous_mass
                loads = loads * (i_omega**2 + mass_damping)
            elif self.law.viscous_stiffness and not part.lossless:
                loads = loads + i_omega * self.law.viscous_stiffness * (part.matrices.real @ motions)
            sums = np.add.reduceat(output_fields.swapaxes(2, 3) @ loads, part.starts[:-1], axis=1)
            derivative[..., part.params] -= np.moveaxis(sums, 1, 3)
        return derivative


class ResponseModel:
    """Structure, correction coefficients and measured responses of an update.

    Raises
    ------
    InvalidInputError
        If the structure has modal damping.
    UnknownDofError
        If the structure lacks a measured DoF.
    """

    def __init__(self, model: CorrectedModel, target: TargetResponses) -> None:
        structure = model.initial
        law = structure.damping
        if isinstance(law, ModalDamping):
            raise InvalidInputError(
                "damping of modes does not follow coefficients of members",
                field="damping",
                value=type(law).__name__,
                allowed=[StructuralDamping.__name__, ViscousDamping.__name__],
            )
        hysteretic = isinstance(law, StructuralDamping)
        by_mass, by_stiffness = law.mass_coefficient, law.stiffness_coefficient
        self._law = (
            FieldDamping(by_mass, 0.0, 0.0) if hysteretic else FieldDamping(0.0, by_mass, by_stiffness)
        )
        self.model, self.target, self.parameterisation = model, target, model.parameterisation
        self._outputs, self._inputs = (
            _columns([structure.index(dof) for dof in dofs], [dof.sign for dof in dofs], model.size)
            for dofs in (target.outputs, target.inputs)
        )
        translations = np.array([dof.translational for dof in structure.dofs])
        diagonal = np.abs(model.system(self.parameterisation.nominal).stiffness.diagonal())
        self.stiffness = float(
            np.median(diagonal[: len(translations)][translations])
        )  # N/m, of a translation

    def fields(self, values: FloatArray) -> Iterator[Fields]:
        """Yield the displacement fields at `values` (n_params,), in groups of lines that fit into memory."""
        system, parts = self.model.system(values), self.model.parts(values, damped=True)
        n, n_columns = self._outputs.shape[0], self._outputs.shape[1] + self._inputs.shape[1]
        step = max(1, RESPONSE_PATH.field_numbers // (n * (n if n < EIGENSOLUTION.dense_dofs else n_columns)))
        n_lines = len(self.target.freq)
        for lines in np.split(np.arange(n_lines), range(step, n_lines, step)):
            yield self._at(lines, system, parts)

    def receptance(self, values: FloatArray) -> ComplexArray:
        """Return the receptances at `values` (n_params,), (n_lines, n_out, n_in), m/N."""
        return np.concatenate([fields.receptance for fields in self.fields(values)])

    def _at(self, lines: IntArray, system: DynamicSystem, parts: tuple[PartMatrices, ...]) -> Fields:
        omega = 2 * np.pi * self.target.freq[lines]
        solve = solver(system, omega)
        forces = np.concatenate([self._outputs, self._inputs], axis=1)
        motions = solve(np.broadcast_to(forces, (len(omega), *forces.shape)))
        n_out = self._outputs.shape[1]
        driven = motions[:, :, n_out:]
        return Fields(
            lines=lines,
            omega=omega,
            to_outputs=motions[:, :, :n_out],
            driven=driven,
            receptance=np.asarray(self._outputs.T @ driven),
            load=np.abs(system.stiffness.diagonal()) + omega[:, None] ** 2 * system.mass.diagonal(),
            solve=solve,
            parts=parts,
            law=self._law,
        )


def solver(system: DynamicSystem, omega: FloatArray) -> Solve:
    """Return a solver of Z x = f at all lines: dense inverses, or a factorisation a line for large models."""
    empty = csc_array(system.stiffness.shape)
    damping, viscous = (empty if matrix is None else matrix for matrix in (system.damping, system.viscous))
    if len(system.dofs) < EIGENSOLUTION.dense_dofs:
        mass, stiffness, hysteretic_matrix, viscous_matrix = (
            matrix.toarray() for matrix in (system.mass, system.stiffness, damping, viscous)
        )
        w = omega[:, None, None]
        inverse = np.linalg.inv(stiffness + 1j * hysteretic_matrix + 1j * w * viscous_matrix - w**2 * mass)
        return lambda forces: np.asarray(inverse @ forces)
    factors = [
        factorised(csc_array(system.stiffness + 1j * damping + 1j * w * viscous - w**2 * system.mass))
        for w in omega
    ]
    return lambda forces: np.stack(
        [
            factor.solve(np.ascontiguousarray(right, complex))
            for factor, right in zip(factors, forces, strict=True)
        ]
    )


def _columns(rows: list[int], signs: list[int], n: int) -> ComplexArray:
    columns = np.zeros((n, len(rows)), complex)
    columns[rows, np.arange(len(rows))] = signs
    return columns


def _local(rows: IntArray, field: ComplexArray) -> ComplexArray:
    """Return a field (n_lines, n, k) at the DoFs of each element, (n_lines, n_used, w, k), 0 if supported."""
    zero_row = np.zeros((len(field), 1, field.shape[2]), complex)
    return np.concatenate([field, zero_row], axis=1)[:, rows]
