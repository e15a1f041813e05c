"""Which columns of a stabilisation chart are modes, and why."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, frozen
from modallab.core.modal_model import StabilisationChart
from modallab.extraction.global_method import Poles

STABLE = 2  # in frequency and damping
APART = 0.2  # half-power bandwidths: what separates two columns
LEAST = 5  # orders at which a mode is stable
NEAR = 3.0  # half-power bandwidths: modes within them share their circles


@dataclass(frozen=True, eq=False)
class Selection:
    """Poles taken for modes, in rising frequency, and what speaks for each."""

    pole: ComplexArray  # (n_modes,) s = -zeta omega_r + i omega_r sqrt(1 - zeta^2), rad/s
    frequency_scatter: FloatArray  # (n_modes,) Hz, standard deviation over the orders
    loss_factor_scatter: FloatArray  # (n_modes,)
    mode: IntArray  # (n_poles,) which mode each pole of the chart speaks for, from 0; -1 for none
    reasons: tuple[str, ...]  # (n_modes,) in words
    pairs: tuple[tuple[int, int], ...]  # neighbouring modes so close that they need each other's part
    left_out: tuple[str, ...]  # in words: columns that might have been modes, and why they are not

    def __post_init__(self) -> None:
        n = len(self.pole)
        object.__setattr__(self, "pole", frozen(self.pole, complex, (n,), name="pole"))
        for name in ("frequency_scatter", "loss_factor_scatter"):
            object.__setattr__(self, name, frozen(getattr(self, name), float, (n,), name=name))
        object.__setattr__(self, "mode", frozen(self.mode, int, (None,), name="mode"))

    @property
    def frequency(self) -> FloatArray:
        """(n_modes,) |s|/2 pi, Hz."""
        return np.asarray(np.abs(self.pole) / (2 * np.pi))

    @property
    def loss_factor(self) -> FloatArray:
        """(n_modes,) twice the damping ratio."""
        return np.asarray(-2 * self.pole.real / np.abs(self.pole))


def chart_of(poles: Poles, stability: IntArray, selection: Selection) -> StabilisationChart:
    """Return the chart that shows what was found and taken."""
    return StabilisationChart(poles.order, poles.frequency, poles.loss_factor, stability, selection.mode)


def select(poles: Poles, stability: IntArray) -> Selection:
    """Return the modes that a chart shows, with the reason for each, and what was not taken.

    Parameters
    ----------
    poles
        Of rising orders, from a member of `GLOBAL_METHODS`.
    stability
        (n_poles,) from `stabilise`.
    """
    stable = np.flatnonzero(stability >= STABLE)
    order = stable[np.argsort(poles.frequency[stable], kind="stable")]
    frequency = poles.frequency[order]
    width = poles.loss_factor[order] * frequency
    breaks = np.diff(frequency) > APART * np.minimum(width[1:], width[:-1])
    columns = np.split(order, np.flatnonzero(breaks) + 1) if len(order) else []
    taken = [column for column in columns if len(column) >= LEAST]
    mode = np.full(len(poles.order), -1)
    for m, column in enumerate(taken):
        mode[column] = m
    pole = np.array([_median(poles.pole[column]) for column in taken], complex)
    size = np.abs(pole)
    apart = np.diff(size) / np.maximum(-2 * pole.real[1:], -2 * pole.real[:-1])
    return Selection(
        pole,
        np.array([poles.frequency[column].std() for column in taken]),
        np.array([poles.loss_factor[column].std() for column in taken]),
        mode,
        tuple(f"stable at {len(column)} orders" for column in taken),
        tuple((int(m), int(m) + 1) for m in np.flatnonzero(apart < NEAR)),
        tuple(
            f"{poles.frequency[column].mean():g} Hz: stable at {len(column)} orders only"
            for column in columns
            if len(column) < LEAST
        ),
    )


def _median(pole: ComplexArray) -> complex:
    return complex(np.median(pole.real), np.median(pole.imag))
