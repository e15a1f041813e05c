"""Expected spectra: exact without effects, leaking as the integral says, noisy as printed."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.effects.stinger_axial import StingerAxial
from modallab.estimation.coherence import coherence
from modallab.estimation.estimator import ESTIMATORS
from modallab.fe.damping import StructuralDamping
from modallab.fe.receptance import direct_receptance
from modallab.rig.chain import Chain, chain
from modallab.rig.expected import coarse_spectra, expected_spectra
from modallab.rig.hardware import Exciter, Noise
from tests.rigs import beam_system, rig

LOW = {"frequency_max": 200.0, "n_lines": 101, "window": "hann"}


def inertance(bench: Chain) -> ComplexArray:
    """The FRF of the structure as it stands in the first run, by solving at every line."""
    freq, acquisition_run, system = (
        bench.setup.analyser.freq,
        bench.runs[0].acquisition_run,
        bench.runs[0].system,
    )
    alpha = direct_receptance(
        system,
        freq[1:],
        system.selection(acquisition_run.outputs),
        system.selection((acquisition_run.drive,)),
    )
    return -((2 * np.pi * freq[1:]) ** 2)[:, None] * alpha[..., 0]


@pytest.mark.parametrize("estimator", sorted(ESTIMATORS))
def test_a_rig_without_effects_returns_the_exact_frf(estimator: str) -> None:
    bench = chain(beam_system(), rig(1, 7, 16))
    spectra = expected_spectra(bench)
    found = ESTIMATORS[estimator](spectra)[0, 1:, :, 0]
    scale = np.abs(found).max()
    # rounding of two solutions of a stiff beam: 1e-16 times the ratio of its eigenvalues, 1e6
    np.testing.assert_allclose(found, inertance(bench), rtol=1e-8, atol=1e-9 * scale)
    np.testing.assert_allclose(coherence(spectra), 1.0, atol=1e-14)  # rounding


def test_the_force_has_the_declared_power_over_the_band() -> None:
    setup = rig(1, analyser={"n_lines": 401})
    force = expected_spectra(chain(beam_system(), setup)).ff[0, :, 0, 0].real
    analyser = setup.analyser
    assert np.isclose(np.trapezoid(force, analyser.freq), analyser.source_level**2, rtol=1e-13)


def test_the_force_drops_out_where_the_armature_moves() -> None:
    mass = 0.05
    ideal = expected_spectra(chain(beam_system(), rig(1)))
    with_armature = expected_spectra(chain(beam_system(), rig(1, exciter=Exciter(armature_mass=mass))))
    h = ESTIMATORS["h1"](ideal)[0, 1:, 0, 0]
    dropped = ideal.ff[0, 1:, 0, 0] / np.abs(1 + mass * h) ** 2  # 1992 thesis, eq. [5.4]
    np.testing.assert_allclose(with_armature.ff[0, 1:, 0, 0], dropped, rtol=1e-10)  # rounding
    # and the FRF stays as it is
    np.testing.assert_allclose(ESTIMATORS["h1"](with_armature)[0, 1:, 0, 0], h, rtol=1e-10)


def test_noise_biases_h1_low_h2_high_and_lowers_coherence_as_printed() -> None:
    noise = Noise(force=2e-2, response=3e-3)
    clean = expected_spectra(chain(beam_system(), rig(1, 7)))
    noisy = expected_spectra(chain(beam_system(), rig(1, 7, noise=noise)))
    force, response = clean.ff[..., 0].real, clean.xx
    r_i = noise.force * force.mean(axis=1, keepdims=True) / force
    r_o = noise.response * response.mean(axis=1, keepdims=True) / response
    h = ESTIMATORS["h1"](clean)[..., 0]
    # 1992 thesis, eq. [5.6], [5.7], [5.8]; rounding
    np.testing.assert_allclose(ESTIMATORS["h1"](noisy)[..., 0], h / (1 + r_i), rtol=1e-12)
    np.testing.assert_allclose(ESTIMATORS["h2"](noisy)[..., 0], h * (1 + r_o), rtol=1e-12)
    np.testing.assert_allclose(coherence(noisy), 1 / ((1 + r_i) * (1 + r_o)), rtol=1e-12)


def brute_force(bench: Chain, points: int) -> FloatArray:
    """Return G_ff, |G_fx|, G_xx through a Hanning record by a plain sum over `points` a line."""
    analyser = bench.setup.analyser
    x = np.linspace(0, analyser.n_lines - 1.0, (analyser.n_lines - 1) * points + 1)
    low, high = analyser.excitation.band or (0.0, analyser.frequency_max)
    x = x[(x >= low / analyser.spacing) & (x <= high / analyser.spacing)]
    response = bench.respond(x * analyser.spacing)
    force = np.abs(response.force[0, :, 0, 0]) ** 2 * analyser.source_level**2 / (high - low)
    h = response.inertance[0, :, 0, 0]
    weight = np.full(len(x), 1.0 / points)
    weight[[0, -1]] /= 2

    def window(u: FloatArray) -> FloatArray:  # 1992 thesis, eq. [5.12], its limits filled in
        u = u + 1e-7
        return np.asarray(2 / 3 * (np.sin(np.pi * u) / (np.pi * u * (1 - u**2))) ** 2)

    seen = []
    for spectrum in (force, force * h, force * np.abs(h) ** 2):
        lines = np.arange(analyser.n_lines)[:, None]
        above, below = window(lines - x) @ (weight * spectrum), window(lines + x) @ (weight * spectrum.conj())
        seen.append(above + below)
    return np.array(seen)


@pytest.mark.parametrize(("loss", "band"), [(0.004, None), (0.05, None), (0.05, (3.0, 151.0))])
def test_leaking_spectra_are_the_convolution_with_the_window(
    loss: float, band: tuple[float, float] | None
) -> None:
    # half-power bandwidths from 0.05 lines, the first mode with the small loss, to 5 lines; a source's band
    # ends on lines or halfway between two
    setup = rig(11, excitation="random", exciter=Exciter(armature_mass=0.02), analyser=LOW)
    excitation = replace(setup.analyser.excitation, band=band)
    setup = replace(setup, analyser=replace(setup.analyser, excitation=excitation))
    bench = chain(beam_system(StructuralDamping(stiffness_coefficient=loss)), setup)
    spectra = expected_spectra(bench)
    by_sum = brute_force(bench, 400)
    # the sum's upper end leaves (1/400)^2/12 of the slope there; the shift by which it steps over the
    # window's 0/0 leaves 1e-7
    for found, wanted in zip(
        (spectra.ff[0, :, 0, 0], spectra.fx[0, :, 0, 0], spectra.xx[0, :, 0]), by_sum, strict=True
    ):
        # beside an end of the band the window is so steep that the sum leaves ten times as much
        rtol = 2e-6 if band is None else 3e-5
        np.testing.assert_allclose(found, wanted, rtol=rtol, atol=1e-10 * np.abs(wanted).max())


def test_with_leakage_h1_is_coherence_times_h2_and_resonances_come_out_low() -> None:
    setup = rig(1, 7, excitation="random", analyser=LOW)
    light = StructuralDamping(stiffness_coefficient=0.004)
    spectra = expected_spectra(chain(beam_system(light), setup))
    exact = expected_spectra(chain(beam_system(light), rig(1, 7, analyser=LOW | {"window": "rectangular"})))
    h1, h2, h = (ESTIMATORS[kind](s)[..., 0] for kind, s in (("h1", spectra), ("h2", spectra), ("h1", exact)))
    np.testing.assert_allclose(h1, coherence(spectra) * h2, rtol=1e-12)  # rounding
    peaks = np.abs(h[0, :, 0]).argsort()[-3:]
    assert (np.abs(h1[0, peaks, 0]) < np.abs(h[0, peaks, 0])).all()


def test_what_repeats_with_the_record_does_not_leak() -> None:
    exact = ESTIMATORS["h1"](expected_spectra(chain(beam_system(), rig(1, 7))))
    leaking, periodic = (
        expected_spectra(chain(beam_system(), rig(1, 7, excitation=kind, analyser={"window": window})))
        for kind, window in (("random", "hann"), ("periodic_random", "rectangular"))
    )
    np.testing.assert_allclose(ESTIMATORS["h1"](periodic), exact, rtol=1e-14)
    assert coherence(periodic).min() > 1 - 1e-12 > coherence(leaking).min()


def test_a_first_look_is_the_expected_spectra_where_resonances_are_lines_wide() -> None:
    setup = rig(1, 7, excitation="random", analyser=LOW)
    bench = chain(beam_system(StructuralDamping(stiffness_coefficient=0.1)), setup)  # from 1.2 lines
    quick, full = coarse_spectra(bench, 4), expected_spectra(bench)
    np.testing.assert_array_equal(quick.freq, full.freq[::4])
    # midpoints h = half a line apart, poles a = 0.6 lines away: of a peak of 1 they miss
    # 2 exp(-2 pi a / h) (pi / a) W(ia)^2 / 1.5 = 5.8e-3 at most, 9e-3 of the two thirds that a line sees
    np.testing.assert_allclose(quick.xx, full.xx[:, ::4], rtol=9e-3)
    np.testing.assert_allclose(quick.ff, full.ff[:, ::4], rtol=9e-3)


def test_overlap_counts_only_where_records_follow_one_another() -> None:
    settings = {"window": "hann", "overlap": 0.5, "averages": 100}
    worth = {
        kind: expected_spectra(chain(beam_system(), rig(1, excitation=kind, analyser=settings))).averages
        for kind in ("random", "periodic_random")
    }
    assert np.isclose(worth["random"], 94.79, atol=0.01)
    assert worth["periodic_random"] == 100


def test_a_first_look_has_the_noise_of_a_force_that_resonates_between_its_lines() -> None:
    exciter = Exciter(armature_mass=0.02)
    setup = rig(1, 7, exciter=exciter, noise=Noise(1e-4, 1e-4), analyser={"n_lines": 401})
    stiffness = 0.02 * (2 * np.pi * 71.0) ** 2  # its half-power bandwidth of 1.4 Hz has one line, or none
    bench = chain(beam_system(), setup, [StingerAxial(stiffness=stiffness, loss_factor=0.02)])
    quick, full = coarse_spectra(bench, 3), expected_spectra(bench)
    np.testing.assert_allclose(quick.ff, full.ff[:, ::3], rtol=1e-9)  # rounding of equal sums
    np.testing.assert_allclose(quick.xx, full.xx[:, ::3], rtol=1e-9)
