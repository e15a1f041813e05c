"""Mode indicator function and complex mode indicator function of a set of FRFs."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.frf import FrfKind, FrfSet


def real_part_indicator(frf: FrfSet) -> FloatArray:
    """Return the mode indicator function (MIF), (n_freq, n_in): 0 at resonances, near 1 between them.

    `sum_j |Re H_j| |H_j| / sum_j |H_j|^2` over the responses to each force. At a resonance of a real mode,
    receptance and inertance are imaginary in all FRFs; mobility is real, so that its imaginary part replaces
    the real part. Large and small modes are minima of similar depth if they exceed the contributions of the
    other modes. Close modes share a minimum unless forces at different points separate them. Lines without
    any response have the value 1.

    Parameters
    ----------
    frf
        Of any kind.

    References
    ----------
    Breitbach, E. (1973), A semi-automatic modal survey test technique for complex aircraft and spacecraft
    structures, Proc. 3rd ESRO Testing Symposium, 519-528.
    """
    values, size = _scaled(frf.values)
    part = np.abs(values.imag if frf.kind is FrfKind.MOBILITY else values.real)
    power = (size**2).sum(axis=1)
    return np.asarray(np.where(power > 0, (part * size).sum(axis=1) / np.where(power > 0, power, 1.0), 1.0))


def complex_mode_indicator(frf: FrfSet) -> FloatArray:
    """Return the complex mode indicator function (CMIF), (n_freq, min(n_out, n_in)), unit of the FRFs.

    It consists of the singular values of the FRF matrix of each line, in descending order. Peaks of the first
    are modes; two modes at one frequency are peaks of the first and the second. With one force or one
    response it is the root of the summed power.

    Parameters
    ----------
    frf
        Of any kind; mobility gives low and high modes similar heights.

    References
    ----------
    Shih, C. Y., Tsuei, Y. G., Allemang, R. J. and Brown, D. L. (1988), Complex mode indication function and
    its applications to spatial domain parameter estimation, Mech. Syst. Signal Process. 2(4), 367-377.
    """
    return np.asarray(np.linalg.svd(frf.values, compute_uv=False))


def _scaled(values: ComplexArray) -> tuple[ComplexArray, FloatArray]:
    """Return the values normalised by the largest modulus of each line and force, and their moduli."""
    largest = np.abs(values).max(axis=1, keepdims=True)
    scaled = values / np.where(largest > 0, largest, 1.0)
    return scaled, np.asarray(np.abs(scaled))
