"""Expected spectra: the limit of endless averaging, window and noise included (route `expected`)."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.estimation.averaging import effective_averages
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.acquisition import Acquisition
from modallab.rig.chain import Chain
from modallab.rig.channel_response import ChannelResponse
from modallab.rig.distortion import ResidualSpectra, residual_spectra
from modallab.rig.effect import Effect
from modallab.rig.equivalent_linear_feedback import with_equivalent_feedback
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.free_decay import decayed_lines, products, transient_of, transient_spectra
from modallab.rig.leakage_kernel import LeakageKernel
from modallab.rig.line_kernels import LineKernel, coarse_kernel, periodic_kernel, refined_kernel
from modallab.rig.line_selection import LineSelection
from modallab.rig.nonlinear_settings import DISTORTION
from modallab.rig.periodic import fixed_signals
from modallab.rig.spectrum_settings import LEAKAGE_KERNEL, QUADRATURE


def expected_spectra(
    chain: Chain,
    kernel: LeakageKernel | None = None,
    lines: IntArray | None = None,
    distortion: ResidualSpectra | None = None,
) -> CrossSpectra:
    """Return the expected averaged spectra of every run.

    Power that repeats with the record lies on the lines, and the window combines neighbouring lines. Other
    power is the convolution of the true spectra with the window's line shape, 1992 thesis eq. [5.11], by
    Gauss quadrature on panels that are refined towards every resonance.

    Parameters
    ----------
    kernel
        Leakage kernel in place of the chain's own; for finite differences between almost identical chains
        the `derivative_kernel` of one of them.
    lines
        (n,) indices from 0 Hz on of the lines needed, rising; None: all.
    distortion
        Spectra of the residual forces at the kernel's nodes; None: those of the chain's own motion.
    """
    if lines is None or len(lines) == chain.setup.analyser.n_lines:
        return with_noise(chain, noise_free(chain, kernel=kernel, distortion=distortion))
    if chain.source.continuous > 0 or _needs_whole_band(chain):
        return expected_spectra(chain, kernel, distortion=distortion).at(lines)
    selection = LineSelection(lines)
    return _with_noise(chain, noise_free(chain, selection), selection.of(chain.setup.analyser.freq))


def _needs_whole_band(chain: Chain) -> bool:
    """Return whether lines depend on all others: by noise in proportion to a signal, or by an effect."""
    levels = [chain.noise.response, *(chain.noise.of_gauge(dof) for dof in chain.setup.drives)]
    return any(level > 0 for level in levels) or any(
        type(effect).on_spectra is not Effect.on_spectra for effect in chain.effects
    )


def derivative_kernel(chain: Chain) -> LeakageKernel | None:
    """Return the leakage kernel for numerical derivatives; None if all power repeats with the record."""
    if not chain.source.continuous > 0:
        return None
    points = QUADRATURE.derivative_points, LEAKAGE_KERNEL.derivative_points
    return refined_kernel(chain.setup.analyser, *chain.poles(), *points)


def coarse_spectra(
    chain: Chain, step: int, lines: IntArray | None = None, *, noise_of_all_lines: bool = False
) -> CrossSpectra:
    """Return the expected spectra at every `step`-th line, leakage on a coarse grid.

    Several times faster than `expected_spectra`, and within some per cent of it at resonances much
    narrower than a line: for a first look over many hypotheses.

    Parameters
    ----------
    step
        Lines from one line to the next, from 0 Hz on.
    lines
        (n,) indices from 0 Hz on of those of these lines that are needed; None: all.
    noise_of_all_lines
        Whether ratios of noise relate to the means of all lines in any case; else only where the force is
        narrow.
    """
    freq = chain.setup.analyser.freq
    selection = LineSelection.every(step, len(freq))
    some = lines is not None and len(lines) < len(selection)
    if lines is not None and some and not _needs_whole_band(chain):
        selection, some = LineSelection(lines), False
    # Every line of a steady signal costs no more exactly; a free decay does.
    screened = step > 1 or transient_of(chain) is not None
    clean = noise_free(chain, selection, coarse=screened)
    all_lines = None
    if screened and (noise_of_all_lines or narrow_in_force(chain)):
        all_lines = noise_free(chain, LineSelection.every(1, len(freq)), coarse=True)
    spectra = _with_noise(chain, clean, selection.of(freq), all_lines)
    return spectra.at(lines // step) if lines is not None and some else spectra


def narrow_in_force(chain: Chain) -> bool:
    """Return whether an armature resonates on its stinger: a few lines may have most of the force's power."""
    return any(drive.compliance > 0 and drive.mass > 0 for run in chain.runs for drive in run.drives)


