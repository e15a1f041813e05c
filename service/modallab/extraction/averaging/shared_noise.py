"""How much of their random error the FRFs have in common."""

import numpy as np

from modallab.core.arrays import IntArray
from modallab.extraction.single_mode.damping_models import DampingModel
from modallab.extraction.single_mode.fitting import ConvergedFits, FitData
from modallab.extraction.single_mode.settings import SINGLE_MODE_FIT

FEW = 20  # pairs of lines: fewer do not tell a correlation


def shared_noise_fraction(law: DampingModel, data: FitData, settled: ConvergedFits, index: IntArray) -> float:
    """Return the correlation of the errors of different FRFs near resonances, 0 to 1.

    Responses recorded together are all divided by one force, and what is wrong with its record moves a mode
    by as much in each of them: the mean over n FRFs is then not surer by the root of n. Errors are
    what the fits leave of their lines, over the mode's own response: a force recorded wrongly by a part
    changes all FRFs by the same part. Runs that follow one another have none of it.

    Parameters
    ----------
    law
        Of the damping.
    data, settled
        Lines of every fit, and how it ended.
    index
        (n_modes, n_frf, n_lines) which line of the axis each is: FRFs have windows of their own.
    """
    table = settled.table
    own = (2 * np.pi * table.frequency) ** 2 * (1 + 1j * table.loss_factor)
    good = table.screening.good & (own.real > 0)
    mode = law.response(
        data.freq,
        np.where(good, own, 1 + 1j)[:, :, None],
        np.where(good, table.modal_constant, 1.0)[:, :, None],
    )
    factor = np.where(
        settled.inertance[:, None, None], np.maximum(data.x, SINGLE_MODE_FIT.smallest_eigenvalue), 1.0
    )
    weight = np.where(good[:, :, None], data.weight / factor**2, 0.0)
    left = factor * (settled.cleaned - mode)
    total = weight.sum(axis=2, keepdims=True)
    left = left - (weight * left).sum(axis=2, keepdims=True) / np.where(total > 0, total, 1.0)
    size = np.abs(mode)
    error = np.sqrt(weight) * left * mode.conj() / np.where(size > 0, size, 1.0)
    together, apart, count = 0.0, 0.0, 0.0
    for one, used, line in zip(error, weight > 0, index, strict=True):
        row, column = np.nonzero(used)
        if not len(row):
            continue
        here = line[row, column] - line.min()
        dense = np.zeros((len(used), here.max() + 1), complex)
        there = np.zeros(dense.shape)
        dense[row, here], there[row, here] = one[row, column], 1.0
        power = (np.abs(dense) ** 2) @ there.T  # of each FRF at the lines that another has too
        pairs = ~np.eye(len(used), dtype=bool)
        together += float((dense @ dense.conj().T).real[pairs].sum())
        apart += float(np.sqrt(power * power.T)[pairs].sum())
        count += float((there @ there.T)[pairs].sum()) / 2
    return float(np.clip(together / apart, 0.0, 1.0)) if apart > 0 and count >= FEW else 0.0
