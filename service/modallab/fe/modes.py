"""Modes of a system, and its receptance by modal superposition."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csc_array

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.numerics import PRODUCT_ROUNDING
from modallab.fe.attachment import unique_columns
from modallab.fe.cache import Cache, CacheSlot
from modallab.fe.complex_modes import damped_modes
from modallab.fe.eigen_refinement import refined_modes
from modallab.fe.far_modes import FarModes, are_far
from modallab.fe.losses import Losses
from modallab.fe.lowest_modes import LowestModes, lowest_below, lowest_first
from modallab.fe.modal_damping import ModalLossFactors
from modallab.fe.settings import CACHE, DAMPED_MODES, EIGENSOLUTION
from modallab.fe.truncation import ModalTruncation
from modallab.fe.viscous_modes import CoupledModes

BETWEEN_COLUMNS: CacheSlot[ComplexArray] = CacheSlot("between columns")
RESPONSES: "CacheSlot[ModalResponse]" = CacheSlot("responses", CACHE.modal_responses)


@dataclass(frozen=True, eq=False)
class ModalBasis:
    """Mass-normalised modes (phi^T M phi = 1, plain transpose), rigid-body modes first.

    `eigenvalues` hold structural damping; viscous damping stands beside them, as it depends on
    frequency. `remainder` is the contribution of modes above `frequency_max` where these are truncated.
    """

    eigenvalues: ComplexArray  # (m,) omega_r^2 (1 + i eta_r), rad^2/s^2
    shapes: FloatArray | ComplexArray  # (n, m), 1/sqrt(kg)
    n_rigid_body: int
    viscous: FloatArray | ComplexArray | None = None  # (m, m) Phi^T C Phi, 1/s
    frequency_max: float = np.inf  # Hz
    remainder: ModalTruncation | None = None

    def elastic(self, count: int | None = None) -> "ModalBasis":
        """Return the first `count` elastic modes; off-diagonal modal damping is neglected."""
        if count is not None and count < 1:
            raise InvalidInputError("at least one mode", field="count", value=count, allowed=bounds(1))
        stop = None if count is None else self.n_rigid_body + count
        keep = slice(self.n_rigid_body, stop)
        viscous = None if self.viscous is None else self.viscous[keep, keep]
        return ModalBasis(self.eigenvalues[keep], self.shapes[:, keep], 0, viscous, self.frequency_max)

    def damped(
        self,
        damping: csc_array | None,
        viscous: csc_array | None,
        modal: ModalLossFactors | None = None,
        losses: Losses | None = None,
    ) -> "ModalBasis":
        """Return these undamped modes with damping; shapes become complex only where it couples them.

        `losses` of the members are for the truncated modes.
        """
        squares = self.eigenvalues.real
        d, c = (None if part is None else self.shapes.T @ (part @ self.shapes) for part in (damping, viscous))
        if modal is not None:
            rigid, elastic = np.zeros(self.n_rigid_body), squares[self.n_rigid_body :]
            d = np.diag(np.concatenate([rigid, modal.hysteretic(elastic)])) + (0.0 if d is None else d)
            if modal.viscous:
                modal_viscous = np.concatenate([rigid, modal.viscous * modal.modal_loss(elastic)])
                c = np.diag(modal_viscous) + (0.0 if c is None else c)
        values, rotation = (self.eigenvalues, None) if d is None else damped_modes(squares, np.asarray(d))
        shapes = self.shapes if rotation is None else self.shapes @ rotation
        if rotation is not None and c is not None:
            c = rotation.T @ c @ rotation
        remainder = None if self.remainder is None else replace(self.remainder, losses=losses)
        return replace(self, eigenvalues=values, shapes=shapes, viscous=c, remainder=remainder)

    def with_scaled_eigenvalues(self, factor: float) -> "ModalBasis":
        """Return undamped modes of the same shapes with eigenvalues multiplied by a factor."""
        return replace(
            self,
            eigenvalues=self.eigenvalues * factor,
            frequency_max=self.frequency_max * np.sqrt(factor),
            remainder=None if self.remainder is None else self.remainder.with_scaled_eigenvalues(factor),
        )

    @property
    def frequencies(self) -> FloatArray:
        """(m,) Hz, sqrt(Re lambda) / 2 pi."""
        return np.asarray(np.sqrt(np.maximum(self.eigenvalues.real, 0.0)) / (2 * np.pi))

    @property
    def loss_factors(self) -> FloatArray:
        """(m,) Im lambda / Re lambda, with 2 zeta of viscous damping added; 0 for rigid-body modes."""
        square = self.eigenvalues.real
        imaginary = self.eigenvalues.imag.copy()
        if self.viscous is not None:
            imaginary += np.sqrt(np.maximum(square, 0.0)) * np.diag(self.viscous).real
        return np.divide(imaginary, square, out=np.zeros_like(imaginary), where=square > 0)

    def decay_rates(self, least_omega: float) -> FloatArray:
        """Return the rates of decay (m,), 1/s, by viscous damping and structural damping alike.

        Parameters
        ----------
        least_omega
            Natural frequency, rad/s, below which structural damping lets nothing decay.
        """
        omega = 2 * np.pi * self.frequencies
        imaginary = self.eigenvalues.imag
        rates = np.divide(imaginary, 2 * omega, out=np.zeros_like(omega), where=omega > least_omega)
        return rates if self.viscous is None else rates + np.diag(self.viscous).real / 2

    def far(self, omega: FloatArray) -> BoolArray:
        """Return which modes (m,) are summed by a series at `omega` (n_freq,) rad/s, see `FarModes`."""
        if self.viscous is not None or np.iscomplexobj(self.shapes):
            return np.zeros(len(self.eigenvalues), bool)
        return are_far(self.eigenvalues, omega)

    def at(self, omega: FloatArray) -> "ModalResponse":
        """Return the modes' response at `omega` (n_freq,) rad/s, above zero.

        Cached by frequency axis, which all variants of a structure share, for the latest bases: each run of a
        test whose stiffness drifts has one of its own.
        """
        n_near = len(self.eigenvalues) - int(self.far(omega).sum())
        if omega.size * n_near > CACHE.response_values:
            return ModalResponse(self, omega)
        return _responses_of(self).compute(RESPONSES, omega.tobytes(), lambda: ModalResponse(self, omega))


class ModalResponse:
    """Modal response at fixed frequencies; the denominators are formed once."""

    def __init__(self, basis: ModalBasis, omega: FloatArray) -> None:
        self.basis, self.omega = basis, omega
        self._cache = Cache()
        c, values = basis.viscous, basis.eigenvalues
        self._is_far = basis.far(omega)
        self._far = FarModes(values[self._is_far], omega) if self._is_far.any() else None
        direct = values[~self._is_far] - (omega**2)[:, None]
        self._coupled: CoupledModes | None = None
        if c is not None:
            loss = np.diag(c)
            direct = direct + 1j * omega[:, None] * loss
            coupling = c - np.diag(loss)
            if np.abs(coupling).max(initial=0.0) > DAMPED_MODES.relative_coupling * np.abs(loss).max():
                self._coupled = CoupledModes(direct, coupling, omega)
        # Stored in the one form that is used: responses of many variants are cached at a time.
        over = 1.0 / direct  # (n_freq, m)
        self._inverse_stiffness = over if np.iscomplexobj(basis.shapes) else _interleaved(over)

    def receptance(self, outputs: FloatArray, inputs: FloatArray) -> ComplexArray:
        """Return outputs^T alpha inputs, (n_freq, n_out, n_in), m/N, for columns (n, .)."""
        phi_l, phi_r = outputs.T @ self.basis.shapes, inputs.T @ self.basis.shapes
        coupled = self._coupled
        alpha = self._sum(phi_l, phi_r) if coupled is None else coupled.receptance(phi_l, phi_r)
        if self.basis.remainder is not None:
            alpha = alpha + self.basis.remainder.at(self.omega, outputs, inputs)
        return alpha

    def pairs(self, outputs: FloatArray, inputs: FloatArray) -> ComplexArray:
        """Return the receptance of pairs of columns, `outputs` by `inputs`, (n_pairs, n_freq), m/N.

        Frequency is the last axis: each pair is contiguous.
        """
        if self._coupled is not None or self.basis.remainder is not None:
            (outputs, row), (inputs, column) = unique_columns(outputs), unique_columns(inputs)
            return np.asarray(self.receptance(outputs, inputs)[:, row, column].T)
        return self._products((outputs.T @ self.basis.shapes) * (inputs.T @ self.basis.shapes))

    def between_columns(self, motions: FloatArray) -> ComplexArray:
        """Return the receptance of columns (n, k) with one another, (n_freq, k, k), m/N, to read only.

        The latest result is cached for variants of the same attachments.
        """
        size = len(self.omega) * motions.shape[1] ** 2
        if size > CACHE.response_values:
            return self._between_columns(motions)
        return self._cache.compute(BETWEEN_COLUMNS, motions.tobytes(), lambda: self._between_columns(motions))

    def _between_columns(self, motions: FloatArray) -> ComplexArray:
        if self._coupled is not None or self.basis.remainder is not None:
            return self.receptance(motions, motions)
        rows, columns = np.triu_indices(motions.shape[1])
        phi = motions.T @ self.basis.shapes
        half = self._products(phi[rows] * phi[columns])  # it is symmetric
        place = np.zeros((motions.shape[1],) * 2, int)
        place[rows, columns] = place[columns, rows] = np.arange(len(rows))
        return np.ascontiguousarray(half.T)[:, place]

    def _sum(self, phi_l: FloatArray | ComplexArray, phi_r: FloatArray | ComplexArray) -> ComplexArray:
        constants = (phi_l[:, None, :] * phi_r[None, :, :]).reshape(-1, phi_l.shape[1])
        return self._products(constants).T.reshape(len(self.omega), len(phi_l), len(phi_r))

    def _products(self, constants: FloatArray | ComplexArray) -> ComplexArray:
        """Return the sums over modes of modal constants (k, m), (k, n_freq)."""
        if np.iscomplexobj(constants):
            return np.asarray(constants @ self._inverse_stiffness.T, complex)
        # One real product: at 80 to 90 % of a plain matrix product, against 7 % for the complex sum
        # written as an einsum. Real and imaginary parts are interleaved, so that it is viewed as complex.
        alpha: ComplexArray = (constants[:, ~self._is_far] @ self._inverse_stiffness.T).view(complex)
        if self._far is not None:
            self._far.add_to(alpha, constants[:, self._is_far])
        return alpha


@lru_cache(maxsize=CACHE.bases_with_responses)
def _responses_of(_basis: ModalBasis) -> Cache:
    return Cache()


def _interleaved(values: ComplexArray) -> FloatArray:
    """Return complex values (n_freq, m) as (2 n_freq, m): real and imaginary part of every line."""
    parts = values.view(float).reshape(*values.shape, 2)
    return np.ascontiguousarray(parts.swapaxes(1, 2)).reshape(2 * len(values), -1)


def rigid_body_modes(mass: csc_array, stiffness: csc_array, candidates: FloatArray | None) -> FloatArray:
    """Return the mass-normalised motions (n, n_rigid) in the span of the candidates without strain."""
    n = mass.shape[0]
    if candidates is None or candidates.shape[1] == 0:
        return np.zeros((n, 0))
    values, rotation = eigh(candidates.T @ (mass @ candidates))
    with_mass = values > PRODUCT_ROUNDING * values[-1]
    shapes = candidates @ (rotation[:, with_mass] / np.sqrt(values[with_mass]))
    energy, rotation = eigh(shapes.T @ (stiffness @ shapes))
    # Rounding of an exact zero: entries of K of this size cancel in the product.
    epsilon = EIGENSOLUTION.rigid_energy_rounding * np.finfo(float).eps
    rounding = epsilon * abs(stiffness).max() * (shapes**2).sum(axis=0).max()
    return np.asarray(shapes @ rotation[:, energy < rounding])


def modal_basis(
    mass: csc_array,
    stiffness: csc_array,
    damping: csc_array | None,
    viscous: csc_array | None,
    rigid: FloatArray | None,
    *,
    frequency_max: float = np.inf,
    near: FloatArray | None = None,
) -> ModalBasis:
    """Return the modes of a system up to `frequency_max`, Hz; all of them if that is infinite.

    Low modes, close ones too, are as accurate as the matrices.

    Parameters
    ----------
    mass, stiffness, damping, viscous
        (n, n) kg, N/m, N/m (structural), N s/m.
    rigid
        (n, n_rigid) motions of the geometry that strain no member.
    near
        (n, k) undamped modes of a similar system as starting vectors.
    """
    undamped = undamped_basis(mass, stiffness, rigid, frequency_max=frequency_max, near=near)
    if undamped.remainder is None:
        squares, shapes = undamped.eigenvalues.real, undamped.shapes.real
        dense = mass.toarray(), stiffness.toarray()
        squares, shapes = refined_modes(*dense, squares, shapes, undamped.n_rigid_body)
        undamped = replace(undamped, eigenvalues=squares.astype(complex), shapes=shapes)
    return undamped.damped(damping, viscous)


def undamped_basis(
    mass: csc_array,
    stiffness: csc_array,
    rigid: FloatArray | None,
    *,
    frequency_max: float = np.inf,
    near: FloatArray | None = None,
) -> ModalBasis:
    """Return the modes of a system without damping; see `modal_basis`."""
    bodies = rigid_body_modes(mass, stiffness, rigid)
    if np.isfinite(frequency_max):
        highest = (2 * np.pi * frequency_max) ** 2
        lowest = lowest_below(mass, stiffness, bodies, highest, near)
        return _of_lowest(lowest, bodies.shape[1], frequency_max)
    squares, shapes = eigh(stiffness.toarray(), mass.toarray())
    n_rigid = bodies.shape[1]
    elastic = shapes[:, n_rigid:]
    # rounding of the largest eigenvalue leaves rigid-body motion in low elastic modes of slender structures
    elastic = elastic - bodies @ (bodies.T @ (mass @ elastic))
    shapes = np.hstack([bodies, elastic / np.sqrt((elastic * (mass @ elastic)).sum(axis=0))])
    squares = np.concatenate([np.zeros(n_rigid), squares[n_rigid:]])
    return ModalBasis(squares.astype(complex), shapes, n_rigid)


def first_basis(mass: csc_array, stiffness: csc_array, rigid: FloatArray | None, count: int) -> ModalBasis:
    """Return rigid-body modes and the first elastic ones without damping, `count` of them or a few more."""
    bodies = rigid_body_modes(mass, stiffness, rigid)
    lowest = lowest_first(mass, stiffness, bodies, count)
    return _of_lowest(lowest, bodies.shape[1], float(np.sqrt(lowest.highest) / (2 * np.pi)))


def _of_lowest(lowest: LowestModes, n_rigid: int, frequency_max: float) -> ModalBasis:
    squares = lowest.squares.astype(complex)
    remainder = None if np.isinf(frequency_max) else lowest.remainder
    return ModalBasis(squares, lowest.shapes, n_rigid, None, frequency_max, remainder)