def noise_free(
    chain: Chain,
    lines: LineSelection | None = None,
    kernel: LeakageKernel | None = None,
    *,
    coarse: bool = False,
    distortion: ResidualSpectra | None = None,
) -> ComplexArray:
    """Return G_ff, G_fx and G_xx without noise, concatenated, as seen through the window.

    Parameters
    ----------
    lines
        Lines needed; None: all. Some of them only where no power leaks, or coarse.
    kernel
        In place of the one that the chain's resonances ask for.
    coarse
        Whether leakage is that of a coarse grid, and a decay is followed less far.
    distortion
        As in `expected_spectra`.

    Returns
    -------
    (n_run, n_lines, n_in^2 + n_in n_out + n_out)
    """
    analyser, share = chain.setup.analyser, chain.source.continuous
    parts: list[ComplexArray] = []
    if share < 1:
        parts.append((1 - share) * _periodic_spectra(chain, lines, coarse=coarse))
    if share > 0:
        if lines is not None:
            view = coarse_kernel(analyser, lines)
            parts.append(share * _leaked_spectra(view, chain, QUADRATURE.coarse_points))
        else:
            view_of_all = kernel or refined_kernel(analyser, *chain.poles())
            parts.append(share * _leaked_spectra(view_of_all, chain, distortion=distortion))
    return np.asarray(sum(parts[1:], parts[0]))


def _periodic_spectra(chain: Chain, lines: LineSelection | None, *, coarse: bool) -> ComplexArray:
    """Return the spectra of the power that repeats with the record, at full level."""
    indices = slice(None) if lines is None else lines.indices
    if transient_of(chain) is not None:
        decayed = decayed_lines(chain, indices) if coarse else None
        if decayed is not None:
            return products(decayed) + _residual_part(chain, lines)
        return transient_spectra(chain)[:, indices] + _residual_part(chain, lines)
    signals = fixed_signals(chain)
    if signals is not None:
        return products(signals[:, indices]) + _residual_part(chain, lines)
    return _leaked_spectra(periodic_kernel(chain.setup.analyser, lines), chain)


def _residual_part(chain: Chain, lines: LineSelection | None) -> ComplexArray | float:
    """Return the spectra of the residual forces, for a Gaussian signal of the same power."""
    if not chain.runs[0].local_forces:
        return 0.0
    view = periodic_kernel(chain.setup.analyser, lines)
    residual = residual_spectra(chain.runs, chain.setup.analyser, chain.source, view.nodes)
    return view.convolve(_powers(chain.residual_response(view.nodes), residual.density))


def _leaked_spectra(
    view: LineKernel | LeakageKernel,
    chain: Chain,
    finest: int = DISTORTION.max_points_per_line,
    distortion: ResidualSpectra | None = None,
) -> ComplexArray:
    analyser = chain.setup.analyser
    density = np.repeat(analyser.source_density(view.nodes)[None, :, None], chain.n_in, axis=2)
    driven, distorted = chain.source_and_residual_response(view.nodes)
    if not chain.runs[0].local_forces:
        return view.convolve(_powers(driven, density))
    residual = distortion or residual_spectra(chain.runs, analyser, chain.source, view.nodes, finest)
    driven, distorted = with_equivalent_feedback(driven, distorted, residual.feedback)
    return view.convolve(_powers(driven, density) + _powers(distorted, residual.density))


def acquisition(chain: Chain, clean: ComplexArray) -> Acquisition:
    """Return signal and noise levels of all channels.

    Parameters
    ----------
    clean
        `noise_free(chain)`.
    """
    band = chain.setup.analyser.frequency_max
    return Acquisition(
        chain.setup.analyser,
        chain.n_in,
        np.sqrt(band * _autos(chain, clean).mean(axis=1)),
        noise_densities(chain, clean),
        tuple((*run.forces, *run.responses) for run in chain.runs),
    )


