"""Leakage correction of lines by the nearest of the modes identified one by one."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.modal_model import ModalModel
from modallab.extraction.multi_mode.fit_result import ModalFit
from modallab.extraction.multi_mode.leakage_settings import LEAKAGE_CORRECTION
from modallab.extraction.multi_mode.modal_fit import fitted_receptance
from modallab.extraction.multi_mode.refinement import BandData, StartingPoles
from modallab.extraction.options import Damping
from modallab.extraction.preprocessing.leakage import SinglePole, WindowLeakage


@dataclass(frozen=True, eq=False)
class LeakageCorrection:
    """Reference modes and window of the leakage correction."""

    leakage: WindowLeakage
    """Leakage of the window."""
    modes: ModalFit | None
    """Reference modes from a single-mode method with leakage correction; None if there are none."""
    bias: FloatArray
    """(n_modes, 2) remaining bias by leakage of their frequency, Hz, and loss factor."""
    drive: int | None
    """Index of the drive-point FRF; None if there is none."""
    averages: float = np.inf
    """Effective number of averages of the lines."""


def leakage_correction(
    leakage: WindowLeakage, single_modes: ModalModel | None, drive: int | None, averages: float = np.inf
) -> LeakageCorrection:
    """Return the leakage correction of lines.

    Parameters
    ----------
    leakage
        Of the window.
    single_modes
        Modes identified one by one with leakage correction; None if there are none.
    drive
        Index of the drive-point FRF; None if there is none.
    averages
        Effective number of averages of the lines.
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
    """Return modes identified one by one as a fit of all modes with independent errors."""
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


def corrected_lines(band_data: BandData, leaked: LeakageCorrection, damping: Damping) -> BandData:
    """Return the lines with leakage corrected, and weights that include the remaining leakage.

    A leaked resonance has the shape of the window, to which a pole finder fits several poles. The closed form
    of `WindowLeakage.correction` is that of one mode and a smooth residual: here the mode nearest to each
    line, with all others as residual. It fails at antiresonances, where all is leakage: the error of a line
    is at least its difference from the reference modes.
    """
    if leaked.modes is None:
        return band_data
    receptance = band_data.receptance * _correction_factors(leaked.modes, band_data, leaked, damping)
    weight = leaked_weights(leaked.modes.eigenvalue, replace(band_data, receptance=receptance))
    squared_difference = np.abs(receptance - fitted_receptance(leaked.modes, band_data.freq, damping)) ** 2
    doubt = np.where(
        weight * squared_difference > LEAKAGE_CORRECTION.disagreement_errors**2, squared_difference, 0.0
    )
    return replace(band_data, receptance=receptance, weight=weight / (1 + weight * doubt))


def all_starts(start: StartingPoles, leaked: LeakageCorrection, freq: FloatArray) -> StartingPoles:
    """Return the reference modes, and those of `start` that are different from them.

    Remaining leakage can hide stable poles in a chart.
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


def leaked_weights(eigenvalue: ComplexArray, band_data: BandData) -> FloatArray:
    """Return weights with the error of the leakage correction, proportional to power near a resonance."""
    eigenvalue_of_line = eigenvalue[nearest_mode(eigenvalue, band_data.freq)]
    relative_size = np.maximum(
        eigenvalue_of_line.imag / np.abs(eigenvalue_of_line - (2 * np.pi * band_data.freq) ** 2),
        LEAKAGE_CORRECTION.smallest_flank_error,
    )
    used = band_data.weight > 0
    error = (LEAKAGE_CORRECTION.resonance_error * relative_size[:, None] * np.abs(band_data.receptance)) ** 2
    return np.where(used, 1 / (1 / np.where(used, band_data.weight, 1.0) + error), 0.0)


def nearest_mode(eigenvalue: ComplexArray, freq: FloatArray) -> IntArray:
    """Return the index of the mode inside the range that is nearest to each line."""
    frequency = np.sqrt(eigenvalue.real) / (2 * np.pi)
    inside = np.flatnonzero((frequency >= freq[0]) & (frequency <= freq[-1]))
    if not len(inside):
        inside = np.arange(len(frequency))
    distance = np.abs(freq[:, None] - frequency[inside])
    return np.asarray(inside[distance.argmin(axis=1)])


def _correction_factors(
    fit: ModalFit, band_data: BandData, leaked: LeakageCorrection, damping: Damping
) -> ComplexArray:
    """Return the ratio of true to leaked lines, (n_lines, n_frf)."""
    nearest = nearest_mode(fit.eigenvalue, band_data.freq)
    x = (2 * np.pi * band_data.freq[:, None]) ** 2
    eigenvalue, constant = fit.eigenvalue[nearest][:, None], fit.modal_constant[nearest]
    background = fitted_receptance(fit, band_data.freq, damping) - constant / (eigenvalue - x)
    x, background = x[..., None], background[..., None]
    drive = leaked.drive
    if drive is None:
        driven, drive_background = np.zeros_like(constant[:, :1]), np.zeros_like(background[:, :1])
    else:
        driven, drive_background = constant[:, drive, None], background[:, drive, None]
    correction = leaked.leakage.correction(
        band_data.freq[:, None, None],
        float(np.median(np.diff(band_data.freq))),
        SinglePole.of_mode(eigenvalue, constant, x, background),
        SinglePole.of_mode(eigenvalue, driven, x, drive_background),
    )
    return np.asarray(correction[..., 0])
