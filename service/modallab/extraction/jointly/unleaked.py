"""Modes of leaked lines: leakage of each is that of its nearest mode, as modes known one by one tell it."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.modal_model import ModalModel
from modallab.extraction.jointly.fitted import ModalFit
from modallab.extraction.jointly.modal_fit import fit_modes, fitted_receptance
from modallab.extraction.jointly.refinement import Refined, Start, Stretch
from modallab.extraction.measured.leakage import Leakage, OnePole
from modallab.extraction.options import Damping

LEAKED = 0.02  # relative error that a line at a resonance has left, once corrected; on the flanks far less
FLANKS = 0.1  # of that error is left anywhere
CLEAR = 3.0  # standard errors, before a cleaned line is held to disagree
LEFT = 0.05  # part of what leakage moves a mode by that the correction may leave


@dataclass(frozen=True, eq=False)
class Leaked:
    """What lines that leak are cleaned by."""

    leakage: Leakage
    modes: ModalFit | None  # from a method that undoes leakage mode by mode; None where it sees none
    drive: int | None  # which of the FRFs is that of the drive point


def as_fit(model: ModalModel) -> ModalFit:
    """Return modes found one by one in the form of a fit of all, without errors."""
    assert model.modal_constant is not None
    assert model.residuals is not None
    n, n_frf = model.modal_constant.shape
    return ModalFit(
        eigenvalue=np.array([mode.eigenvalue for mode in model.modes]),
        modal_constant=model.modal_constant,
        residuals=model.residuals,
        eigenvalue_covariance=np.zeros((2 * n, 2 * n)),
        modal_constant_error=np.zeros((n, n_frf)),
        misfit=np.ones(n_frf),
    )


def cleaned(stretch: Stretch, leaked: Leaked, damping: Damping) -> Stretch:
    """Return the lines with their leakage undone, and weights that know what may be left.

    A leaked resonance has the shape of the window, to which a pole finder fits several poles. The closed
    form of `Leakage.undone` is that of one mode and a smooth rest: here the mode is the nearest to each line,
    the rest all others. At antiresonances, where all is leakage, that fails: a line is trusted no
    further than it agrees with the modes that cleaned it.
    """
    if leaked.modes is None:
        return stretch
    receptance = stretch.receptance * _undo(leaked.modes, stretch, leaked, damping)
    weight = _weights(leaked.modes.eigenvalue, replace(stretch, receptance=receptance))
    away = np.abs(receptance - fitted_receptance(leaked.modes, stretch.freq, damping)) ** 2
    doubt = np.where(weight * away > CLEAR**2, away, 0.0)
    return replace(stretch, receptance=receptance, weight=weight / (1 + weight * doubt))


def all_starts(start: Start, leaked: Leaked, freq: FloatArray) -> Start:
    """Return the modes known one by one, and those of `start` that are none of these.

    What is left of leakage hides stable poles from a chart.
    """
    if leaked.modes is None:
        return start
    known = leaked.modes
    inside = (known.frequency >= freq[0]) & (known.frequency <= freq[-1])
    frequency, near = np.sqrt(start.eigenvalue.real) / (2 * np.pi), known.loss_factor * known.frequency
    near = np.maximum(near, float(np.median(np.diff(freq))))
    new = ~(np.abs(frequency[:, None] - known.frequency) < near).any(axis=1)
    reach = start.participation
    if reach is not None:
        constants = known.modal_constant[inside].reshape(int(inside.sum()), -1, reach.shape[1])
        strongest = np.linalg.svd(constants, full_matrices=False)[2][:, 0]
        reach = np.concatenate([strongest, reach[new]])
    return Start(np.concatenate([known.eigenvalue[inside], start.eigenvalue[new]]), reach)


def with_bias(refined: Refined, stretch: Stretch, damping: Damping) -> Refined:
    """Return the modes of cleaned lines with what leakage may still move them by.

    That is a part of what cleaning has moved them by, from a fit of the lines as they are.

    Parameters
    ----------
    stretch
        The lines as they are.
    """
    weight, fit = _weights(refined.fit.eigenvalue, stretch), refined.fit
    raw = fit_modes(
        stretch.freq,
        stretch.receptance,
        weight,
        fit.eigenvalue,
        damping=damping,
        participation=fit.participation,
    )
    moved = np.stack([fit.frequency - raw.frequency, fit.loss_factor - raw.loss_factor], axis=1)
    most = np.stack([fit.loss_factor * fit.frequency, fit.loss_factor], axis=1)
    return replace(refined, leakage_bias=LEFT * np.minimum(np.abs(moved), most))


def _nearest(eigenvalue: ComplexArray, freq: FloatArray) -> IntArray:
    """Return the mode nearest to each line, of those inside the range."""
    frequency = np.sqrt(eigenvalue.real) / (2 * np.pi)
    inside = np.flatnonzero((frequency >= freq[0]) & (frequency <= freq[-1]))
    if not len(inside):
        inside = np.arange(len(frequency))
    away = np.abs(freq[:, None] - frequency[inside])
    return np.asarray(inside[away.argmin(axis=1)])


def _weights(eigenvalue: ComplexArray, stretch: Stretch) -> FloatArray:
    """Return weights with what leakage may be wrong by: in proportion to power about a resonance."""
    own = eigenvalue[_nearest(eigenvalue, stretch.freq)]
    near = np.maximum(own.imag / np.abs(own - (2 * np.pi * stretch.freq) ** 2), FLANKS)
    used = stretch.weight > 0
    error = (LEAKED * near[:, None] * np.abs(stretch.receptance)) ** 2
    return np.where(used, 1 / (1 / np.where(used, stretch.weight, 1.0) + error), 0.0)


def _undo(fit: ModalFit, stretch: Stretch, leaked: Leaked, damping: Damping) -> ComplexArray:
    """Return what to multiply the lines by, (n_lines, n_frf)."""
    own = _nearest(fit.eigenvalue, stretch.freq)
    x = (2 * np.pi * stretch.freq[:, None]) ** 2
    eigenvalue = fit.eigenvalue[own][:, None]
    constant = fit.modal_constant[own]
    rest = fitted_receptance(fit, stretch.freq, damping) - constant / (eigenvalue - x)
    # a mode's receptance, turned to inertance, is a mode and its modal constant
    beside = constant - x * rest
    drive = leaked.drive
    if drive is None:
        driven, beside_drive = np.zeros_like(constant[:, :1]), np.zeros_like(beside[:, :1])
    else:
        driven, beside_drive = constant[:, drive, None], beside[:, drive, None]
    undone = leaked.leakage.undone(
        stretch.freq[:, None, None],
        float(np.median(np.diff(stretch.freq))),
        OnePole(eigenvalue, -eigenvalue * constant, beside[..., None]),
        OnePole(eigenvalue, -eigenvalue * driven, beside_drive[..., None]),
    )
    return np.asarray(undone[..., 0])
