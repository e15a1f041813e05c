"""A model held against measured modes at given coefficients: what differs, and how it would move."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError, UnderdeterminedError
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
    """Which rows are divided by their own size; 1992 thesis, eq. [3.22]."""

    EIGENVALUES = "eigenvalues"
    BOTH = "both"


@dataclass(frozen=True, eq=False)
class ModelState:
    """The model at some coefficients, its modes paired with the measured ones."""

    values: FloatArray  # (n_params,)
    basis: ModalBasis
    modes: IntArray  # (n_modes,) column of the basis that pairs with each measured mode
    mac: FloatArray  # (n_modes,)
    # (n_modes, n_modes) orthogonal: modes at one measured frequency are turned to the shapes measured there
    rotation: FloatArray
    # (n_rows,) measured minus model: eigenvalues, then shapes DoF by DoF; of damped modes the real parts
    # of all and then the imaginary ones
    difference: FloatArray
    # (n_rows,) what balances the rows: Re lambda_r for an eigenvalue, 1 or the shape's norm for a shape
    size: FloatArray

    @property
    def frequencies(self) -> FloatArray:
        """(n_modes,) Hz, of the model."""
        return self.basis.frequencies[self.modes]

    @property
    def distance(self) -> float:
        """Root mean square of the balanced differences."""
        return float(np.sqrt(np.mean((self.difference / self.size) ** 2)))


class ModalResiduals:
    """A structure, the coefficients that may move, and the modes it should have.

    Real modes are held against the model without its damping, damped ones against the model with it.

    Raises
    ------
    InvalidInputError
        If loss factors are asked of real modes, or damped modes of a structure whose damping is not
        hysteretic.
    UnderdeterminedError
        If there are fewer measured numbers than coefficients, unless something else is known of these.
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
        self._latest: FloatArray | None = None  # modes of the last model: the next one's are much like them
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
                allowed=f"<= {n_rows}",
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
        """Return how many members have a loss factor below zero at `values` (n_params,)."""
        return self.model.count_negative_loss_factors(values, tolerance)

    def state(self, values: FloatArray) -> ModelState:
        """Return the model at `values` (n_params,).

        Raises
        ------
        UnderdeterminedError
            If a measured mode pairs with none of the model.
        """
        target = self.target
        basis = self._modes(values)
        candidates = np.flatnonzero(basis.frequencies <= PAIRING.frequency_range * target.frequencies.max())
        candidates = candidates[candidates >= basis.n_rigid_body]
        shapes = self._sensors.T @ basis.shapes
        table = self._mac(shapes[:, candidates])
        log_frequency_ratio = np.abs(np.log(basis.frequencies[candidates] / target.frequencies[:, None]))
        partner = dict(pair_modes(table - PAIRING.frequency_penalty * log_frequency_ratio, self.min_mac))
        unpaired = [r for r in range(len(target.squares)) if r not in partner]
        if unpaired:
            raise UnderdeterminedError(
                f"measured mode {unpaired[0] + 1} pairs with no mode of the model",
                field="modes",
                value=unpaired[0] + 1,
                allowed=f"a MAC of {self.min_mac} with a mode of the model",
            )
        columns = np.array([partner[r] for r in range(len(target.squares))])
        modes = candidates[columns]
        rotation = self._rotation(shapes[:, modes])
        paired_shapes = shapes[:, modes] @ rotation
        shape_difference = self._scaled_to(paired_shapes) - paired_shapes
        eigenvalues = (rotation**2).T @ basis.eigenvalues[modes]  # the diagonal of turn^T Lambda turn
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
        """Return the derivatives of the model's rows, (n_rows, n_params)."""
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
        """Return the MAC (n_modes, n) of measured modes; of those at one frequency, that of their plane."""
        measured = self.target.shapes
        table = mac(measured, shapes)
        for group in self._planes:
            projection = np.linalg.qr(measured[:, group])[0].T @ shapes
            table[group] = (np.abs(projection) ** 2).sum(axis=0) / (np.abs(shapes) ** 2).sum(axis=0)
        return table

    def _rotation(self, shapes: FloatArray | ComplexArray) -> FloatArray:
        """Return the orthogonal matrix (n_modes, n_modes) that takes modes at one frequency, where shapes
        are any of their plane, to the measured ones: Schoenemann (1966), Psychometrika 31, 1-10."""
        rotation = np.eye(shapes.shape[1])
        for group in self._planes:
            u, _, vh = np.linalg.svd(shapes[:, group].T @ self.target.shapes[:, group])
            rotation[np.ix_(group, group)] = u @ vh
        return rotation

    def _rows(self, values: FloatArray | ComplexArray) -> FloatArray:
        """Return numbers of modes as rows of the equations: coefficients are real, so that both parts of
        a damped mode's are equations of their own."""
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
        """Return the measured shapes in the sense of the model's, in its scale if they have none.

        phi^T M phi = 1 leaves only the sign open; a scale of nobody's choice also turns a complex shape.
        """
        measured = self.target.shapes
        projection = (measured.conj() * shapes).sum(axis=0)
        if self.target.mass_normalised:
            return measured * np.where(projection.real < 0, -1.0, 1.0)
        return np.asarray(measured * projection / (np.abs(measured) ** 2).sum(axis=0))


def _mass_loss(structure: Structure) -> float:
    """Return a of D = a M + b K, rad^2/s^2."""
    law = structure.damping
    if not isinstance(law, StructuralDamping):
        raise InvalidInputError(
            "damped modes update hysteretic damping, member by member; the model has another law",
            field="damping",
            value=type(law).__name__,
            allowed=StructuralDamping.__name__,
        )
    return law.mass_coefficient
