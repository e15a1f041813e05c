"""How a fitted mode follows each of the lines that it is fitted to."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fitting import Data, Round, fit_once
from modallab.extraction.single_mode.method import ExtractionMethod

STEP = 1e-6  # of the highest line: curvature and rounding are both far below it


def influence(
    method: ExtractionMethod, law: DampingModel, data: Data, now: Round, m: int, frfs: slice
) -> ComplexArray:
    """Return g: an error e of the lines moves a part of a mode by `Re(sum_k g_k e_k)`, (n_frf, 4, n_lines).

    Parts are real and imaginary part of the eigenvalue, (rad/s)^2, and of the modal constant, 1/kg. From
    differences of fits to lines that the mode and a constant explain, where no weight depends on an error:
    each method by its own.

    Parameters
    ----------
    method, law
        How the mode was fitted, and what its damping does.
    data, now
        Lines, and the fits to them.
    m, frfs
        Which mode, in which FRFs.
    """
    found = now.table.frequency[m, frfs, None] > 0
    freq, weight = data.freq[m, frfs], np.where(found, data.weight[m, frfs], 0.0)
    eigenvalue, constant = now.eigenvalue[m, frfs, None], now.table.modal_constant[m, frfs, None]
    exact = law.response(freq, eigenvalue, constant) + now.rest[m, frfs]
    n_frf, n_lines = freq.shape
    step = STEP * np.abs(exact).max(axis=1)
    moves = np.concatenate([np.zeros((1, n_lines)), np.eye(n_lines), 1j * np.eye(n_lines)])
    lines = exact[:, None, :] + step[:, None, None] * moves
    every = (1, n_frf * len(moves), n_lines)
    repeated = replace(
        data,
        freq=np.repeat(freq, len(moves), axis=0).reshape(every),
        weight=np.repeat(weight, len(moves), axis=0).reshape(every),
    )
    fits = fit_once(method, law, repeated, lines.reshape(every), now.inertance[m : m + 1])
    moved = np.stack([fits.eigenvalue, fits.table.modal_constant], axis=-1).reshape(n_frf, len(moves), 2)
    slope = (moved[:, 1:] - moved[:, :1]) / np.where(step > 0, step, 1.0)[:, None, None]
    parts = np.stack([slope.real, slope.imag], axis=-1).reshape(n_frf, 2, n_lines, 4)
    return np.asarray((parts[:, 0] - 1j * parts[:, 1]).swapaxes(1, 2))
