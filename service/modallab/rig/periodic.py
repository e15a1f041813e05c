"""Deterministic signals: the part that all averages have in common."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy.fft

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.rig.acquisition import sample_rate_of
from modallab.rig.analyser import Analyser
from modallab.rig.chain import Chain
from modallab.rig.excitation import EXCITATIONS, Transient
from modallab.rig.free_decay import all_impulse_responses, blow_lines, transient_of
from modallab.rig.impulse_responses import ImpulseResponses

Weights = Callable[[int, np.random.Generator], FloatArray]  # number of averages -> (n, k)


@dataclass(frozen=True, eq=False)
class PeriodicSignal:
    """Deterministic signals of one run: in every average a weighted sum of the same few.

    One of weight 1 where every record is the same; blows of a hammer differ in size, place and angle.
    """

    signals: ComplexArray
    """(k, n_lines, n_ch) spectra of all channels, forces first, square roots of one-sided densities."""
    moments: FloatArray
    """(k, k) mean products of the weights."""
    weights: Weights

    def expected(self, gain: ComplexArray) -> ComplexArray:
        """Return the mean G_ff, G_fx and G_xx behind channel gains, concatenated, (n_lines, 1 + 2 n_out)."""
        spectra = self.signals * gain
        weighted_force = np.einsum("kl,kf->lf", self.moments, spectra[..., 0].conj())
        first = np.einsum("lf,lfc->fc", weighted_force, spectra)
        return np.concatenate(
            [first, np.einsum("kl,kfc,lfc->fc", self.moments, spectra[..., 1:].conj(), spectra[..., 1:])],
            axis=1,
        )


def fixed_lines(analyser: Analyser) -> ComplexArray | None:
    """Return the fixed source lines of unit density; None if the signal is random."""
    phases = EXCITATIONS[analyser.excitation.kind].phases
    return None if phases is None else np.exp(1j * phases(analyser.n_lines))


def periodic_signals(chain: Chain) -> tuple[PeriodicSignal, ...] | None:
    """Return the deterministic signals of each run; None if the excitation is random."""
    transient = transient_of(chain)
    if transient is None:
        signals, share = fixed_signals(chain), np.sqrt(1 - chain.source.continuous)
        return (
            None
            if signals is None
            else tuple(PeriodicSignal(share * run[None], np.eye(1), _unit_weights) for run in signals)
        )
    if (lines := blow_lines(chain)) is not None:
        share, setting = np.sqrt(1 - chain.source.continuous), chain.setup.analyser.excitation
        weights = partial(transient.weights, 1, setting)
        return tuple(
            PeriodicSignal(share * run[None], transient.moments(1, setting), weights) for run in lines
        )
    runs = [_transient_signal(chain, transient, answers) for answers in all_impulse_responses(chain)]
    return None if None in runs else tuple(run for run in runs if run is not None)


def _transient_signal(chain: Chain, transient: Transient, answers: ImpulseResponses) -> PeriodicSignal | None:
    """Return the transient signals of a run; None if they are Gaussian."""
    analyser, setting = chain.setup.analyser, chain.setup.analyser.excitation
    records = transient.basis_records(answers, setting)
    if records is None:
        return None
    n_ch, n = records.shape[1:]
    window = analyser.line_window
    density = 2 * (1 - chain.source.continuous) / (sample_rate_of(analyser) * n * window.power)
    windowed = np.sqrt(density) * records * window.weights(n, chain.n_in, n_ch - chain.n_in)
    lines = scipy.fft.rfft(windowed)[..., : analyser.n_lines]
    return PeriodicSignal(
        lines.swapaxes(1, 2),
        transient.moments(len(answers.samples), setting),
        partial(transient.weights, len(answers.samples), setting),
    )


def fixed_signals(chain: Chain) -> ComplexArray | None:
    """Return the windowed lines of a fixed signal, (n_run, n_lines, n_ch); None if it is random."""
    analyser = chain.setup.analyser
    lines = fixed_lines(analyser)
    if lines is None:
        return None
    density = analyser.source_density(analyser.freq)[:, None]
    channel_lines = chain.respond(analyser.freq).channels.sum(axis=3)
    return analyser.line_window.lines(np.sqrt(density) * channel_lines * lines[:, None])


def _unit_weights(n: int, _rng: np.random.Generator) -> FloatArray:
    return np.ones((n, 1))
