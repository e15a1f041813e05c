"""Structural and viscous damping: how a mode is one pole near its resonance, in omega^2 or in omega."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.options import Damping
from modallab.extraction.single_mode.method import ExtractionMethod, ModeFits
from modallab.extraction.single_mode.settings import SINGLE_MODE_FIT, VISCOUS_FIT


class DampingModel(Protocol):
    """Damping law. Eigenvalues are `omega_r^2 (1 + i eta_r)` for every law, with `eta_r = 2 zeta_r`.

    Array arguments are broadcast against each other.
    """

    loss_per_pole: float
    """Loss factor over the ratio of imaginary to real part of the pole, for light damping."""

    def abscissa(self, freq: FloatArray) -> FloatArray:
        """Return the frequency f, Hz, for which the pole of a mode is a pole in `(2 pi f)^2`."""
        ...

    def image_terms(
        self, freq: FloatArray, eigenvalue: ComplexArray, constant: ComplexArray, order: IntArray
    ) -> ComplexArray:
        """Return the mode without its pole and constants, in receptance differentiated `order` times."""
        ...

    def fit(
        self,
        method: ExtractionMethod,
        freq: FloatArray,
        frf: ComplexArray,
        weight: FloatArray,
        order: IntArray,
    ) -> ModeFits:
        """Return the fits of `method`; `order` (n_fits,): 0 receptance, 1 mobility, 2 inertance.

        The modal constant is that of the response given: `-L A` in inertance, with L as in `pole`.
        """
        ...

    def response(self, freq: FloatArray, eigenvalue: ComplexArray, constant: ComplexArray) -> ComplexArray:
        """Return the receptance of modes, m/N."""
        ...

    def pole(self, eigenvalue: ComplexArray, constant: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return L, the squared pole in omega, and a: near resonance receptance is `a/(L - omega^2)`."""
        ...


