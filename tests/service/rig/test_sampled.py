"""Time records: the reference that expected spectra are held against."""

import tracemalloc

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.progress import silent
from modallab.effects.leakage import Leakage
from modallab.estimation.coherence import coherence, coherence_error, frf_error
from modallab.estimation.estimator import ESTIMATORS
from modallab.fe.assembly import assemble
from modallab.fe.damping import ModalDamping, StructuralDamping, ViscousDamping
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.sampled import sampled_spectra
from tests.rigs import beam_system, rig, steel_beam

NOISE = Noise(1e-2, 1e-5)


def test_two_routes_agree_on_resonances_from_a_tenth_of_a_line_to_several_lines() -> None:
    # seven modes whose half-power bandwidths are 0.10 to 2.5 lines
    bench = chain(
        beam_system(StructuralDamping(stiffness_coefficient=0.0065)),
        rig(
            *(1, 6, 11, 18),
            excitation="random",
            exciter=Exciter(armature_mass=0.02),
            noise=NOISE,
            analyser={"frequency_max": 600.0, "n_lines": 401, "window": "hann", "averages": 800},
        ),
    )
    expected, sampled = expected_spectra(bench), sampled_spectra(bench, np.random.default_rng(1), silent)
    g2 = coherence(expected)
    for kind in ("h1", "h2"):
        ratio = np.abs(ESTIMATORS[kind](sampled) / ESTIMATORS[kind](expected))[..., 0]
        within = np.abs(ratio - 1) < 3 * frf_error(g2, 800)
        assert within.mean() >= 0.99, kind  # 0.997 of a normal scatter
    within = np.abs(coherence(sampled) / g2 - 1) < 3 * coherence_error(g2, 800)
    assert within.mean() >= 0.99
    h1, h2 = ESTIMATORS["h1"](sampled)[..., 0], ESTIMATORS["h2"](sampled)[..., 0]
    np.testing.assert_allclose(h1, coherence(sampled) * h2, rtol=1e-12)  # rounding


def test_a_periodic_excitation_has_no_bias_at_the_sharpest_resonance() -> None:
    light = beam_system(StructuralDamping(stiffness_coefficient=1e-4))  # 0.001 of a line
    bench = chain(light, rig(1, 7, analyser={"averages": 3}))
    sampled = sampled_spectra(bench, np.random.default_rng(1), silent)
    exact = ESTIMATORS["h1"](expected_spectra(bench))
    # rounding of two transforms relative to the largest line, which stands 1e5 above the smallest
    np.testing.assert_allclose(ESTIMATORS["h1"](sampled), exact, rtol=1e-8)
    np.testing.assert_allclose(coherence(sampled), 1.0, rtol=1e-9)


@pytest.mark.parametrize("excitation", ["random", "periodic_random"])
@pytest.mark.parametrize("window", ["rectangular", "hann", "flat_top"])
def test_auto_spectra_have_their_expected_size(excitation: str, window: str) -> None:
    settings = {"n_lines": 101, "window": window, "averages": 400}
    # so much damping that no mode remembers the record before: the averages are independent
    heavy = beam_system(StructuralDamping(stiffness_coefficient=0.3))
    bench = chain(heavy, rig(1, 11, excitation=excitation, noise=NOISE, analyser=settings))
    expected, sampled = expected_spectra(bench), sampled_spectra(bench, np.random.default_rng(2), silent)
    for found, wanted in ((sampled.ff.real, expected.ff.real), (sampled.xx, expected.xx)):
        ratio = found / wanted
        # 400 averages: 5 %, at 0 Hz 7 %; four of each; over 100 lines, three of which move together, 1 %
        np.testing.assert_allclose(ratio[:, 1:], 1, atol=0.20)
        np.testing.assert_allclose(ratio[:, 0], 1, atol=0.28)
        np.testing.assert_allclose(ratio.mean(axis=1), 1, atol=0.04)


def test_part_of_the_power_may_leak() -> None:
    setup = rig(1, 11, analyser={"n_lines": 101, "window": "hann", "averages": 1000})
    bench = chain(beam_system(), setup, [Leakage(share=0.3)])
    expected, sampled = expected_spectra(bench), sampled_spectra(bench, np.random.default_rng(3), silent)
    g2 = coherence(expected)
    assert g2.min() < 0.9
    within = np.abs(coherence(sampled) / g2 - 1) < 3 * coherence_error(g2, 1000)
    assert within.mean() >= 0.98  # of 202 values four outside by chance: one in 400 is


@pytest.mark.parametrize("law", [ViscousDamping(1e-6, 5.0), ModalDamping((0.02,))])
def test_other_laws_of_damping_agree_as_well(law: ViscousDamping | ModalDamping) -> None:
    settings = {"n_lines": 41, "window": "hann", "averages": 600}
    system = assemble(steel_beam(law, n_elements=6))
    bench = chain(system, rig(1, 4, excitation="random", analyser=settings))
    expected, sampled = expected_spectra(bench), sampled_spectra(bench, np.random.default_rng(4), silent)
    g2 = coherence(expected)
    ratio = np.abs(ESTIMATORS["h1"](sampled) / ESTIMATORS["h1"](expected))[..., 0]
    assert (np.abs(ratio - 1) < 3 * frf_error(g2, 600))[:, 1:].mean() >= 0.96  # of 80 values, as above


