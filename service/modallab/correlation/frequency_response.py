"""Assurance criteria of frequency response functions: FRAC by FRF and FDAC by line."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.correlation.mac import mac
from modallab.correlation.settings import RESPONSES


def frac(measured: ComplexArray, model: ComplexArray) -> FloatArray:
    """Return the frequency response assurance criterion of every FRF, (n_out, n_in), 0 to 1.

    `|sum H_x^* H_a|^2 / (sum |H_x|^2 sum |H_a|^2)` over the lines: 1 if two FRFs differ by no more than a
    complex factor. A resonance that has moved by more than its width brings it near 0: a test of frequencies
    rather than of shapes. An FRF of zeros is like nothing: 0.

    Parameters
    ----------
    measured, model
        (n_freq, n_out, n_in) at the same lines, of the same kind.

    References
    ----------
    Heylen, W. and Lammens, S. (1996), Proc. International Conference on Identification in Engineering
    Systems, Swansea, 48-57.
    """
    product = np.abs((measured.conj() * model).sum(axis=0)) ** 2
    sizes = (np.abs(measured) ** 2).sum(axis=0) * (np.abs(model) ** 2).sum(axis=0)
    values = np.divide(product, sizes, out=np.zeros(sizes.shape), where=sizes > 0)
    return np.asarray(np.minimum(values, 1.0))


def fdac(measured: ComplexArray, model: ComplexArray) -> FloatArray:
    """Return the frequency domain assurance criterion, (n_in, n_measured_lines, n_model_lines), 0 to 1.

    For each input the MAC of the deflection at every measured line with that at every line of the model.
    High values run along a ridge, at equal frequencies if nothing differs; where the model is too stiff
    or too soft throughout by a factor, the ridge is f_measured / f_model = sqrt of that factor.

    Parameters
    ----------
    measured, model
        (n_measured_lines, n_out, n_in) and (n_model_lines, n_out, n_in), any kind.

    References
    ----------
    Pascual, R., Golinval, J. C. and Razeto, M. (1997), Proc. 15th International Modal Analysis
    Conference, 587-592.
    """
    inputs = range(measured.shape[2])
    return np.stack([mac(measured[:, :, i].T, model[:, :, i].T) for i in inputs])


def ridge(values: FloatArray, step: float) -> tuple[float | None, float | None, float]:
    """Return the frequency scale of an FDAC's ridge, the mean FDAC along it, and that at scale 1.

    The ridge is the line f_measured = scale f_model with the highest mean; scale and mean are None if the
    maximum is at an end of the range of scales.

    Parameters
    ----------
    values
        (n_in, n, n): FDAC at frequencies that rise by a constant factor.
    step
        Logarithm of that factor.
    """
    n = values.shape[1]
    plane = values.mean(axis=0)
    furthest = min(
        int(np.log(RESPONSES.max_frequency_scale) / step), int((1 - RESPONSES.min_common_lines) * n)
    )
    offsets = np.arange(-furthest, furthest + 1)
    # measured line i stands beside model line i - offset
    means = np.array([plane.diagonal(-offset).mean() for offset in offsets])
    best = int(means.argmax())
    unscaled = float(means[furthest])
    if best in (0, len(offsets) - 1):
        return None, None, unscaled
    lower, peak, upper = means[best - 1 : best + 2]
    bend = lower - 2 * peak + upper
    # the peak of the parabola through three means, a fraction of a step away
    place = offsets[best] + ((lower - upper) / (2 * bend) if bend < 0 else 0.0)
    return float(np.exp(place * step)), float(means[best]), unscaled
