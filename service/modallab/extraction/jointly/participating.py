"""What one mode contributes to FRFs of several references: one shape, and how strongly each reaches it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.extraction.jointly.modal_basis import BASES, ModalBasis, Rows
from modallab.extraction.options import Damping

OF_POLE = 2  # parameters of a mode that place it; the others are its participation
TURNED = np.array([[0.0, -1.0], [1.0, 0.0]])  # times i, in parts


@dataclass(frozen=True, eq=False)
class _Terms:
    """A mode of shape psi and participation L gives `psi L p + conj(psi L) q`; all (n_rows, n_modes)."""

    pole: ComplexArray  # p
    mirror: ComplexArray  # q
    pole_slopes: tuple[ComplexArray, ComplexArray]  # of p by the two parameters
    mirror_slopes: tuple[ComplexArray, ComplexArray]


class _Law(Protocol):
    def __call__(self, omega: FloatArray, stiffness: FloatArray, damping: FloatArray) -> _Terms: ...


def _structural(omega: FloatArray, stiffness: FloatArray, damping: FloatArray) -> _Terms:
    """`p = 1/(lambda - omega^2)`, without a mirror."""
    one = np.asarray(1 / (stiffness + 1j * damping - omega[:, None] ** 2), complex)
    none = np.zeros_like(one)
    return _Terms(one, none, (-(one**2), -1j * one**2), (none, none))


def _viscous(omega: FloatArray, stiffness: FloatArray, damping: FloatArray) -> _Terms:
    """`p = 1/((s - conj(s)) (i omega - s))`, q the same of conj(s), as `modal_basis.Viscous` has a mode."""
    across = np.sqrt(np.maximum(stiffness - damping**2 / 4, np.finfo(float).tiny))
    by_stiffness, by_damping = 0.5 / across, -damping / (4 * across)  # slopes of `across`

    def of(pole: ComplexArray, side: int) -> tuple[ComplexArray, tuple[ComplexArray, ComplexArray]]:
        gap = 1j * omega[:, None] - pole
        one = 1 / (2j * side * across * gap)
        slopes = (side * 1j * by_stiffness, -0.5 + side * 1j * by_damping)  # of the pole
        own = (by_stiffness, by_damping)
        first, second = (one * (s / gap - a / across) for s, a in zip(slopes, own, strict=True))
        return one, (first, second)

    pole, pole_slopes = of(-damping / 2 + 1j * across, 1)
    mirror, mirror_slopes = of(-damping / 2 - 1j * across, -1)
    return _Terms(pole, mirror, pole_slopes, mirror_slopes)


_LAWS: Mapping[Damping, _Law] = {Damping.STRUCTURAL: _structural, Damping.VISCOUS: _viscous}


@dataclass(frozen=True, eq=False)
class Participating:
    """Rank one: `A_jk = psi_j L_k`; parameters are those of the law, then parts of each L but one.

    Of a mode's L the one named by `pivot` is held at 1: its size is that of the shape.
    """

    damping: Damping
    pivot: IntArray  # (n_modes,) which reference
    n_references: int

    @property
    def turn(self) -> FloatArray:
        """(2, n_parameters, n_slopes)."""
        n_free = self.n_references - 1
        turn = np.zeros((2, OF_POLE + 2 * n_free, 4 + 2 * n_free))
        for c in (0, 1):
            turn[c, 0, c] = turn[c, 1, 2 + c] = 1.0
        real, imaginary = OF_POLE + 2 * np.arange(n_free), OF_POLE + 1 + 2 * np.arange(n_free)
        first, second = 4 + 2 * np.arange(n_free), 5 + 2 * np.arange(n_free)
        turn[0, real, first] = turn[1, real, second] = turn[0, imaginary, second] = 1.0
        turn[1, imaginary, first] = -1.0
        return turn

    @property
    def _law(self) -> ModalBasis:
        return BASES[self.damping]

    @property
    def _free(self) -> IntArray:
        """(n_modes, n_references - 1) which references are not held."""
        every = np.broadcast_to(np.arange(self.n_references), (len(self.pivot), self.n_references))
        return np.asarray(every[every != self.pivot[:, None]].reshape(len(self.pivot), -1))

    def start(self, parameters: FloatArray, participation: ComplexArray) -> FloatArray:
        """Return the parameters of modes, (n_modes, n_parameters), from those of the law and every L."""
        held = participation / np.take_along_axis(participation, self.pivot[:, None], axis=1)
        free = np.take_along_axis(held, self._free, axis=1)
        parts = np.stack([free.real, free.imag], axis=2).reshape(len(parameters), -1)
        return np.concatenate([parameters, parts], axis=1)

    def participation(self, parameters: FloatArray) -> ComplexArray:
        """Return L of every mode, (n_modes, n_references)."""
        reach = np.ones((len(parameters), self.n_references), complex)
        free = parameters[:, OF_POLE::2] + 1j * parameters[:, OF_POLE + 1 :: 2]
        np.put_along_axis(reach, self._free, free, axis=1)
        return reach

    def at(self, order: IntArray) -> "Participating":
        """Return the same for modes in another order."""
        return replace(self, pivot=self.pivot[order])

    def parameters(self, eigenvalue: ComplexArray) -> FloatArray:
        """Return those of the law, (n_modes, 2)."""
        return self._law.parameters(eigenvalue)

    def loss_factor(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (n_modes,) and the derivatives by the law's parameters, (n_modes, 2)."""
        return self._law.loss_factor(parameters[:, :OF_POLE])

    def columns(self, rows: Rows, parameters: FloatArray) -> ComplexArray:
        """Return (n_rows, n_modes, 2)."""
        terms = self._terms(rows, parameters)
        reach = self.participation(parameters).T[rows.reference]
        return _pair(reach * terms.pole, reach.conj() * terms.mirror)

    def slopes(self, rows: Rows, parameters: FloatArray) -> ComplexArray:
        """Return (n_rows, n_modes, n_slopes)."""
        terms = self._terms(rows, parameters)
        reach = self.participation(parameters).T[rows.reference]
        of_pole = [
            _pair(reach * p, reach.conj() * q)
            for p, q in zip(terms.pole_slopes, terms.mirror_slopes, strict=True)
        ]
        here = rows.reference[:, None, None] == self._free
        both = _pair(terms.pole, terms.mirror)
        of_reach = (here[..., None] * both[:, :, None]).reshape(*both.shape[:2], -1)
        return np.concatenate([*of_pole, of_reach], axis=2)

    def constant(self, parameters: FloatArray) -> FloatArray:
        """Return (n_modes, n_references, 2, 2)."""
        reach = self.participation(parameters)[..., None, None]
        return np.asarray(reach.real * np.eye(2) + reach.imag * TURNED)

    def constant_slopes(self, parameters: FloatArray) -> FloatArray:
        """Return the derivatives of `constant`, (n_modes, n_references, n_parameters, 2, 2)."""
        n_modes, n_parameters = parameters.shape
        slopes = np.zeros((n_modes, self.n_references, n_parameters, 2, 2))
        modes, free = np.arange(n_modes)[:, None], np.arange(self.n_references - 1)
        slopes[modes, self._free, OF_POLE + 2 * free] = np.eye(2)
        slopes[modes, self._free, OF_POLE + 1 + 2 * free] = TURNED
        return slopes

    def _terms(self, rows: Rows, parameters: FloatArray) -> _Terms:
        return _LAWS[self.damping](rows.omega, parameters[:, 0], parameters[:, 1])


def _pair(pole: ComplexArray, mirror: ComplexArray) -> ComplexArray:
    """Return what real and imaginary part of a shape multiply, (n_rows, n_modes, 2)."""
    return np.stack([pole + mirror, 1j * (pole - mirror)], axis=2)
