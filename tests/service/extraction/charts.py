"""Stabilisation charts put together by hand."""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.extraction.multi_mode.global_method import Poles

SPACING = 0.5  # Hz


def pole(frequency: float, loss_factor: float) -> complex:
    """Return the pole of a frequency, Hz, and a loss factor, rad/s."""
    omega, ratio = 2 * np.pi * frequency, loss_factor / 2
    return complex(-ratio * omega, omega * np.sqrt(1 - ratio**2))


def chart(
    rows: Sequence[tuple[int, float, float]],
    vectors: ComplexArray | None = None,
    strength: float | Sequence[float] = 100.0,
    orders: Sequence[int] = (),
) -> Poles:
    """Return poles of (order, frequency Hz, loss factor), all of one vector unless given."""
    return Poles(
        np.unique([*orders, *(row[0] for row in rows)]).astype(int),
        np.array([row[0] for row in rows], int),
        np.array([pole(row[1], row[2]) for row in rows], complex),
        np.ones((len(rows), 3), complex) if vectors is None else vectors,
        np.broadcast_to(np.asarray(strength, float), (len(rows),)),
        SPACING,
    )
