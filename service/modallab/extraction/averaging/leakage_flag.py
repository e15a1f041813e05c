"""What leakage may still bias a mode by, and what is said of it."""

from collections.abc import Iterator, Mapping

from modallab.extraction.single_mode.fitting import FitTable


def leakage_bias_of(table: FitTable, m: int) -> dict[str, float]:
    """Return by what leakage may still move the mean over the FRFs: frequency, Hz, and loss factor.

    Parameters
    ----------
    table
        Fits; those that count more in the mean do so here.
    m
        Row of the mode.

    Returns
    -------
    dict
        Empty where nothing leaks.
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
    """Yield by how much leakage may still bias a mode, where that is more than the random error.

    Parameters
    ----------
    bias, standard_errors
        Of "frequency", Hz, and "loss_factor"; no bias where nothing leaks.
    loss_factor
        Of the mode.
    """
    if any(bias[name] > standard_errors[name] for name in bias):
        off, share = bias["frequency"], 100 * bias["loss_factor"] / loss_factor
        yield f"leakage_bias: up to {off:.2g} Hz in frequency and {share:.2g} % of the loss factor"