def test_overlapping_records_agree_too() -> None:
    settings = {"n_lines": 101, "window": "hann", "averages": 600, "overlap": 0.5}
    bench = chain(beam_system(), rig(1, 11, excitation="random", noise=NOISE, analyser=settings))
    expected, sampled = expected_spectra(bench), sampled_spectra(bench, np.random.default_rng(5), silent)
    assert np.isclose(sampled.averages, 600 / (1 + 2 / 36), rtol=1e-3)
    g2 = coherence(expected)
    ratio = np.abs(ESTIMATORS["h1"](sampled) / ESTIMATORS["h1"](expected))[..., 0]
    assert (np.abs(ratio - 1) < 3 * frf_error(g2, sampled.averages))[:, 1:].mean() >= 0.98


def test_runs_of_a_roving_accelerometer_have_forces_of_their_own() -> None:
    setup = rig(1, 11, accelerometers=Accelerometers(0.02, roving=True), analyser={"averages": 200})
    sampled = sampled_spectra(chain(beam_system(), setup), np.random.default_rng(6), silent)
    first, second = sampled.ff[:, :, 0, 0].real - 1 / 800  # about the declared density
    alike = first @ second / np.sqrt((first @ first) * (second @ second))
    assert abs(alike) < 3 / np.sqrt(401)


@pytest.mark.parametrize("excitation", ["random", "periodic_random"])
def test_the_same_seed_measures_the_same_bytes(excitation: str) -> None:
    setup = rig(1, 11, excitation=excitation, noise=NOISE, analyser={"n_lines": 65, "averages": 7})
    a, b, c = (
        sampled_spectra(chain(beam_system(), setup), np.random.default_rng(s), silent) for s in (1, 1, 2)
    )
    assert a.fx.tobytes() == b.fx.tobytes() != c.fx.tobytes()


def test_far_leakage_is_that_of_sampled_records() -> None:
    settings = {"n_lines": 41, "averages": 10_000, "window": "rectangular"}
    bench = chain(beam_system(), rig(11, excitation="random", analyser=settings))
    expected, sampled = expected_spectra(bench), sampled_spectra(bench, np.random.default_rng(1), silent)
    ratio = (sampled.xx / expected.xx)[0, :, 0]
    leaked = expected.xx[0, :, 0] < np.quantile(expected.xx, 0.4)  # far from all resonances
    # 1 % a line, and all of them alike by the power of few resonances, 0.3 %: three of these. The line shape
    # of continuous time, 1/(pi y) for 1/(N sin(pi y/N)), would be 4 % too low.
    assert np.isclose(ratio[leaked].mean(), 1.0, atol=0.01)


def test_progress_rises_to_the_end_and_can_stop_the_measurement() -> None:
    seen: list[float] = []
    setup = rig(1, 11, accelerometers=Accelerometers(0.02, roving=True), analyser={"averages": 500})
    sampled_spectra(chain(beam_system(), setup), np.random.default_rng(1), lambda f, _: seen.append(f))
    assert seen == sorted(seen)
    assert len(seen) > 4
    assert seen[-1] == 1.0

    def stop(_fraction: float, _message: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sampled_spectra(chain(beam_system(), setup), np.random.default_rng(1), stop)


def peak_memory(excitation: str, n_lines: int, averages: int) -> int:
    """Bytes that a sampled test of one channel each takes at most, beside what is kept for the next time."""
    settings = {"n_lines": n_lines, "window": "hann", "averages": averages}
    bench = chain(beam_system(), rig(11, excitation=excitation, analyser=settings))
    expected_spectra(bench)
    tracemalloc.start()
    sampled_spectra(bench, np.random.default_rng(1), silent)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


@pytest.mark.parametrize("excitation", ["random", "periodic_random"])
def test_ten_thousand_averages_take_the_memory_of_a_hundred(excitation: str) -> None:
    # averages are shared out to equal stretches, a tenth longer or shorter
    assert peak_memory(excitation, 801, 10_000) < 1.2 * peak_memory(excitation, 801, 100)


@pytest.mark.parametrize("excitation", ["random", "periodic_random"])
def test_short_records_are_not_gathered_beyond_a_bound(excitation: str) -> None:
    # a hundred of these are less than what is made at once: 2^18 samples, and a few arrays of that size
    assert peak_memory(excitation, 101, 10_000) < 8 * 8 * 2**18


def test_a_mode_that_rings_for_ever_is_no_stationary_signal() -> None:
    undamped = chain(beam_system(StructuralDamping()), rig(1, excitation="random"))
    with pytest.raises(InvalidInputError, match="rings"):
        sampled_spectra(undamped, np.random.default_rng(1), silent)
