"""A model held against measured modes at given coefficients: what differs, and how it would move."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import FloatArray, IntArray
from modallab.core.errors import UnderdeterminedError
from modallab.correlation.mac import mac, pair_modes
from modallab.fe.assembly import Assembly, Coefficients, coefficients_of
from modallab.fe.modes import ModalBasis, modal_basis
from modallab.fe.structure import Structure
from modallab.fe.system import SMALL
from modallab.updating.parameterisation import Parameterisation, spread_over_members
from modallab.updating.sensitivity import derivatives, part_matrices
from modallab.updating.target import RealModes

REACH = 2.0  # modes of the model up to this multiple of the highest measured frequency may pair


@dataclass(frozen=True, eq=False)
class State:
    """The model at some coefficients, its modes paired with the measured ones."""

    values: FloatArray  # (n_params,)
    basis: ModalBasis
    modes: IntArray  # (n_modes,) column of the basis that pairs with each measured mode
    mac: FloatArray  # (n_modes,)
    difference: FloatArray  # (n_rows,) measured minus model: eigenvalues, then shapes DoF by DoF
    size: FloatArray  # (n_rows,) lambda_r for an eigenvalue, 1 for a shape: what balances the rows

    @property
    def frequencies(self) -> FloatArray:
        """(n_modes,) Hz, of the model."""
        return self.basis.frequencies[self.modes]

    @property
    def distance(self) -> float:
        """Root mean square of the balanced differences."""
        return float(np.sqrt(np.mean((self.difference / self.size) ** 2)))


class Fit:
    """A structure, the coefficients that may move, and the modes it should have."""

    def __init__(
        self, assembly: Assembly, parameterisation: Parameterisation, target: RealModes, min_mac: float
    ) -> None:
        self.parameterisation, self.target, self.min_mac = parameterisation, target, min_mac
        self._assembly = assembly
        structure = assembly.structure
        self._base = coefficients_of(structure)
        self._groups = parameterisation.groups(structure)
        self._parts = part_matrices(assembly, self._base, parameterisation)
        self._sensors = np.zeros((len(structure.dofs), len(target.dofs)))
        rows = [structure.index(dof) for dof in target.dofs]
        self._sensors[rows, np.arange(len(rows))] = [dof.sign for dof in target.dofs]
        n_params, n_rows = len(parameterisation.macros), len(target.squares) * (1 + len(target.dofs))
        if n_rows < n_params:
            raise UnderdeterminedError(
                f"{n_rows} measured numbers cannot determine {n_params} coefficients",
                field="macros",
                value=n_params,
                allowed=f"<= {n_rows}",
            )

    def coefficients(self, values: FloatArray) -> Coefficients:
        """Return what multiplies each member's parts at `values` (n_params,)."""
        return spread_over_members(self.parameterisation, self._groups, values, self._base)

    def structure(self, values: FloatArray) -> Structure:
        """Return the structure with its members corrected to `values` (n_params,)."""
        to = self.coefficients(values)
        members = tuple(
            replace(member, mass_factor=float(m), axial_factor=float(a), bending_factor=float(b))
            for member, m, a, b in zip(
                self._assembly.structure.members, to.mass, to.axial, to.bending, strict=True
            )
        )
        return replace(self._assembly.structure, members=members)

    def state(self, values: FloatArray) -> State:
        """Return the model at `values` (n_params,).

        Raises
        ------
        UnderdeterminedError
            If a measured mode pairs with none of the model.
        """
        target = self.target
        basis = self._modes(values)
        candidates = np.flatnonzero(basis.frequencies <= REACH * target.frequencies.max())
        candidates = candidates[candidates >= basis.n_rigid_body]
        shapes = self._sensors.T @ basis.shapes.real
        table = mac(target.shapes, shapes[:, candidates])
        partner = dict(pair_modes(table, self.min_mac))
        alone = [r for r in range(len(target.squares)) if r not in partner]
        if alone:
            raise UnderdeterminedError(
                f"measured mode {alone[0] + 1} pairs with no mode of the model",
                field="modes",
                value=alone[0] + 1,
                allowed=f"a MAC of {self.min_mac} with a mode of the model",
            )
        chosen = np.array([partner[r] for r in range(len(target.squares))])
        modes = candidates[chosen]
        own = shapes[:, modes]
        shape_difference = self._like(own) - own
        squares = basis.eigenvalues.real[modes]
        return State(
            values=values,
            basis=basis,
            modes=modes,
            mac=table[np.arange(len(chosen)), chosen],
            difference=np.concatenate([target.squares - squares, shape_difference.ravel()]),
            size=np.concatenate([squares, np.ones(shape_difference.size)]),
        )

    def sensitivity(self, state: State) -> FloatArray:
        """Return the derivatives of the model's rows, (n_rows, n_params)."""
        moved = derivatives(state.basis, state.modes, self._sensors, self._parts)
        return np.concatenate([moved.eigenvalues, moved.shapes.reshape(-1, moved.shapes.shape[2])])

    def _modes(self, values: FloatArray) -> ModalBasis:
        system = self._assembly.system(self.coefficients(values))
        all_modes = len(system.dofs) < SMALL
        limit = np.inf if all_modes else REACH * float(self.target.frequencies.max())
        return modal_basis(system.mass, system.stiffness, None, None, system.rigid, frequency_max=limit)

    def _like(self, own: FloatArray) -> FloatArray:
        """Return the measured shapes in the sense of the model's, in its scale if they have none."""
        measured = self.target.shapes
        along = (measured * own).sum(axis=0)
        if self.target.mass_normalised:
            return measured * np.where(along < 0, -1.0, 1.0)
        return np.asarray(measured * along / (measured**2).sum(axis=0))