@dataclass(frozen=True)
class StructuralDampingModel:
    """Structural damping, `A/(lambda_r - omega^2)`: a pole in omega^2, in inertance too."""

    loss_per_pole = 1.0

    def abscissa(self, freq: FloatArray) -> FloatArray:
        """Return the frequency itself."""
        return freq

    def image_terms(
        self, freq: FloatArray, eigenvalue: ComplexArray, constant: ComplexArray, order: IntArray
    ) -> ComplexArray:
        """Return zeros: `-omega^2 A/(lambda - omega^2) = A - lambda A/(lambda - omega^2)`."""
        return np.zeros(np.broadcast_shapes(freq.shape, eigenvalue.shape), complex)

    def fit(
        self,
        method: ExtractionMethod,
        freq: FloatArray,
        frf: ComplexArray,
        weight: FloatArray,
        order: IntArray,
    ) -> ModeFits:
        """Return the fits of the method unchanged."""
        return method(freq, frf, weight)

    def response(self, freq: FloatArray, eigenvalue: ComplexArray, constant: ComplexArray) -> ComplexArray:
        """Return `A/(lambda_r - omega^2)`."""
        return np.asarray(constant / (eigenvalue - (2 * np.pi * freq) ** 2))

    def pole(self, eigenvalue: ComplexArray, constant: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return both arguments unchanged."""
        return eigenvalue, constant


@dataclass(frozen=True)
class ViscousDampingModel:
    """Viscous damping, `c/(p - omega) + conj(c)/(conj(p) + omega)`: a pole in omega and its mirror image.

    `p = omega_r (sqrt(1 - zeta_r^2) + i zeta_r)` and `A = 2 Re(p) c`; with a real constant the mode is
    `A/(omega_r^2 - omega^2 + 2 i zeta_r omega_r omega)`. Without the mirror image the response is a circle
    and its inverse a line, in omega instead of omega^2, so that every single-mode method applies unchanged.
    Mobility is `i omega` times receptance, again a pole, its mirror image and a constant.
    """

    loss_per_pole = 2.0

    def abscissa(self, freq: FloatArray) -> FloatArray:
        """Return `sqrt(omega)/(2 pi)`."""
        return np.asarray(np.sqrt(2 * np.pi * freq) / (2 * np.pi))

    def image_terms(
        self, freq: FloatArray, eigenvalue: ComplexArray, constant: ComplexArray, order: IntArray
    ) -> ComplexArray:
        """Return the mirror image, and the difference of the pole's derivative from a pole."""
        omega, p = 2 * np.pi * freq, _pole(eigenvalue)
        c = constant / (2 * p.real)
        pole = c / (p - omega)
        mirror = c.conj() / (p.conj() + omega)
        return np.asarray((1j * omega) ** order * (pole + mirror) - (1j * p) ** order * pole)

    def fit(
        self,
        method: ExtractionMethod,
        freq: FloatArray,
        frf: ComplexArray,
        weight: FloatArray,
        order: IntArray,
    ) -> ModeFits:
        """Return fits in omega; each subtracts the mirror image of the previous one."""
        abscissa = self.abscissa(freq)
        fits = method(abscissa, frf, weight)
        for _ in range(VISCOUS_FIT.mirror_iterations - 1):
            physical = _physical(fits)
            eigenvalue = np.where(
                fits.found, (2 * np.pi * physical.frequency) ** 2 * (1 + 1j * physical.loss_factor), 1j
            )
            receptance = np.where(fits.found, physical.modal_constant, 0) / (1j * _pole(eigenvalue)) ** order
            image = self.image_terms(freq, eigenvalue[:, None], receptance[:, None], order[:, None])
            fits = method(abscissa, frf - image, weight)
        return _physical(fits)

    def response(self, freq: FloatArray, eigenvalue: ComplexArray, constant: ComplexArray) -> ComplexArray:
        """Return the pole and its mirror image."""
        omega, p = 2 * np.pi * freq, _pole(eigenvalue)
        c = constant / (2 * p.real)
        return np.asarray(c / (p - omega) + np.conj(c) / (p.conj() + omega))

    def pole(self, eigenvalue: ComplexArray, constant: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return `p^2` and `2 p c`."""
        p = _pole(eigenvalue)
        return p**2, np.asarray(constant * p / p.real)


def _pole(eigenvalue: ComplexArray) -> ComplexArray:
    """Return the pole p in omega of a viscous mode, rad/s."""
    stiffness = np.maximum(eigenvalue.real, SINGLE_MODE_FIT.smallest_eigenvalue)
    ratio = np.clip(
        eigenvalue.imag / stiffness / 2, -VISCOUS_FIT.largest_damping_ratio, VISCOUS_FIT.largest_damping_ratio
    )
    return np.asarray(np.sqrt(stiffness) * (np.sqrt(1 - ratio**2) + 1j * ratio))


def _physical(fits: ModeFits) -> ModeFits:
    """Return fits in omega, with `frequency` equal to `sqrt(Re p)/(2 pi)`, as fits of modes."""
    real_part = (2 * np.pi * fits.frequency) ** 2
    pole = real_part * (1 + 1j * fits.loss_factor)
    omega = np.abs(pole)
    # standard error of the real and of the imaginary part of the pole
    error = fits.frequency_error * 8 * np.pi**2 * fits.frequency
    safe = np.where(omega > 0, omega, 1.0)
    return replace(
        fits,
        frequency=omega / (2 * np.pi),
        loss_factor=2 * pole.imag / safe,
        modal_constant=2 * real_part * fits.modal_constant,
        frequency_error=error / (2 * np.pi),
        loss_factor_error=2 * error / safe * real_part / safe,
        modal_constant_error=2 * real_part * fits.modal_constant_error,
    )


DAMPING_MODELS: Mapping[Damping, DampingModel] = {
    Damping.STRUCTURAL: StructuralDampingModel(),
    Damping.VISCOUS: ViscousDampingModel(),
}
