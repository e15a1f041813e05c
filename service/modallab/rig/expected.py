"""Route a: the spectra that endless averaging would give, window and noise included."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.averaging import effective_averages
from modallab.estimation.spectra import CrossSpectra
from modallab.estimation.windows import WINDOWS, Window
from modallab.rig.chain import Chain, ChannelResponse
from modallab.rig.setup import Analyser

POINTS = 10  # Gauss points a panel: 1e-8 of a spectrum for panels no longer than `refined` makes them


def expected_spectra(chain: Chain) -> CrossSpectra:
    """Return the expected averaged spectra of every run.

    What repeats with the record is seen through the window at the lines themselves; what does not
    is the convolution of the true spectra with the window's line shape, 1992 thesis eq. [5.11], here
    by Gauss quadrature on panels refined towards every resonance.
    """
    clean = noise_free(chain)
    noise_f, noise_x = noise_densities(chain, clean)
    analyser = chain.setup.analyser
    averages = effective_averages(analyser.averages, analyser.overlap, WINDOWS[analyser.window])
    return CrossSpectra(
        analyser.freq,
        (clean[..., :1] + noise_f[:, None, :])[..., None],
        clean[:, :, None, 1 : 1 + n_out(clean)],
        clean[..., 1 + n_out(clean) :].real + noise_x[:, None, :],
        averages,
    )


def n_out(spectra: ComplexArray) -> int:
    """Return how many responses a run of `noise_free` spectra holds."""
    return (spectra.shape[-1] - 1) // 2


def noise_free(chain: Chain) -> ComplexArray:
    """Return G_ff, G_fx and G_xx seen through the window, side by side: (n_run, n_lines, 1 + 2 n_out)."""
    analyser = chain.setup.analyser
    window, freq = WINDOWS[analyser.window], analyser.freq
    share = chain.source.continuous
    seen = 0j
    if share < 1:
        line = np.arange(len(freq), dtype=float)
        near = window.line_shape(line[:, None] - line)
        mirrored = window.line_shape(line[:, None] + line) * (line > 0)
        seen = (1 - share) * _through(near, mirrored, _signal(chain.respond(freq), analyser))
    if share > 0:
        nodes, weights = refined(analyser, *chain.poles())
        near, mirrored = _kernel(window, analyser, nodes, weights)
        seen = seen + share * _through(near, mirrored, _signal(chain.respond(nodes), analyser))
    return np.asarray(seen)


def noise_densities(chain: Chain, clean: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return the flat spectra of the channels' noise, force (n_run, 1) and responses (n_run, n_out).

    Parameters
    ----------
    clean
        `noise_free(chain)`: the log book's ratio is to the mean of each channel's own spectrum.
    """
    mean = clean.real.mean(axis=1)
    return chain.noise.force * mean[:, :1], chain.noise.response * mean[:, 1 + n_out(clean) :]


def _signal(response: ChannelResponse, analyser: Analyser) -> ComplexArray:
    """Return the true G_ff, G_fx and G_xx side by side, (n_run, n, 1 + 2 n_out)."""
    density = analyser.excitation.level**2 / analyser.frequency_max
    force = density * np.abs(response.transmission)[:, :, None] ** 2
    h = response.inertance
    return np.concatenate([force.astype(complex), force * h, force * np.abs(h) ** 2], axis=2)


def _through(near: FloatArray, mirrored: FloatArray, part: ComplexArray) -> ComplexArray:
    """Return a spectrum (n_run, n_nodes, k) seen through the window, (n_run, n_lines, k).

    The mirrored kernel brings in the negative frequencies, where spectra are conjugate.
    """
    n_run, n_nodes, k = part.shape
    flat = part.swapaxes(0, 1).reshape(n_nodes, n_run * k)
    seen = (near + mirrored) @ flat.real + 1j * ((near - mirrored) @ flat.imag)
    return np.asarray(seen.reshape(len(near), n_run, k).swapaxes(0, 1))


def _kernel(
    window: Window, analyser: Analyser, nodes: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what each line takes from every quadrature node and from its mirror, (n_lines, n_nodes)."""
    lines = np.arange(analyser.n_lines)[:, None]
    place = nodes / analyser.spacing
    share = weights / analyser.spacing
    return window.line_shape(lines - place) * share, window.line_shape(lines + place) * share


def refined(analyser: Analyser, poles: FloatArray, widths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Gauss nodes and weights, (n_nodes,) Hz, from 0 Hz to the top of the band.

    Panels of one line are halved until none is longer than twice its distance from any pole, which
    makes the error of a panel fall by 2.4^-20 or more with ten points (Bernstein ellipse).

    Parameters
    ----------
    poles, widths
        Frequencies and half bandwidths, Hz, of any shape.
    """
    flat, half = poles.ravel(), np.maximum(widths.ravel(), 1e-6 * analyser.spacing)
    inside = (flat > -analyser.spacing) & (flat < analyser.frequency_max + analyser.spacing)
    flat, half = flat[inside], half[inside]
    edges = analyser.freq
    left, right = edges[:-1], edges[1:]
    done: list[FloatArray] = []
    while len(left):
        centre, radius = (left + right) / 2, (right - left) / 2
        gap = np.maximum(np.abs(centre[:, None] - flat) - radius[:, None], 0.0)
        near = np.sqrt(gap**2 + half**2).min(axis=1, initial=np.inf)
        fine = radius <= near
        done.append(np.stack([left[fine], right[fine]]))
        left, centre, right = left[~fine], centre[~fine], right[~fine]
        left, right = np.concatenate([left, centre]), np.concatenate([centre, right])
    panels = np.concatenate(done, axis=1)
    x, w = np.polynomial.legendre.leggauss(POINTS)
    centre, radius = panels.mean(axis=0)[:, None], (panels[1] - panels[0])[:, None] / 2
    return (centre + radius * x).ravel(), (radius * w).ravel()
