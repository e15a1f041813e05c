"""Modes of leaked lines: leakage of each is that of its nearest mode, as modes known one by one tell it."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.modal_model import ModalModel
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.modal_fit import fitted_receptance
from modallab.extraction.multi_mode.refinement import BandData, StartingPoles
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.leakage import SinglePole, WindowLeakage

LEAKED = 0.02  # relative error that a line at a resonance has left, once corrected; on the flanks far less
FLANKS = 0.1  # of that error is left anywhere
CLEAR = 3.0  # standard errors, before a cleaned line is held to disagree


@dataclass(frozen=True, eq=False)
class LeakageCorrection:
    """What lines that leak are cleaned by."""

    leakage: WindowLeakage
    modes: ModalFit | None  # from a method that undoes leakage mode by mode; None where it sees none
    bias: FloatArray  # (n_modes, 2) what leakage may still move these by: frequency, Hz, and loss factor
    drive: int | None  # which of the FRFs is that of the drive point
    averages: float = np.inf  # effective, of the lines


def leakage_correction(
    leakage: WindowLeakage, alone: ModalModel | None, drive: int | None, averages: float = np.inf
) -> LeakageCorrection:
    """Return what lines are cleaned by.

    Parameters
    ----------
    leakage
        What a window did to them.
    alone
        Modes found one by one with leakage undone; None where there are none.
    drive
        Which of the FRFs is that of the drive point.
    """
    modes = () if alone is None else alone.modes
    bias = [[mode.leakage_bias["frequency"], mode.leakage_bias["loss_factor"]] for mode in modes]
    return LeakageCorrection(
        leakage, None if alone is None else _as_fit(alone), np.reshape(bias, (-1, 2)), drive, averages
    )


def _as_fit(model: ModalModel) -> ModalFit:
    """Return modes found one by one in the form of a fit of all, errors of each independent."""
    assert model.modal_constant is not None
    assert model.residuals is not None
    assert model.modal_constant_error is not None
    error = [mode.standard_errors[name] for name in ("frequency", "loss_factor") for mode in model.modes]
    return ModalFit(
        eigenvalue=np.array([mode.eigenvalue for mode in model.modes]),
        modal_constant=model.modal_constant,
        residuals=model.residuals,
        eigenvalue_covariance=np.diag(np.square(error)),
        modal_constant_error=model.modal_constant_error,
        misfit=np.ones(model.modal_constant.shape[1]),
    )


def cleaned(stretch: BandData, leaked: LeakageCorrection, damping: Damping) -> BandData:
    """Return the lines with their leakage undone, and weights that know what may be left.

    A leaked resonance has the shape of the window, to which a pole finder fits several poles. The closed
    form of `WindowLeakage.correction` is that of one mode and a smooth rest: here the mode is the nearest to
    each line, the rest all others. At antiresonances, where all is leakage, that fails: a line is trusted no
    further than it agrees with the modes that cleaned it.
    """
    if leaked.modes is None:
        return stretch
    receptance = stretch.receptance * _undo(leaked.modes, stretch, leaked, damping)
    weight = leaked_weights(leaked.modes.eigenvalue, replace(stretch, receptance=receptance))
    away = np.abs(receptance - fitted_receptance(leaked.modes, stretch.freq, damping)) ** 2
    doubt = np.where(weight * away > CLEAR**2, away, 0.0)
    return replace(stretch, receptance=receptance, weight=weight / (1 + weight * doubt))


def all_starts(start: StartingPoles, leaked: LeakageCorrection, freq: FloatArray) -> StartingPoles:
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
    return StartingPoles(np.concatenate([known.eigenvalue[inside], start.eigenvalue[new]]), reach)


def leaked_weights(eigenvalue: ComplexArray, stretch: BandData) -> FloatArray:
    """Return weights with what leakage may be wrong by: in proportion to power about a resonance."""
    own = eigenvalue[nearest_mode(eigenvalue, stretch.freq)]
    near = np.maximum(own.imag / np.abs(own - (2 * np.pi * stretch.freq) ** 2), FLANKS)
    used = stretch.weight > 0
    error = (LEAKED * near[:, None] * np.abs(stretch.receptance)) ** 2
    return np.where(used, 1 / (1 / np.where(used, stretch.weight, 1.0) + error), 0.0)


def nearest_mode(eigenvalue: ComplexArray, freq: FloatArray) -> IntArray:
    """Return the mode nearest to each line, of those inside the range."""
    frequency = np.sqrt(eigenvalue.real) / (2 * np.pi)
    inside = np.flatnonzero((frequency >= freq[0]) & (frequency <= freq[-1]))
    if not len(inside):
        inside = np.arange(len(frequency))
    away = np.abs(freq[:, None] - frequency[inside])
    return np.asarray(inside[away.argmin(axis=1)])


def _undo(fit: ModalFit, stretch: BandData, leaked: LeakageCorrection, damping: Damping) -> ComplexArray:
    """Return what to multiply the lines by, (n_lines, n_frf)."""
    own = nearest_mode(fit.eigenvalue, stretch.freq)
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
    undone = leaked.leakage.correction(
        stretch.freq[:, None, None],
        float(np.median(np.diff(stretch.freq))),
        SinglePole(eigenvalue, -eigenvalue * constant, beside[..., None]),
        SinglePole(eigenvalue, -eigenvalue * driven, beside_drive[..., None]),
    )
    return np.asarray(undone[..., 0])
