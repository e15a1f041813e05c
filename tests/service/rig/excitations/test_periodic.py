"""Signals that repeat with the record, line by line: exact FRFs, and what windows and noise do to them."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.core.progress import silent
from modallab.estimation.coherence import coherence, frf_error
from modallab.estimation.estimator import ESTIMATORS
from modallab.fe.damping import StructuralDamping
from modallab.fe.receptance import direct_receptance
from modallab.rig.chain import Chain, chain
from modallab.rig.compatibility import check_compatible
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Noise
from modallab.rig.measure import draw
from modallab.rig.sampled import sampled_spectra
from tests.rigs import beam_system, dofs, rig

FIXED = ("chirp", "pseudo_random", "stepped_sine")
LIGHT = StructuralDamping(stiffness_coefficient=1e-4)  # half-power bandwidths from 0.001 lines


def inertance(bench: Chain) -> ComplexArray:
    """By solving at every line."""
    freq, acquisition_run, system = (
        bench.setup.analyser.freq[1:],
        bench.runs[0].acquisition_run,
        bench.runs[0].system,
    )
    columns = system.selection(acquisition_run.outputs), system.selection(acquisition_run.drives)
    return -((2 * np.pi * freq) ** 2)[:, None] * direct_receptance(system, freq, *columns)[..., 0]


def record(kind: str, n_lines: int = 401) -> FloatArray:
    """What the source plays in time, of unit mean square."""
    phases = EXCITATIONS[kind].phases
    assert phases is not None
    lines = np.exp(1j * phases(n_lines))
    lines[0] = 0.0
    samples = np.fft.irfft(lines, 16 * (n_lines - 1))
    return np.asarray(samples / np.sqrt((samples**2).mean()))


@pytest.mark.parametrize("kind", FIXED)
def test_the_frf_is_exact_at_the_sharpest_resonance(kind: str) -> None:
    bench = chain(beam_system(LIGHT), rig(1, 7, excitation=kind, analyser={"averages": 2}))
    exact = inertance(bench)
    for spectra in (expected_spectra(bench), sampled_spectra(bench, np.random.default_rng(1), silent)):
        found = ESTIMATORS["h1"](spectra)[0, 1:, :, 0]
        # rounding of transforms relative to the largest line, which stands 1e5 above the smallest
        np.testing.assert_allclose(found, exact, rtol=1e-7, atol=1e-9 * np.abs(exact).max())


def test_a_chirp_sweeps_evenly_through_the_band_once_a_record() -> None:
    samples, parts = record("chirp"), 8
    spectra = np.abs(np.fft.rfft(samples.reshape(parts, -1), axis=1)) ** 2
    heard = (spectra * np.arange(spectra.shape[1])).sum(axis=1) / spectra.sum(axis=1)
    top = 400 / parts  # lines of a part up to the top of the band
    # the parts' middles; each part's own edges and the sweep's return spread over 2 lines of a part
    np.testing.assert_allclose(heard / top, (np.arange(parts) + 0.5) / parts, atol=2 / top)
    assert np.abs(samples).max() < 2.0  # a sine's peak is 1.41; Schroeder gives 1.7 for flat spectra


def test_a_pseudo_random_record_looks_gaussian() -> None:
    samples = record("pseudo_random", 2001)
    # kurtosis 3 and skewness 0 of 4000 independent numbers: errors sqrt(24/4000) and sqrt(6/4000); three
    assert abs((samples**4).mean() - 3) < 3 * np.sqrt(24 / 4000)
    assert abs((samples**3).mean()) < 3 * np.sqrt(6 / 4000)
    assert 3.0 < np.abs(samples).max() < 5.0


@pytest.mark.parametrize("kind", FIXED)
def test_a_window_mixes_the_lines_of_a_record_as_its_transform_says(kind: str) -> None:
    setup = rig(1, 7, excitation=kind, analyser={"window": "hann", "averages": 1})
    bench = chain(beam_system(), setup)
    expected, sampled = expected_spectra(bench), sampled_spectra(bench, np.random.default_rng(1), silent)
    scale = np.abs(expected.fx).max()
    # the record's transform against the sum over lines; rounding
    np.testing.assert_allclose(sampled.fx, expected.fx, atol=1e-10 * scale)
    np.testing.assert_allclose(sampled.ff, expected.ff, atol=1e-10 * np.abs(expected.ff).max())
    np.testing.assert_allclose(coherence(expected), 1.0, rtol=1e-9)


def test_a_stepped_sine_has_neither_leakage_nor_a_window() -> None:
    plain, windowed = (
        expected_spectra(
            chain(beam_system(LIGHT), rig(1, 7, excitation="stepped_sine", analyser={"window": w}))
        )
        for w in ("rectangular", "flat_top")
    )
    np.testing.assert_array_equal(plain.fx, windowed.fx)


def test_a_stepped_sine_has_all_its_power_in_the_line_and_the_noise_of_that_line_alone() -> None:
    noise = Noise(force=0.1, response=0.01)
    chirp, stepped = (
        expected_spectra(chain(beam_system(), rig(1, 7, excitation=kind, noise=noise)))
        for kind in ("chirp", "stepped_sine")
    )
    clean = expected_spectra(chain(beam_system(), rig(1, 7)))
    # 400 lines: a sine of the sweep's rms stands 400 times higher above the same noise
    np.testing.assert_allclose((chirp.ff - clean.ff) / (stepped.ff - clean.ff), 400.0, rtol=1e-9)
    np.testing.assert_allclose((chirp.xx - clean.xx) / (stepped.xx - clean.xx), 400.0, rtol=1e-6)


def test_averages_of_a_fixed_force_scatter_by_noise_alone() -> None:
    n, n_tests = 20, 500
    setup = rig(1, excitation="chirp", noise=Noise(0.05, 1e-3), analyser={"n_lines": 33, "averages": n})
    bench = chain(beam_system(), setup)
    rng = np.random.default_rng(3)
    drawn = np.array([draw(bench, rng).ff[0, 1:, 0, 0].real for _ in range(n_tests)])
    expected = expected_spectra(bench).ff[0, 1:, 0, 0].real
    noise = 0.05 / 1.05 * expected.mean()
    signal = expected - noise
    # of |mu + e|^2, averaged: variance (2 signal noise + noise^2)/n; four errors of so many draws
    np.testing.assert_allclose(drawn.mean(axis=0), expected, rtol=4 * np.sqrt(0.1 / n / n_tests))
    ratio = drawn.var(axis=0) / ((2 * signal * noise + noise**2) / n)
    assert abs(ratio.mean() - 1) < 4 * np.sqrt(2 / (32 * n_tests))
    # a fifth and less of that of a force drawn anew every time, expected^2 / n
    assert (drawn.var(axis=0) < expected**2 / n / 5).all()


def test_drawn_and_sampled_frfs_of_a_fixed_force_scatter_alike() -> None:
    n = 10
    setup = rig(
        1, excitation="pseudo_random", noise=Noise(0.1, 1e-2), analyser={"n_lines": 65, "averages": n}
    )
    bench = chain(beam_system(), setup)
    exact = ESTIMATORS["h1"](expected_spectra(bench))[0, 1:, 0, 0]
    rng = np.random.default_rng(4)
    scatter = {}
    for name in ("drawn", "sampled"):
        tests = [
            draw(bench, rng) if name == "drawn" else sampled_spectra(bench, rng, silent) for _ in range(200)
        ]
        found = np.array([ESTIMATORS["h1"](one)[0, 1:, 0, 0] for one in tests]) / exact
        scatter[name] = found.std(axis=0)
    # each known to 1/sqrt(400) a line; over 64 lines the ratio to a tenth of a per cent times 5
    ratio = scatter["drawn"] / scatter["sampled"]
    assert abs(ratio.mean() - 1) < 4 * np.sqrt(2 / (400 * 64))
    assert np.abs(ratio - 1).max() < 5 * np.sqrt(2 / 400)
    assert (scatter["drawn"] < 3 * frf_error(coherence(expected_spectra(bench))[0, 1:, 0], n)).all()


@pytest.mark.parametrize("kind", [*FIXED, "impact"])
def test_several_shakers_with_the_same_signal_are_refused(kind: str) -> None:
    setup = replace(rig(1, 7, excitation=kind), drives=dofs(1, 11))
    with pytest.raises(InvalidInputError) as caught:
        check_compatible(setup)
    assert caught.value.context["field"] == "excitation.kind"
