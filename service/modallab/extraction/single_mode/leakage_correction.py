"""Leakage correction of the lines of every mode in every FRF."""

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.extraction.preprocessing.leakage import SinglePole, WindowLeakage
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fit_data import FitData
from modallab.extraction.single_mode.fit_table import FitIteration


def leakage_corrections(
    damping_model: DampingModel,
    data: FitData,
    leakage: WindowLeakage,
    fits: FitIteration,
    residual: ComplexArray,
) -> ComplexArray:
    """Return the ratio of true to leaked receptance of every line, (n_modes, n_frf, n_lines).

    `residual` is the receptance beside each mode, m/N.
    """
    # one mode after another, because each line needs a hundred quadrature nodes
    corrections = [
        leakage.correction(data.freq[m], data.spacing, *pole_pair)
        for m, pole_pair in enumerate(inertance_poles(damping_model, data, fits, residual))
    ]
    return np.stack(corrections)


def inertance_poles(
    damping_model: DampingModel, data: FitData, fits: FitIteration, residual: ComplexArray
) -> list[tuple[SinglePole, SinglePole]]:
    """Return each mode as a pole in inertance, in all FRFs and at the drive point.

    Parameters as in `leakage_corrections`.
    """
    squared, constant = damping_model.pole(fits.eigenvalue, fits.table.modal_constant)
    mode = damping_model.response(
        data.freq, fits.eigenvalue[:, :, None], fits.table.modal_constant[:, :, None]
    )
    pole = constant[:, :, None] / (squared[:, :, None] - data.x)
    background = residual + mode - pole
    drive_row = data.drive
    if drive_row is None:
        drive, drive_residual = np.zeros_like(constant), np.zeros_like(residual)
    else:
        used = data.weight[:, drive_row] > 0
        inertance = constant[:, drive_row, None] - data.x[:, drive_row] * background[:, drive_row]
        mean = (used * inertance).sum(axis=1) / np.maximum(used.sum(axis=1), 1)
        drive = np.broadcast_to(constant[:, drive_row, None], constant.shape)
        drive_residual = np.broadcast_to(mean[:, None, None], residual.shape)
    return [
        (
            SinglePole.of_mode(squared[m], constant[m], data.x[m], background[m]),
            SinglePole(squared[m], -squared[m] * drive[m], drive_residual[m]),
        )
        for m in range(len(squared))
    ]
