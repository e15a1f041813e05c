"""Remaining bias by leakage of the means over FRFs, and its flag."""

from collections.abc import Iterator, Mapping

from modallab.extraction.single_mode.fit_table import FitTable


def leakage_bias_of(table: FitTable, m: int) -> dict[str, float]:
    """Return the remaining bias by leakage of the mean over the FRFs: frequency, Hz, and loss factor.

    Parameters
    ----------
    table
        Fits, weighted as in the mean.
    m
        Row of the mode.

    Returns
    -------
    dict
        Empty without leakage.
    """
    if table.leakage_bias is None:
        return {}
    good = table.screening.good[m]
    error = table.loss_factor_error[m][good]
    weight = (error.min() / error) ** 2
    bias = (weight[:, None] * table.leakage_bias[m][good]).sum(axis=0) / weight.sum()
    return {"frequency": float(bias[0]), "loss_factor": float(bias[1])}


def leakage_flags(
    bias: Mapping[str, float], standard_errors: Mapping[str, float], loss_factor: float
) -> Iterator[str]:
    """Yield a flag where the bias by leakage may exceed the random error.

    Parameters
    ----------
    bias, standard_errors
        Of "frequency", Hz, and "loss_factor"; bias is empty without leakage.
    loss_factor
        Of the mode.
    """
    if any(bias[name] > standard_errors[name] for name in bias):
        off, share = bias["frequency"], 100 * bias["loss_factor"] / loss_factor
        yield f"leakage_bias: up to {off:.2g} Hz in frequency and {share:.2g} % of the loss factor"
