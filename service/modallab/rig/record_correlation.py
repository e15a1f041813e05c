"""Correlation of successive records by leakage, and the excess variance that it causes."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.estimation.coherence import coherence
from modallab.estimation.estimators.h1 import h1
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.chain import Chain
from modallab.rig.line_kernels import refined_kernel
from modallab.rig.spectrum_settings import RECORD_CORRELATION


def correlated_excess_variance(chain: Chain, spectra: CrossSpectra) -> FloatArray:
    """Return the variance of G_xx (1 - coherence) over that of averages of independent records.

    The residual of a line, response minus H1 times force, is correlated with that of the next records: with a
    rectangular window a record ends where the next begins. With c_l its covariance at a lag of l records,
    the variance of its mean square is that of independent records times 1 + 2 sum_l (1 - l/n) |c_l / c_0|^2.
    This is divided by the same factor of white signals, which the effective number of averages contains
    already. For one mode, a rectangular window and no noise that is
    1 + |1 - rho|^4 / (2 (1 - Re rho)^2 (1 - |rho|^2)), rho = exp(-pi eta f T + 2 pi i f T).

    Neglected: the correlation of a line with its mirror at -f. With a rectangular window it adds
    up to as much again on the first lines below the first mode, and little anywhere else.

    Parameters
    ----------
    spectra
        `expected_spectra(chain)`.

    Returns
    -------
    Factors (n_run, n_freq, n_out); 1 where nothing leaks.
    """
    analyser, n = chain.setup.analyser, chain.setup.analyser.simulated_averages
    incoherent = spectra.xx * (1 - coherence(spectra) + COMPARISON_ROUNDING)
    if chain.source.continuous == 0:
        return np.ones_like(incoherent)
    lags = np.arange(1, int(np.ceil(RECORD_CORRELATION.n_records / (1 - chain.overlap))) + 1)
    hop = (1 - chain.overlap) * analyser.record_length
    leaked = np.array(list(leaked_covariances(chain, spectra, len(lags))))
    # The other part is independent at every instant: records share it as far as they overlap.
    window_overlap = _overlapping(
        analyser.line_window.samples(RECORD_CORRELATION.window_samples), hop / analyser.record_length * lags
    )
    overlap_correlation = window_overlap[:, None] * np.exp(2j * np.pi * analyser.freq * lags[:, None] * hop)
    covariance = leaked[1:] + overlap_correlation[:, None, :, None] * (incoherent - leaked[0].real)
    ratio = np.abs(covariance / incoherent) ** 2
    # Farther ahead each mode's part falls geometrically, none more slowly than the least damped one's.
    slowest = np.exp(-4 * np.pi * hop * _least_width(chain))
    decay_ratio = np.sqrt(ratio[-1] / np.maximum(ratio[-3], np.finfo(float).tiny)).clip(0.0, slowest)
    lag_weights = np.maximum(1 - lags / n, 0.0)
    total = np.tensordot(lag_weights, ratio, axes=1) + lag_weights[-1] * ratio[-1] * decay_ratio / (
        1 - decay_ratio
    )
    return np.asarray((1 + 2 * total) / (1 + 2 * lag_weights @ window_overlap**2))


def leaked_covariances(chain: Chain, spectra: CrossSpectra, lags: int) -> Iterator[ComplexArray]:
    """Yield the covariance (n_run, n_freq, n_out) of the leaked part at lags of 0, 1, ... `lags` records.

    The integral of the window's line shape times |X - H1 F|^2 exp(2 pi i f l hop), hop the time from one
    record to the next, over the true spectra of what is stationary; at lag 0 what H1 leaves of its power.
    """
    analyser = chain.setup.analyser
    view = refined_kernel(analyser, *chain.poles())
    answer = chain.respond(view.nodes)
    f, x = answer.force, answer.response
    density = chain.source.continuous * analyser.source_density(view.nodes)[:, None, None]
    weighted_force = density * f.conj()
    ff, fx = weighted_force @ f.swapaxes(2, 3), weighted_force @ x.swapaxes(2, 3)
    xx = density[..., 0] * (np.abs(x) ** 2).sum(axis=3)
    n_run, n_nodes, n_in, n_out = fx.shape
    flat = [part.reshape(n_run, n_nodes, -1) for part in (ff, fx, fx.conj(), xx.astype(complex))]
    true_spectra = np.concatenate(flat, axis=2)
    edges = np.cumsum([part.shape[2] for part in flat])[:-1]
    h = h1(spectra)
    hop = (1 - chain.overlap) * analyser.record_length
    for lag in range(lags + 1):
        lag_phase = np.exp(2j * np.pi * lag * hop * view.nodes)
        line_spectra = view.convolve(true_spectra * lag_phase[:, None])
        ff, fx, xf, xx = np.split(line_spectra, edges, axis=2)
        cross = (part.reshape(*h.shape[:2], n_in, n_out) for part in (fx, xf))
        explained = sum(np.einsum("rloi,rlio->rlo", a, b) for a, b in zip((h.conj(), h), cross, strict=True))
        explained_power = np.einsum("rloi,rlij,rloj->rlo", h.conj(), ff.reshape(*h.shape[:2], n_in, n_in), h)
        yield np.asarray(xx - explained + explained_power)


def _least_width(chain: Chain) -> float:
    """Return half the half-power bandwidth, Hz, of the sharpest resonance within the band."""
    frequencies, widths = chain.poles()
    inside = frequencies < chain.setup.analyser.frequency_max
    return max(
        float(widths[inside].min(initial=np.inf)),
        RECORD_CORRELATION.min_half_width * chain.setup.analyser.spacing,
    )


def _overlapping(window: FloatArray, shifts: NDArray[np.floating[Any]]) -> FloatArray:
    """Return the autocorrelation of a window at `shifts` records."""
    n, power = len(window), float(window @ window)
    steps = np.round(shifts * n).astype(int)
    return np.array([float(window[s:] @ window[: n - s]) / power if s < n else 0.0 for s in steps])