def noise_densities(chain: Chain, clean: ComplexArray) -> FloatArray:
    """Return the flat spectra of the channels' noise, (n_run, n_ch), forces first.

    Parameters
    ----------
    clean
        `noise_free(chain)`: the log book's ratio is to the mean of each channel's own spectrum, of a test
        with the signal's power spread over the band.
    """
    n_ch = len(chain.runs[0].forces) + len(chain.runs[0].responses)
    levels = np.full((len(chain.runs), n_ch), chain.noise.response)
    levels[:, : chain.n_in] = [
        [chain.noise.of_gauge(d) for d in run.acquisition_run.drives] for run in chain.runs
    ]
    analyser = chain.setup.analyser
    levels *= EXCITATIONS[analyser.excitation.kind].noise_share(analyser.n_lines)
    densities = [
        chain.setup.noise.densities(run.acquisition_run.drives, run.acquisition_run.outputs)
        for run in chain.runs
    ]
    return np.asarray(levels * _autos(chain, clean).mean(axis=1) + densities)


def noise_in_lines(chain: Chain, clean: ComplexArray) -> FloatArray:
    """Return what noise adds to the auto spectra of the channels at every line, (n_run, n_ch), forces first.

    Parameters
    ----------
    clean
        `noise_free(chain)` at the lines that represent the mean of the band.
    """
    shares = chain.setup.analyser.line_window.noise_shares(chain.n_in, len(chain.runs[0].responses))
    return noise_densities(chain, clean) * shares


def _autos(chain: Chain, clean: ComplexArray) -> FloatArray:
    """Return the auto spectra of all channels, (n_run, n_lines, n_ch), forces first."""
    n = chain.n_in
    n_out = len(chain.runs[0].responses)
    return np.concatenate([clean[..., : n * n : n + 1].real, clean[..., -n_out:].real], axis=2)


def with_noise(chain: Chain, clean: ComplexArray) -> CrossSpectra:
    """Return the expected averaged spectra of every run from `noise_free(chain)`."""
    return _with_noise(chain, clean, chain.setup.analyser.freq)


def _with_noise(
    chain: Chain, clean: ComplexArray, freq: FloatArray, all_lines: ComplexArray | None = None
) -> CrossSpectra:
    """Return the expected averaged spectra at some lines.

    Parameters
    ----------
    clean
        `noise_free(chain)` at these lines.
    all_lines
        The same at the lines that represent the mean of the band; None: `clean`.
    """
    all_lines = clean if all_lines is None else all_lines
    n, n_out = chain.n_in, len(chain.runs[0].responses)
    n_run, n_lines, _ = clean.shape
    noise = noise_in_lines(chain, all_lines)
    ff = clean[..., : n * n].reshape(n_run, n_lines, n, n).copy()
    ff[..., np.arange(n), np.arange(n)] += noise[:, None, :n]
    analyser = chain.setup.analyser
    spectra = CrossSpectra(
        freq,
        ff,
        clean[..., n * n : -n_out].reshape(n_run, n_lines, n, n_out),
        clean[..., -n_out:].real + noise[:, None, n:],
        effective_averages(analyser.simulated_averages, chain.overlap, analyser.line_window),
    )
    acquisition_state = acquisition(chain, all_lines)
    for effect in chain.effects:
        spectra = effect.on_spectra(spectra, acquisition_state)
    return spectra


def _powers(answer: ChannelResponse, density: FloatArray) -> ComplexArray:
    """Return G_ff, G_fx and G_xx side by side of sources that have nothing in common.

    Parameters
    ----------
    answer
        Of the channels per newton of each source.
    density
        (n_run, n, n_sources) N^2/Hz, or what broadcasts to it.
    """
    f, x = answer.force, answer.response
    n_in, n_sources = f.shape[2:]
    if n_in == n_sources == 1:  # products number by number instead of matrix by matrix
        f, x = f[..., 0], x[..., 0]
        force, power = (density * (spectrum.real**2 + spectrum.imag**2) for spectrum in (f, x))
        return np.concatenate([force.astype(complex), density * f.conj() * x, power], axis=2)
    weighted_force = density[:, :, None, :] * f.conj()
    parts = [weighted_force @ f.swapaxes(2, 3), weighted_force @ x.swapaxes(2, 3)]
    flat = [part.reshape(*part.shape[:2], -1) for part in parts]
    return np.concatenate([*flat, (density[:, :, None, :] * np.abs(x) ** 2).sum(axis=3)], axis=2)
