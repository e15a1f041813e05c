"""What is said of a mode that leakage may still bias."""

from collections.abc import Iterator

from modallab.extraction.collating.means import Mean
from modallab.extraction.singly.fitting import Table


def leakage_flags(table: Table, m: int, frequency: Mean, loss_factor: Mean) -> Iterator[str]:
    """Yield by how much leakage may still bias a mode, where that is more than the random error.

    Parameters
    ----------
    table
        Fits; those that count more in the mean do so here.
    m
        Row of the mode.
    frequency, loss_factor
        The means with their standard errors.
    """
    if table.leakage_bias is None:
        return
    good = table.screening.good[m]
    error = table.loss_factor_error[m][good]
    weight = (error.min() / error) ** 2
    bias = (weight[:, None] * table.leakage_bias[m][good]).sum(axis=0) / weight.sum()
    if bias[0] > frequency.error or bias[1] > loss_factor.error:
        share = 100 * bias[1] / loss_factor.value
        yield f"leakage_bias: up to {bias[0]:.2g} Hz in frequency and {share:.2g} % of the loss factor"
