"""Modes of leaked lines: leakage of each is that of its nearest mode, undone and the modes fitted again."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.progress import Progress, part
from modallab.extraction.leakage import Leakage, OnePole
from modallab.extraction.modal_fit import ModalFit, fit_modes, fitted_receptance
from modallab.extraction.options import Damping
from modallab.extraction.refinement import Refined, Stretch, within

ROUNDS = 8  # the correction needs the modes that it corrects
LEAKED = 0.1  # relative error of a line at a resonance before it is corrected; on the flanks far less
LEFT = 0.1  # part of what leakage moves a mode by that the correction may leave
WIDEST = 0.25  # Hz of distance from its mode over that from the next, where a line is one mode's alone


def without_leakage(
    refined: Refined,
    stretch: Stretch,
    leakage: Leakage,
    damping: Damping,
    drive: int | None,
    progress: Progress,
) -> Refined:
    """Return the modes fitted to lines whose leakage has been undone.

    The closed form of `Leakage.undone` is that of one mode and a smooth rest. Here the mode is the nearest
    to each line, the rest all others.

    Parameters
    ----------
    refined
        Modes of the lines as they are.
    drive
        Which of the FRFs is that of the drive point, None if none is.
    """
    fit = refined.fit
    undone = np.ones_like(stretch.receptance)
    for n in range(ROUNDS):
        step = _undo(fit, stretch, leakage, damping, drive)
        share = 1.0 if n < ROUNDS // 2 else 0.5  # else modes much narrower than a line swing about the answer
        undone = (1 - share) * undone + share * step
        before = fit
        fit = fit_modes(
            stretch.freq,
            stretch.receptance * undone,
            _weights(fit, stretch, LEAKED),
            before.eigenvalue,
            damping=damping,
            progress=part(progress, n / ROUNDS, (n + 1) / ROUNDS),
        )
    first = refined.fit
    moved = np.stack([fit.frequency - first.frequency, fit.loss_factor - first.loss_factor], axis=1)
    return replace(refined, fit=fit, weight=_weights(fit, stretch, LEAKED), leakage_bias=LEFT * np.abs(moved))


def _nearest(fit: ModalFit, freq: FloatArray) -> IntArray:
    """Return the mode nearest to each line, of those inside the range."""
    inside = np.flatnonzero(within(fit, freq))
    away = np.abs(freq[:, None] - fit.frequency[inside])
    return np.asarray(inside[away.argmin(axis=1)])


def _weights(fit: ModalFit, stretch: Stretch, leaked: float) -> FloatArray:
    """Return weights with what leakage may be wrong by: in proportion to power about a resonance."""
    own = _nearest(fit, stretch.freq)
    eigenvalue = fit.eigenvalue[own]
    near = eigenvalue.imag / np.abs(eigenvalue - (2 * np.pi * stretch.freq) ** 2)
    used = stretch.weight > 0
    error = (leaked * near[:, None] * np.abs(stretch.receptance)) ** 2
    return np.where(used, 1 / (1 / np.where(used, stretch.weight, 1.0) + error), 0.0)


def _undo(
    fit: ModalFit, stretch: Stretch, leakage: Leakage, damping: Damping, drive: int | None
) -> ComplexArray:
    """Return what to multiply the lines by, (n_lines, n_frf)."""
    own = _nearest(fit, stretch.freq)
    x = (2 * np.pi * stretch.freq[:, None]) ** 2
    eigenvalue = fit.eigenvalue[own][:, None]
    constant = fit.modal_constant[own]
    rest = fitted_receptance(fit, stretch.freq, damping) - constant / (eigenvalue - x)
    # a mode's receptance, turned to inertance, is a mode and its modal constant
    beside = constant - x * rest
    if drive is None:
        driven, beside_drive = np.zeros_like(constant[:, :1]), np.zeros_like(beside[:, :1])
    else:
        driven, beside_drive = constant[:, drive, None], beside[:, drive, None]
    undone = leakage.undone(
        stretch.freq[:, None, None],
        float(np.median(np.diff(stretch.freq))),
        OnePole(eigenvalue, -eigenvalue * constant, beside[..., None]),
        OnePole(eigenvalue, -eigenvalue * driven, beside_drive[..., None]),
    )
    return np.asarray(undone[..., 0])
