"""Residuals between measured modes and those of a model, with their derivatives."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError, UnderdeterminedError, bounds
from modallab.correlation.mac import mac, pair_modes
from modallab.fe.assembly import Assembly
from modallab.fe.damping import StructuralDamping
from modallab.fe.modes import ModalBasis, modal_basis
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.structure import Structure
from modallab.updating.corrected_model import CorrectedModel
from modallab.updating.parameterisation import Parameterisation, check_no_loss_factors
from modallab.updating.sensitivity import derivatives
from modallab.updating.settings import PAIRING
from modallab.updating.target import TargetModes


class Balance(StrEnum):
    """Rows that are divided by their own size; 1992 thesis, eq. [3.22]."""

    EIGENVALUES = "eigenvalues"
    BOTH = "both"


@dataclass(frozen=True, eq=False)
class ModelState:
    """Model at given coefficients, with its modes paired with the measured ones."""

    values: FloatArray
    """Coefficients (n_params,)."""
    basis: ModalBasis
    modes: IntArray
    """(n_modes,) column of the basis that pairs with each measured mode."""
    mac: FloatArray
    """Modal assurance criterion of each pair (n_modes,)."""
    rotation: FloatArray
    """Orthogonal (n_modes, n_modes), takes shapes of repeated modes to the measured ones."""
    difference: FloatArray
    """(n_rows,) measured minus model: eigenvalues, then shapes DoF by DoF; of damped modes all real parts,
    then all imaginary parts.
    """
    size: FloatArray
    """(n_rows,) scale of each row: Re lambda_r for an eigenvalue, 1 or the norm of the shape for a shape."""

    @property
    def frequencies(self) -> FloatArray:
        """(n_modes,) Hz, natural frequencies of the paired modes of the model."""
        return self.basis.frequencies[self.modes]

    @property
    def distance(self) -> float:
        """Root mean square of the balanced differences."""
        return float(np.sqrt(np.mean((self.difference / self.size) ** 2)))


class ModalResiduals:
    """Structure, correction coefficients and measured modes of an update.

    Real modes are compared with the undamped model, damped modes with the damped one.

    Raises
    ------
    InvalidInputError
        If loss factors are to be found from real modes, or the damping of the structure is not hysteretic
        and the modes are damped.
    UnderdeterminedError
        If there are fewer measured numbers than coefficients, unless `regularised`.
    """

    def __init__(
        self,
        assembly: Assembly,
        parameterisation: Parameterisation,
        target: TargetModes,
        min_mac: float,
        *,
        regularised: bool = False,
        balance: Balance = Balance.EIGENVALUES,
    ) -> None:
        self.parameterisation, self.target, self.min_mac = parameterisation, target, min_mac
        self.model = CorrectedModel(assembly, parameterisation)
        structure = assembly.structure
        self._planes = () if target.damped else target.repeated_modes
        self._row_mask, self._balance = target.row_mask, balance
        self._mass_loss = 0.0
        self._latest: FloatArray | None = None  # modes of the last model, as start vectors of the next
        if target.damped:
            self._mass_loss = _mass_loss(structure)
        else:
            check_no_loss_factors(parameterisation)
        self._sensors = np.zeros((self.model.size, len(target.dofs)))
        rows = [structure.index(dof) for dof in target.dofs]
        self._sensors[rows, np.arange(len(rows))] = [dof.sign for dof in target.dofs]
        n_params, n_rows = len(parameterisation.macros), target.n_rows
        if n_rows < n_params and not regularised:
            raise UnderdeterminedError(
                f"{n_rows} measured numbers cannot determine {n_params} coefficients",
                field="macros",
                value=n_params,
                allowed=bounds(maximum=n_rows),
            )

    def errors(self, state: ModelState) -> FloatArray | None:
        """Return standard errors of balanced rows (n_rows,), None where the modes state none."""
        target = self.target
        if target.errors is None:
            return None
        eigenvalues = np.arange(len(self._row_mask)) % (len(target.squares) * (1 + len(target.dofs)))
        is_eigenvalue = (eigenvalues < len(target.squares))[self._row_mask]
        return target.errors[self._row_mask] / np.where(is_eigenvalue, 1.0, state.size)

    def structure(self, values: FloatArray) -> Structure:
        """Return the structure with its members corrected to `values` (n_params,)."""
        return self.model.structure(values)

    def count_negative_loss_factors(self, values: FloatArray, tolerance: float) -> int:
        """Return the number of members with a negative loss factor at `values` (n_params,)."""
        return self.model.count_negative_loss_factors(values, tolerance)

    def state(self, values: FloatArray) -> ModelState:
        """Return the model at `values` (n_params,), with its modes paired.

        Raises
        ------
        UnderdeterminedError
            If a measured mode has no partner in the model.
        """
        target = self.target
        basis = self._modes(values)
        candidates = np.flatnonzero(basis.frequencies <= PAIRING.frequency_range * target.frequencies.max())
        candidates = candidates[candidates >= basis.n_rigid_body]
        shapes = self._sensors.T @ basis.shapes
        table = self._mac(shapes[:, candidates])
        log_frequency_ratio = np.abs(np.log(basis.frequencies[candidates] / target.frequencies[:, None]))
        partner = dict(pair_modes(table - PAIRING.frequency_penalty * log_frequency_ratio, self.min_mac))
        modes = candidates[_columns(partner, len(target.squares), self.min_mac)]
        rotation = self._rotation(shapes[:, modes])
        paired_shapes = shapes[:, modes] @ rotation
        shape_difference = self._scaled_to(paired_shapes) - paired_shapes
        eigenvalues = (rotation**2).T @ basis.eigenvalues[
            modes
        ]  # the diagonal of R^T Lambda R, R the rotation
        squares = eigenvalues.real
        norms = (
            np.ones(len(squares))
            if self._balance is Balance.EIGENVALUES
            else np.linalg.norm(paired_shapes, axis=0)
        )
        size = np.concatenate([squares, np.tile(norms, len(paired_shapes))])
        eigenvalue_difference = target.squares - (eigenvalues if target.damped else squares)
        return ModelState(
            values=values,
            basis=basis,
            modes=modes,
            mac=np.diag(mac(target.shapes, paired_shapes)),
            rotation=rotation,
            difference=self._rows(np.concatenate([eigenvalue_difference, shape_difference.ravel()])),
            size=(np.tile(size, 2) if target.damped else size)[self._row_mask],
        )

    def sensitivity(self, state: ModelState) -> FloatArray:
        """Return the sensitivity matrix (n_rows, n_params): derivatives of the model's rows."""
        parts = self.model.parts(state.values, damped=self.target.damped)
        derivative = derivatives(
            state.basis,
            state.modes,
            self._sensors,
            parts,
            self._mass_loss,
            planes=self._planes,
            rotation=state.rotation if self._planes else None,
        )
        return self._rows(
            np.concatenate(
                [derivative.eigenvalues, derivative.shapes.reshape(-1, derivative.shapes.shape[2])]
            )
        )

    def _mac(self, shapes: FloatArray | ComplexArray) -> FloatArray:
        """Return the modal assurance criterion (n_modes, n) of measured modes with shapes.

        For repeated modes it is that of the subspace they span.
        """
        measured = self.target.shapes
        table = mac(measured, shapes)
        for group in self._planes:
            projection = np.linalg.qr(measured[:, group])[0].T @ shapes
            table[group] = (np.abs(projection) ** 2).sum(axis=0) / (np.abs(shapes) ** 2).sum(axis=0)
        return table

    def _rotation(self, shapes: FloatArray | ComplexArray) -> FloatArray:
        """Return the orthogonal matrix (n_modes, n_modes) that takes repeated modes to the measured shapes.

        Shapes of repeated modes are any of their subspace: orthogonal Procrustes problem, Schoenemann (1966),
        Psychometrika 31, 1-10.
        """
        rotation = np.eye(shapes.shape[1])
        for group in self._planes:
            u, _, vh = np.linalg.svd(shapes[:, group].T @ self.target.shapes[:, group])
            rotation[np.ix_(group, group)] = u @ vh
        return rotation

    def _rows(self, values: FloatArray | ComplexArray) -> FloatArray:
        """Return mode numbers as real equations: real parts, and for damped modes imaginary parts too.

        Coefficients are real, so that both parts of a complex number are equations of their own.
        """
        rows = np.concatenate([values.real, values.imag]) if self.target.damped else values.real
        return rows if self._row_mask.all() else rows[self._row_mask]

    def _modes(self, values: FloatArray) -> ModalBasis:
        system = self.model.system(values)
        all_modes = len(system.dofs) < EIGENSOLUTION.dense_dofs
        reach = PAIRING.damped_frequency_range if self.target.damped else PAIRING.frequency_range
        limit = np.inf if all_modes else reach * float(self.target.frequencies.max())
        damping = system.damping if self.target.damped else None
        basis = modal_basis(
            system.mass,
            system.stiffness,
            damping,
            None,
            system.rigid,
            frequency_max=limit,
            near=self._latest,
        )
        if basis.remainder is not None:
            self._latest = basis.remainder.shapes[:, basis.n_rigid_body :]
        return basis

    def _scaled_to(self, shapes: FloatArray | ComplexArray) -> FloatArray | ComplexArray:
        """Return the measured shapes with the sign of the model's shapes, and their scale if they have none.

        The norm phi^T M phi = 1 leaves only the sign open; an arbitrary complex scale also rotates the phase.
        """
        measured = self.target.shapes
        projection = (measured.conj() * shapes).sum(axis=0)
        if self.target.mass_normalised:
            return measured * np.where(projection.real < 0, -1.0, 1.0)
        return np.asarray(measured * projection / (np.abs(measured) ** 2).sum(axis=0))


def _columns(partner: Mapping[int, int], n_modes: int, min_mac: float) -> IntArray:
    """Return the partner of each measured mode.

    Raises
    ------
    UnderdeterminedError
        If a measured mode has none.
    """
    unpaired = [r for r in range(n_modes) if r not in partner]
    if unpaired:
        raise UnderdeterminedError(
            f"measured mode {unpaired[0] + 1} pairs with no mode of the model",
            field="modes",
            value=unpaired[0] + 1,
            allowed=f"a MAC of {min_mac} with a mode of the model",
        )
    return np.array([partner[r] for r in range(n_modes)])


def _mass_loss(structure: Structure) -> float:
    """Return the mass coefficient a of D = a M + b K, rad^2/s^2."""
    law = structure.damping
    if not isinstance(law, StructuralDamping):
        raise InvalidInputError(
            "damped modes update hysteretic damping, member by member; the model has another law",
            field="damping",
            value=type(law).__name__,
            allowed=[StructuralDamping.__name__],
        )
    return law.mass_coefficient
