"""Route a: the spectra that endless averaging would give, window and noise included."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.averaging import effective_averages
from modallab.estimation.spectra import CrossSpectra
from modallab.estimation.windows import WINDOWS
from modallab.rig.chain import Chain
from modallab.rig.smear import Smear
from modallab.rig.view import View, coarse_view, periodic_view, refined_view


def expected_spectra(chain: Chain) -> CrossSpectra:
    """Return the expected averaged spectra of every run.

    What repeats with the record is seen through the window at the lines themselves; what does not
    is the convolution of the true spectra with the window's line shape, 1992 thesis eq. [5.11], here
    by Gauss quadrature on panels refined towards every resonance.
    """
    return _with_noise(chain, noise_free(chain), chain.setup.analyser.freq)


def glimpse(chain: Chain, step: int) -> CrossSpectra:
    """Return the expected spectra at every `step`-th line, leakage on a coarse grid.

    Several times faster than `expected_spectra`, and within some per cent of it at resonances much
    narrower than a line: for a first look over many hypotheses.
    """
    return _with_noise(chain, noise_free(chain, step), chain.setup.analyser.freq[::step])


def noise_free(chain: Chain, step: int | None = None) -> ComplexArray:
    """Return G_ff, G_fx and G_xx as the lines see them, side by side: (n_run, n_lines, 1 + 2 n_out).

    Parameters
    ----------
    step
        None for every line, refined; else every `step`-th line, coarse.
    """
    analyser, share = chain.setup.analyser, chain.source.continuous
    views: list[tuple[float, View | Smear]] = []
    if share < 1:
        views.append((1 - share, periodic_view(analyser, step or 1)))
    if share > 0:
        fine = step is None
        views.append(
            (share, refined_view(analyser, *chain.poles()) if fine else coarse_view(analyser, step or 1))
        )
    parts = [weight * view.through(_signal(chain, view.nodes)) for weight, view in views]
    return np.asarray(sum(parts[1:], parts[0]))


def noise_densities(chain: Chain, clean: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return the flat spectra of the channels' noise, force (n_run, 1) and responses (n_run, n_out).

    Parameters
    ----------
    clean
        `noise_free(chain)`: the log book's ratio is to the mean of each channel's own spectrum.
    """
    n_out = (clean.shape[-1] - 1) // 2
    mean = clean.real.mean(axis=1)
    return chain.noise.force * mean[:, :1], chain.noise.response * mean[:, 1 + n_out :]


def _with_noise(chain: Chain, clean: ComplexArray, freq: FloatArray) -> CrossSpectra:
    noise_f, noise_x = noise_densities(chain, clean)
    n_out = (clean.shape[-1] - 1) // 2
    analyser = chain.setup.analyser
    return CrossSpectra(
        freq,
        (clean[..., :1] + noise_f[:, None, :])[..., None],
        clean[:, :, None, 1 : 1 + n_out],
        clean[..., 1 + n_out :].real + noise_x[:, None, :],
        effective_averages(analyser.averages, chain.overlap, WINDOWS[analyser.window]),
    )


def _signal(chain: Chain, freq: FloatArray) -> ComplexArray:
    """Return the true G_ff, G_fx and G_xx side by side, (n_run, n, 1 + 2 n_out)."""
    excitation = chain.setup.analyser.excitation
    density = excitation.level**2 / chain.setup.analyser.frequency_max
    response = chain.respond(freq)
    force = density * np.abs(response.transmission)[:, :, None] ** 2
    h = response.inertance
    return np.concatenate([force.astype(complex), force * h, force * np.abs(h) ** 2], axis=2)
