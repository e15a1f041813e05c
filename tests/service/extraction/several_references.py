"""A structure with two modes at one frequency, driven at one point or two."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet

FREQ = np.arange(0.0, 120.25, 0.25)
DOFS = tuple(Dof(node, "Y") for node in range(1, 7))
LOSS = 0.01
SHAPES = np.random.default_rng(3).standard_normal((4, len(DOFS)))  # 1/sqrt(kg)
PAIR = slice(1, 3)
AVERAGES = 100.0


@dataclass(frozen=True, eq=False)
class Driven:
    """FRFs with noise, and the coherence that it leaves."""

    frf: FrfSet
    coherence: FloatArray  # (n_freq, n_out, n_in)
    frequencies: FloatArray


def frequencies(gap: float) -> FloatArray:
    """Return the natural frequencies; `gap` of the pair in half-power bandwidths."""
    return np.array([30.0, 55.0, 55.0 * (1 + gap * LOSS), 90.0])


def exact(gap: float, drives: tuple[int, ...]) -> ComplexArray:
    """(n_freq, 6, n_drives) inertance."""
    eigenvalue = (2 * np.pi * frequencies(gap)) ** 2
    omega2 = (2 * np.pi * FREQ[:, None]) ** 2
    poles = -omega2 / (eigenvalue * (1 + 1j * LOSS) - omega2)
    return np.asarray(np.einsum("fr,rj,rk->fjk", poles, SHAPES, SHAPES[:, list(drives)]))


def driven(
    gap: float, drives: tuple[int, ...] = (0, 1), noise: float = 1e-3, seed: int = 1, turned: bool = False
) -> Driven:
    """Return FRFs driven at some of the DoFs, noise over rms; `turned`: a hammer roves, these listen."""
    values = exact(gap, drives)
    rng = np.random.default_rng(seed)
    error = rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape)
    level = noise * np.sqrt((np.abs(values) ** 2).mean(axis=0))
    measured = values + level * error / np.sqrt(2)
    coherence = 1 / (1 + AVERAGES * level**2 / np.abs(measured) ** 2)
    few = tuple(DOFS[i] for i in drives)
    if turned:
        measured, coherence = measured.swapaxes(1, 2), coherence.swapaxes(1, 2)
    outputs, inputs = (few, DOFS) if turned else (DOFS, few)
    return Driven(FrfSet(FREQ, measured, outputs, inputs, FrfKind.INERTANCE), coherence, frequencies(gap))
