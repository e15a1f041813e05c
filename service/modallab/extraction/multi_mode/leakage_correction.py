"""Modes of leaked lines: leakage of each is that of its nearest mode, as modes known one by one tell it."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.modal_model import ModalModel
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.modal_fit import fitted_receptance
from modallab.extraction.multi_mode.refinement import BandData, StartingPoles
from modallab.extraction.multi_mode.settings import LEAKAGE_CORRECTION
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.leakage import SinglePole, WindowLeakage


@dataclass(frozen=True, eq=False)
class LeakageCorrection:
    """What lines that leak are cleaned by."""

    leakage: WindowLeakage
    modes: ModalFit | None  # from a method that undoes leakage mode by mode; None where it sees none
    bias: FloatArray  # (n_modes, 2) what leakage may still move these by: frequency, Hz, and loss factor
    drive: int | None  # which of the FRFs is that of the drive point
    averages: float = np.inf  # effective, of the lines


def leakage_correction(
    leakage: WindowLeakage, single_modes: ModalModel | None, drive: int | None, averages: float = np.inf
) -> LeakageCorrection:
    """Return what lines are cleaned by.

    Parameters
    ----------
    leakage
        What a window did to them.
    single_modes
        Modes found one by one with leakage undone; None where there are none.
    drive
        Which of the FRFs is that of the drive point.
    """
    modes = () if single_modes is None else single_modes.modes
    bias = [[mode.leakage_bias["frequency"], mode.leakage_bias["loss_factor"]] for mode in modes]
    return LeakageCorrection(
        leakage,
        None if single_modes is None else _as_fit(single_modes),
        np.reshape(bias, (-1, 2)),
        drive,
        averages,
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


def corrected_lines(stretch: BandData, leaked: LeakageCorrection, damping: Damping) -> BandData:
    """Return the lines with their leakage undone, and weights that know what may be left.

    A leaked resonance has the shape of the window, to which a pole finder fits several poles. The closed
    form of `WindowLeakage.correction` is that of one mode and a smooth rest: here the mode is the nearest to
    each line, the rest all others. At antiresonances, where all is leakage, that fails: a line is trusted no
    further than it agrees with the modes that cleaned it.
    """
    if leaked.modes is None:
        return stretch
    receptance = stretch.receptance * _correction_factors(leaked.modes, stretch, leaked, damping)
    weight = leaked_weights(leaked.modes.eigenvalue, replace(stretch, receptance=receptance))
    squared_difference = np.abs(receptance - fitted_receptance(leaked.modes, stretch.freq, damping)) ** 2
    doubt = np.where(
        weight * squared_difference > LEAKAGE_CORRECTION.disagreement_errors**2, squared_difference, 0.0
    )
    return replace(stretch, receptance=receptance, weight=weight / (1 + weight * doubt))


def all_starts(start: StartingPoles, leaked: LeakageCorrection, freq: FloatArray) -> StartingPoles:
    """Return the modes known one by one, and those of `start` that are none of these.

    What is left of leakage hides stable poles from a chart.
    """
    if leaked.modes is None:
        return start
    reference_modes = leaked.modes
    inside = (reference_modes.frequency >= freq[0]) & (reference_modes.frequency <= freq[-1])
    frequency, near = (
        np.sqrt(start.eigenvalue.real) / (2 * np.pi),
        reference_modes.loss_factor * reference_modes.frequency,
    )
    near = np.maximum(near, float(np.median(np.diff(freq))))
    new = ~(np.abs(frequency[:, None] - reference_modes.frequency) < near).any(axis=1)
    reach = start.participation
    if reach is not None:
        constants = reference_modes.modal_constant[inside].reshape(int(inside.sum()), -1, reach.shape[1])
        strongest = np.linalg.svd(constants, full_matrices=False)[2][:, 0]
        reach = np.concatenate([strongest, reach[new]])
    return StartingPoles(np.concatenate([reference_modes.eigenvalue[inside], start.eigenvalue[new]]), reach)


def leaked_weights(eigenvalue: ComplexArray, stretch: BandData) -> FloatArray:
    """Return weights with what leakage may be wrong by: in proportion to power about a resonance."""
    eigenvalue_of_line = eigenvalue[nearest_mode(eigenvalue, stretch.freq)]
    relative_size = np.maximum(
        eigenvalue_of_line.imag / np.abs(eigenvalue_of_line - (2 * np.pi * stretch.freq) ** 2),
        LEAKAGE_CORRECTION.smallest_flank_error,
    )
    used = stretch.weight > 0
    error = (LEAKAGE_CORRECTION.resonance_error * relative_size[:, None] * np.abs(stretch.receptance)) ** 2
    return np.where(used, 1 / (1 / np.where(used, stretch.weight, 1.0) + error), 0.0)


def nearest_mode(eigenvalue: ComplexArray, freq: FloatArray) -> IntArray:
    """Return the mode nearest to each line, of those inside the range."""
    frequency = np.sqrt(eigenvalue.real) / (2 * np.pi)
    inside = np.flatnonzero((frequency >= freq[0]) & (frequency <= freq[-1]))
    if not len(inside):
        inside = np.arange(len(frequency))
    distance = np.abs(freq[:, None] - frequency[inside])
    return np.asarray(inside[distance.argmin(axis=1)])


def _correction_factors(
    fit: ModalFit, stretch: BandData, leaked: LeakageCorrection, damping: Damping
) -> ComplexArray:
    """Return what to multiply the lines by, (n_lines, n_frf)."""
    nearest = nearest_mode(fit.eigenvalue, stretch.freq)
    x = (2 * np.pi * stretch.freq[:, None]) ** 2
    eigenvalue = fit.eigenvalue[nearest][:, None]
    constant = fit.modal_constant[nearest]
    background = fitted_receptance(fit, stretch.freq, damping) - constant / (eigenvalue - x)
    # a mode's receptance, turned to inertance, is a mode and its modal constant
    residual = constant - x * background
    drive = leaked.drive
    if drive is None:
        driven, drive_residual = np.zeros_like(constant[:, :1]), np.zeros_like(residual[:, :1])
    else:
        driven, drive_residual = constant[:, drive, None], residual[:, drive, None]
    correction = leaked.leakage.correction(
        stretch.freq[:, None, None],
        float(np.median(np.diff(stretch.freq))),
        SinglePole(eigenvalue, -eigenvalue * constant, residual[..., None]),
        SinglePole(eigenvalue, -eigenvalue * driven, drive_residual[..., None]),
    )
    return np.asarray(correction[..., 0])
