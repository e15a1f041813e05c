"""Variance of averaged spectra under deterministic excitation."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.numerics import COMPARISON_ROUNDING
from modallab.estimation.coherence import coherence
from modallab.estimation.estimators.h1 import h1
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.chain import Chain
from modallab.rig.expected import noise_free, noise_in_lines
from modallab.rig.periodic import PeriodicSignal, periodic_signals
from modallab.rig.wishart_periodic import gain_of


@dataclass(frozen=True, eq=False)
class VarianceFactors:
    """Variances over those of averages of independent Gaussian records, to first order in 1/n."""

    force: FloatArray
    """(n_run, n_freq), with several forces (n_run, n_freq, n_in), variance of ln G_ff."""
    frf: FloatArray
    """(n_run, n_freq, n_out), with several forces (n_run, n_freq, n_out, n_in), variance of H1."""
    response: FloatArray
    """(n_run, n_freq, n_out) variance of ln G_xx (1 - coherence)."""
    # Where distortion comes in bursts: how far off its expectation each of these lies in some tests,
    # (n_tests, ..) logarithms, so that it is known what scatters together.
    tests: tuple[FloatArray, ComplexArray, FloatArray] | None = None


def periodic_factors(chain: Chain, spectra: CrossSpectra) -> VarianceFactors | None:
    """Return the variance factors under deterministic excitation; None if it is random.

    For a deterministic force f with random noise of power N, G_ff is noncentral chi-square with variance
    (2 |f|^2 N + N^2)/n = (1 - a^2) G_ff^2/n, a = |f|^2/G_ff. Likewise for the incoherent power
    C = G_xx (1 - coherence) of a response x: with its deterministic share b = |x - H1 f|^2/C the variance is
    (1 - b^2) C^2/n. The deterministic parts of force and incoherent response are orthogonal on average: the
    variance of H1 is (1 - a b) C/(n G_ff).

    The amplitudes of blows scatter, and G_ff with them: E[w^4] = exp(4 s^2), s the scatter of ln w.
    Misaligned blows contribute to a response with real weights; the square of a real normal number has twice
    the variance of that of a complex one.

    Parameters
    ----------
    spectra
        `expected_spectra(chain)`, one force a run.

    Returns
    -------
    None if all records are independent.
    """
    signals = periodic_signals(chain)
    if signals is None:
        return None
    clean = noise_free(chain)
    noise = noise_in_lines(chain, clean)[:, 0]
    h, force = h1(spectra)[..., 0], spectra.ff[:, :, 0, 0].real
    incoherent = spectra.xx * (1 - coherence(spectra) + COMPARISON_ROUNDING)
    sizes = (
        np.exp(4 * chain.setup.analyser.excitation.level_scatter**2) - 1 if _weights_vary(signals) else 0.0
    )
    shares = [
        _periodic_shares(
            signal, gain_of(spectra, clean[run], noise[run], run), h[run], force[run], incoherent[run]
        )
        for run, signal in enumerate(signals)
    ]
    a, b, varying_share = (np.array(part) for part in zip(*shares, strict=True))
    return VarianceFactors(1 - a**2 + sizes, 1 - a[..., None] * b, 1 - b**2 + varying_share**2)


def _weights_vary(signals: tuple[PeriodicSignal, ...]) -> bool:
    """Return whether the amplitudes of blows differ from record to record."""
    weights = signals[0].weights(2, np.random.default_rng(0))
    return bool((weights[0] != weights[1]).any())


def _periodic_shares(
    signal: PeriodicSignal, gain: ComplexArray, h: ComplexArray, force: FloatArray, incoherent: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the shares of the auto spectra that repeat from period to period.

    Of G_ff, (n_freq,), of the incoherent part of each response, (n_freq, n_out), and the share of the
    latter that is a signal with differing real weights.
    """
    signals = signal.signals * gain
    residuals = signals[..., 1:] - h * signals[..., :1]
    mean = signal.moments[0] / signal.moments[0, 0]  # the first weight is that of the force: a blow's size
    fixed_force = np.abs(np.tensordot(mean, signals[..., 0], axes=1)) ** 2
    fixed_residual = np.abs(np.tensordot(mean, residuals, axes=1)) ** 2
    varying = np.einsum(
        "kl,kfo,lfo->fo", signal.moments - np.outer(mean, mean), residuals.conj(), residuals
    ).real
    return (
        (fixed_force / force).clip(0, 1),
        (fixed_residual / incoherent).clip(0, 1),
        (varying / incoherent).clip(0, 1),
    )
