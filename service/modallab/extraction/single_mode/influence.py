"""Influence functions: derivatives of a fitted mode with respect to each of its lines."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fit_data import FitData
from modallab.extraction.single_mode.fit_table import FitIteration
from modallab.extraction.single_mode.fitting import fit_once
from modallab.extraction.single_mode.method import ExtractionMethod
from modallab.extraction.single_mode.settings import INFLUENCE


def influence(
    method: ExtractionMethod,
    damping_model: DampingModel,
    data: FitData,
    fits: FitIteration,
    m: int,
    frfs: slice,
) -> ComplexArray:
    """Return the influence g, (n_frf, 4, n_lines): errors e of lines shift a parameter by `Re(sum g e)`.

    Parameters are real and imaginary part of the eigenvalue, (rad/s)^2, and of the modal constant, 1/kg. The
    influence is the difference quotient of fits of the same method to exact lines of the mode and a constant,
    where no weight depends on an error.

    Parameters
    ----------
    method, damping_model
        Single-mode method and damping law.
    data, fits
        Lines, and the fits to them.
    m, frfs
        Index of the mode, and its FRFs.
    """
    identified = fits.table.frequency[m, frfs, None] > 0
    freq, weight = data.freq[m, frfs], np.where(identified, data.weight[m, frfs], 0.0)
    eigenvalue, constant = fits.eigenvalue[m, frfs, None], fits.table.modal_constant[m, frfs, None]
    exact = damping_model.response(freq, eigenvalue, constant) + fits.residual[m, frfs]
    n_frf, n_lines = freq.shape
    step = INFLUENCE.step * np.abs(exact).max(axis=1)
    perturbations = np.concatenate([np.zeros((1, n_lines)), np.eye(n_lines), 1j * np.eye(n_lines)])
    lines = exact[:, None, :] + step[:, None, None] * perturbations
    batch = (1, n_frf * len(perturbations), n_lines)
    repeated = replace(
        data,
        freq=np.repeat(freq, len(perturbations), axis=0).reshape(batch),
        weight=np.repeat(weight, len(perturbations), axis=0).reshape(batch),
    )
    kind = fits.inertance[m : m + 1]
    refits = fit_once(method, damping_model, repeated, lines.reshape(batch), kind, screened=False)
    perturbed = np.stack([refits.eigenvalue, refits.table.modal_constant], axis=-1).reshape(
        n_frf, len(perturbations), 2
    )
    slope = (perturbed[:, 1:] - perturbed[:, :1]) / np.where(step > 0, step, 1.0)[:, None, None]
    parts = np.stack([slope.real, slope.imag], axis=-1).reshape(n_frf, 2, n_lines, 4)
    return np.asarray((parts[:, 0] - 1j * parts[:, 1]).swapaxes(1, 2))
