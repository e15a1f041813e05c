"""How a mode is one pole near its resonance: in omega^2 if its damping is structural, in omega if viscous."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.options import Damping
from modallab.extraction.single_mode.method import ExtractionMethod, ModeFits

ROUNDS = 4  # the mirror pole is taken off by its last fit; each round wins two digits where damping is 5 %
TINY = 1e-12  # (rad/s)^2, below any mode
MOST = 0.99  # damping ratio: above, a mode has no resonance


class DampingModel(Protocol):
    """A law of damping. Eigenvalues are `omega_r^2 (1 + i eta_r)` whatever the law, `eta_r = 2 zeta_r`.

    Array arguments take any shapes that go together.
    """

    loss_per_pole: float  # loss factor over the ratio of imaginary to real part of the pole, lightly damped

    def variable(self, freq: FloatArray) -> FloatArray:
        """Return the frequency that a method must be told, so that it sees a pole in `(2 pi freq)^2`, Hz."""
        ...

    def beside(
        self, freq: FloatArray, eigenvalue: ComplexArray, constant: ComplexArray, order: IntArray
    ) -> ComplexArray:
        """Return what a mode adds to its pole, but for constants, in receptance derived `order` times."""
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

        The modal constant is that of the response given: `-L A` in inertance, L as in `pole`.
        """
        ...

    def response(self, freq: FloatArray, eigenvalue: ComplexArray, constant: ComplexArray) -> ComplexArray:
        """Return the receptance of modes, m/N."""
        ...

    def pole(self, eigenvalue: ComplexArray, constant: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return square L of the pole in omega, and a: near resonance receptance is `a/(L - omega^2)`."""
        ...


@dataclass(frozen=True)
class StructuralDampingModel:
    """`A/(lambda_r - omega^2)`: a pole in omega^2, in inertance too."""

    loss_per_pole = 1.0

    def variable(self, freq: FloatArray) -> FloatArray:
        """Return the frequency itself."""
        return freq

    def beside(
        self, freq: FloatArray, eigenvalue: ComplexArray, constant: ComplexArray, order: IntArray
    ) -> ComplexArray:
        """Return nothing: `-omega^2 A/(lambda - omega^2) = A - lambda A/(lambda - omega^2)`."""
        return np.zeros(np.broadcast_shapes(freq.shape, eigenvalue.shape), complex)

    def fit(
        self,
        method: ExtractionMethod,
        freq: FloatArray,
        frf: ComplexArray,
        weight: FloatArray,
        order: IntArray,
    ) -> ModeFits:
        """Return the fits of the method as they are."""
        return method(freq, frf, weight)

    def response(self, freq: FloatArray, eigenvalue: ComplexArray, constant: ComplexArray) -> ComplexArray:
        """Return `A/(lambda_r - omega^2)`."""
        return np.asarray(constant / (eigenvalue - (2 * np.pi * freq) ** 2))

    def pole(self, eigenvalue: ComplexArray, constant: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return both unchanged."""
        return eigenvalue, constant


@dataclass(frozen=True)
class ViscousDampingModel:
    """`c/(p - omega) + conj(c)/(conj(p) + omega)`, a pole in omega and its mirror image.

    `p = omega_r (sqrt(1 - zeta_r^2) + i zeta_r)`, `A = 2 Re(p) c`; of a mode with a real constant it is
    `A/(omega_r^2 - omega^2 + 2 i zeta_r omega_r omega)`. With the mirror image off, what is left is a
    circle, and the inverse of it a line, in omega instead of omega^2: every method works on as it is.
    Mobility is `i omega` times as much, again a pole, its mirror image and a constant.
    """

    loss_per_pole = 2.0

    def variable(self, freq: FloatArray) -> FloatArray:
        """Return `sqrt(omega)/(2 pi)`."""
        return np.asarray(np.sqrt(2 * np.pi * freq) / (2 * np.pi))

    def beside(
        self, freq: FloatArray, eigenvalue: ComplexArray, constant: ComplexArray, order: IntArray
    ) -> ComplexArray:
        """Return the mirror image, and how the derivative of the pole differs from a pole."""
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
        """Return fits in omega; the mirror image is taken off by the fit before."""
        across = self.variable(freq)
        fits = method(across, frf, weight)
        for _ in range(ROUNDS - 1):
            found = _physical(fits)
            eigenvalue = np.where(
                fits.found, (2 * np.pi * found.frequency) ** 2 * (1 + 1j * found.loss_factor), 1j
            )
            receptance = np.where(fits.found, found.modal_constant, 0) / (1j * _pole(eigenvalue)) ** order
            beside = self.beside(freq, eigenvalue[:, None], receptance[:, None], order[:, None])
            fits = method(across, frf - beside, weight)
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
    stiffness = np.maximum(eigenvalue.real, TINY)
    ratio = np.clip(eigenvalue.imag / stiffness / 2, -MOST, MOST)
    return np.asarray(np.sqrt(stiffness) * (np.sqrt(1 - ratio**2) + 1j * ratio))


def _physical(fits: ModeFits) -> ModeFits:
    """Return fits in omega, whose `frequency` is `sqrt(Re p)/(2 pi)`, as those of modes."""
    across = (2 * np.pi * fits.frequency) ** 2
    p = across * (1 + 1j * fits.loss_factor)
    omega = np.abs(p)
    # the error of either part of the pole, from that of its real part
    error = fits.frequency_error * 8 * np.pi**2 * fits.frequency
    safe = np.where(omega > 0, omega, 1.0)
    return replace(
        fits,
        frequency=omega / (2 * np.pi),
        loss_factor=2 * p.imag / safe,
        modal_constant=2 * across * fits.modal_constant,
        frequency_error=error / (2 * np.pi),
        loss_factor_error=2 * error / safe * across / safe,
        modal_constant_error=2 * across * fits.modal_constant_error,
    )


DAMPING_MODELS: Mapping[Damping, DampingModel] = {
    Damping.STRUCTURAL: StructuralDampingModel(),
    Damping.VISCOUS: ViscousDampingModel(),
}
