"""The blow of a hammer: closed forms of its pulse and its reach, and what an operator's hand adds."""

from typing import Any

import numpy as np
import pytest
from scipy.sparse import csc_array

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.progress import silent
from modallab.estimation.coherence import coherence
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra
from modallab.estimation.windows import added_loss_factor
from modallab.fe.assembly import assemble
from modallab.fe.damping import StructuralDamping, ViscousDamping
from modallab.fe.receptance import direct_receptance
from modallab.fe.system import DynamicSystem
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import Chain, chain
from modallab.rig.expected import expected_spectra
from modallab.rig.free_decay import impulse_responses_of
from modallab.rig.hammer import pulse_spectrum, pulse_width, tilt_factors, tilt_moments
from modallab.rig.measure import draw
from modallab.rig.sampled import sampled_spectra
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, dofs, steel_beam, tilted_beam

HEAVY = StructuralDamping(stiffness_coefficient=0.2)  # rings out within a record


def struck(system: DynamicSystem, *nodes: int, analyser: Any = None, **setting: Any) -> Chain:
    excitation = ExcitationSetting("impact", **setting)
    return chain(
        system, RigSetup(dofs(1), dofs(*nodes), analyser=Analyser(excitation=excitation, **(analyser or {})))
    )


def h1(spectra: CrossSpectra) -> ComplexArray:
    return ESTIMATORS["h1"](spectra)[0, :, :, 0]


def exact(bench: Chain) -> ComplexArray:
    freq, acquisition_run, system = (
        bench.setup.analyser.freq[1:],
        bench.runs[0].acquisition_run,
        bench.runs[0].system,
    )
    columns = system.selection(acquisition_run.outputs), system.selection(acquisition_run.drives)
    return -((2 * np.pi * freq) ** 2)[:, None] * direct_receptance(system, freq, *columns)[..., 0]


def test_the_pulse_is_half_a_sine_of_half_a_period_of_the_head_on_its_tip() -> None:
    width = pulse_width(1e7, 0.2)
    t = np.linspace(0, width, 20_001)
    pulse = np.sin(np.pi * t / width)
    freq = np.linspace(0.0, 4 / width, 33)
    by_sum = np.trapezoid(pulse * np.exp(-2j * np.pi * freq[:, None] * t), t, axis=1)
    # a trapezoidal rule of 20,000 steps: (8 pi / 20,000)^2 / 12 of the fastest turn
    found = pulse_spectrum(2 * np.pi * freq, width)
    np.testing.assert_allclose(found, by_sum / (2 * width / np.pi), atol=1e-6)
    # the head's equation of motion m x'' = -k x from a start at its speed: out again after pi sqrt(m/k)
    assert np.isclose(width, np.pi / np.sqrt(1e7 / 0.2), rtol=1e-14)
    assert abs(pulse_spectrum(np.array([3 * np.pi / width]), width)[0]) < 1e-15  # zero at 3/2 of 1/width


@pytest.mark.parametrize("tip", [1e6, 1e7, 1e8])
def test_a_harder_tip_reaches_as_much_farther_as_the_root_of_its_stiffness(tip: float) -> None:
    soft, hard = pulse_width(tip, 0.2), pulse_width(4 * tip, 0.2)
    freq = np.linspace(0.0, 1.3, 40) / soft
    found, expected = pulse_spectrum(4 * np.pi * freq, hard), pulse_spectrum(2 * np.pi * freq, soft)
    np.testing.assert_allclose(np.abs(found), np.abs(expected), rtol=1e-9)  # rounding
    # cos(4.10)/(1 - (2 4.10/pi)^2) = 0.099, by hand: 20 dB below the start
    end = pulse_spectrum(np.array([2 * 4.10 / soft]), soft)
    assert np.isclose(np.abs(end[0]), 0.099, atol=5e-4)  # of three digits


@pytest.mark.parametrize("tip", [1e6, 1e7])
def test_the_measured_force_spectrum_is_that_of_the_pulse(tip: float) -> None:
    bench = struck(beam_system(), 1, 7, tip_stiffness=tip, level=3.0)
    force = expected_spectra(bench).ff[0, :, 0, 0].real
    shape = np.abs(pulse_spectrum(2 * np.pi * bench.setup.analyser.freq, pulse_width(tip, 0.2))) ** 2
    # the anti-alias filter rings beyond the record's start: 2e-3 of the size at low frequency
    np.testing.assert_allclose(force / (9.0 / 800), shape, atol=3e-3)


def test_an_impact_gives_the_exact_frf_where_the_response_dies_out() -> None:
    bench = struck(beam_system(HEAVY), 1, 7)
    for spectra in (expected_spectra(bench), sampled_spectra(bench, np.random.default_rng(1), silent)):
        found, wanted = h1(spectra)[1:], exact(bench)
        # a free body goes on after the blow, which a record cuts off: at the first lines and the last
        np.testing.assert_allclose(found[5:-5], wanted[5:-5], atol=2e-3 * np.abs(wanted).max())
        assert coherence(spectra).min() > 1 - 1e-9  # the same every time


@pytest.mark.parametrize("end", [1e-1, 1e-2, 1e-4])
def test_an_exponential_window_moves_every_pole_by_its_rate_of_decay(end: float) -> None:
    """The transform of a signal times exp(-sigma t) is its Laplace transform at i omega + sigma."""
    system = assemble(steel_beam(ViscousDamping(2e-6, 4.0), n_elements=6))
    settings = {"window": "exponential", "window_end": end, "n_lines": 201, "frequency_max": 400.0}
    bench = struck(system, 1, 4, analyser=settings)
    analyser = bench.setup.analyser
    sigma = -np.log(end) * analyser.spacing
    s = 2j * np.pi * analyser.freq[3:-3] + sigma
    assert system.viscous is not None
    m, c, k = (part.toarray() for part in (system.mass, system.viscous, system.stiffness))
    dynamic = m * s[:, None, None] ** 2 + c * s[:, None, None] + k
    solved = np.linalg.solve(dynamic, system.selection(dofs(1)).astype(complex)[None])
    wanted = s[:, None] ** 2 * (system.selection(dofs(1, 4)).T @ solved)[..., 0]
    found = h1(expected_spectra(bench))[3:-3]
    # what is left at the record's end, of the size `end` and of the modes' own decay, is cut off
    np.testing.assert_allclose(found, wanted, atol=(end + 2e-3) * np.abs(wanted).max())
    unmoved = exact(struck(system, 1, 4, analyser=settings | {"window": "rectangular"}))[2:-3]
    assert np.abs(found - unmoved).max() > 0.3 * np.abs(unmoved).max()


def test_what_an_exponential_window_adds_to_a_loss_factor_is_two_sigma_over_omega() -> None:
    mass, f, eta, end, length = 1.0, 40.0, 0.02, 1e-3, 0.5
    omega, sigma = 2 * np.pi * f, -np.log(end) / length
    # poles of a viscous mode of loss factor eta at resonance, moved by sigma: half-power bandwidth over f
    moved = np.roots([mass, mass * eta * omega, mass * omega**2]) - sigma
    assert np.isclose(-2 * moved[0].real / omega - eta, added_loss_factor(end, length, np.array([f]))[0])
    assert added_loss_factor(1.0, length, np.array([f]))[0] == 0.0


def test_one_degree_of_freedom_struck_in_a_record_is_the_closed_form() -> None:
    """Q = A/(i w - lambda) (1 - exp((lambda - i w)(T - s))), of a rigid body's spring and damper."""
    mass, stiffness, viscous = 2.0, 2.0 * (2 * np.pi * 40.0) ** 2, 6.0
    system = one_degree(mass, stiffness, viscous)
    setup = RigSetup(
        (Dof(1, "Y"),),
        (Dof(1, "Y"),),
        analyser=Analyser(200.0, 101, excitation=ExcitationSetting("impact", tip_stiffness=1e11)),
    )
    bench = chain(system, setup)
    answers = impulse_responses_of(bench, 0)
    n, analyser = answers.n_samples, setup.analyser
    s = round(0.3 * n)
    record = answers.records_after(np.array([s]))[0, 0, 1]
    lines = np.fft.rfft(record)[: analyser.n_lines] * np.exp(2j * np.pi * np.arange(analyser.n_lines) * s / n)
    omega = 2 * np.pi * analyser.freq
    pole = -viscous / (2 * mass) + 1j * np.sqrt(stiffness / mass - (viscous / (2 * mass)) ** 2)
    left = analyser.record_length * (1 - s / n)
    wanted = 1 / mass + 0j * omega  # acceleration: what the blow itself does, then what the modes ring
    for one in (pole, pole.conjugate()):
        residue = one**2 / (2j * mass * one.imag)  # of the acceleration's impulse response
        wanted = wanted + residue / (1j * omega - one) * (1 - np.exp((one - 1j * omega) * left))
    scale = lines[1:50].mean() / wanted[1:50].mean()
    # the filter's ringing is cut off with the record: 1e-3 of the largest
    np.testing.assert_allclose(lines[:95] / scale, wanted[:95], atol=3e-3 * np.abs(wanted).max())


def test_sizes_of_blows_scatter_about_the_declared_level_on_both_routes() -> None:
    n, n_tests, scatter = 5, 120, 0.3
    settings = {"n_lines": 33, "averages": n}
    bench = struck(beam_system(HEAVY), 7, analyser=settings, level_scatter=scatter)
    expected = expected_spectra(bench).ff[0, 1, 0, 0].real
    alike = struck(beam_system(HEAVY), 7, analyser=settings)
    assert np.isclose(expected, expected_spectra(alike).ff[0, 1, 0, 0].real, rtol=1e-12)
    # log-normal sizes a of mean square 1: var(a^2) = exp(4 s^2) - 1
    spread = np.sqrt((np.exp(4 * scatter**2) - 1) / n)
    rng = np.random.default_rng(1)

    def drawn() -> CrossSpectra:
        return draw(bench, rng)

    def sampled() -> CrossSpectra:
        return sampled_spectra(bench, rng, silent)

    for route in (drawn, sampled):
        found = np.array([route().ff[0, 1:, 0, 0].real for _ in range(n_tests)]) / expected
        # all lines of a test share it; without noise the coherence stays 1
        np.testing.assert_allclose(found[:, 0] * found[0, -1] / found[0, 0], found[:, -1], rtol=1e-9)
        assert abs(found[:, 0].mean() - 1) < 4 * spread / np.sqrt(n_tests)
        # of a variance of numbers with long tails (kurtosis about 6): four errors
        assert np.isclose(found[:, 0].std(), spread, rtol=4 * np.sqrt(5 / n_tests / 4))
        assert coherence(route()).min() > 1 - 1e-9


def test_a_blow_beside_its_point_is_a_moment_that_costs_coherence() -> None:
    scatter = 0.03
    bench = struck(beam_system(HEAVY), 1, 11, place_scatter=scatter)
    system, freq = bench.runs[0].system, bench.setup.analyser.freq[1:]
    at, turned = (
        -((2 * np.pi * freq) ** 2)[:, None]
        * direct_receptance(system, freq, system.selection(dofs(1, 11)), system.selection((dof,)))[..., 0]
        for dof in (Dof(1, "Y"), Dof(1, "RZ"))
    )
    expected = expected_spectra(bench)
    # the gauge shows the same force wherever it goes: what the moment adds is never coherent with it
    wanted = 1 / (1 + scatter**2 * np.abs(turned / at) ** 2)
    inner = slice(5, -5)  # the blow's rigid-body motion is cut off with the record
    np.testing.assert_allclose(coherence(expected)[0, 1:][inner], wanted[inner], atol=0.02)
    assert wanted[inner].min() < 0.8
    clean = struck(beam_system(HEAVY), 1, 11)
    # no bias to first order; of hysteretic damping, not causal, 1e-6 is left after a record
    np.testing.assert_allclose(h1(expected), h1(expected_spectra(clean)), rtol=1e-6)


@pytest.mark.parametrize("route", ["drawn", "sampled"])
def test_an_unsteady_hand_scatters_alike_on_all_routes(route: str) -> None:
    n = 3000
    hand = {"place_scatter": 0.01, "angle_scatter": 0.3, "level_scatter": 0.1}
    system = assemble(tilted_beam())
    bench = struck(system, 1, 11, analyser={"n_lines": 65, "averages": n}, **hand)
    expected, rng = expected_spectra(bench), np.random.default_rng(2)
    found = draw(bench, rng) if route == "drawn" else sampled_spectra(bench, rng, silent)
    # coefficients of n blows: their mean squares to 2/sqrt(n) at most; all lines share them
    np.testing.assert_allclose(found.ff.real, expected.ff.real, rtol=4 * 0.2 / np.sqrt(n))
    np.testing.assert_allclose(found.xx, expected.xx, rtol=8 / np.sqrt(n))
    np.testing.assert_allclose(coherence(found), coherence(expected), atol=6 / np.sqrt(n))
    assert coherence(expected)[0, 2:].min() < 0.9


def test_a_tilted_blow_has_less_along_its_axis_and_some_across() -> None:
    scatter, n = 0.4, 200_000
    along, across = tilt_factors(scatter, n, 1, np.random.default_rng(3))
    mean, spread, square = tilt_moments(scatter, 1)
    assert np.isclose(along.mean(), mean, atol=4 * along.std() / np.sqrt(n))
    assert np.isclose(along.var(), spread, rtol=4 * np.sqrt(8 / n))  # skew: kurtosis below 10
    assert np.isclose((across**2).mean(), square, rtol=4 * np.sqrt(3 / n))
    bench = struck(beam_system(HEAVY), 7, angle_scatter=scatter)
    upright = struck(beam_system(HEAVY), 7)
    biased = h1(expected_spectra(bench)) / h1(expected_spectra(upright))
    # of hysteretic damping, not causal, 1e-6 is left after a record
    np.testing.assert_allclose(biased[1:], np.exp(-(scatter**2) / 2), rtol=1e-6)


def one_degree(mass: float, stiffness: float, viscous: float) -> DynamicSystem:
    """One mass on one spring."""
    m, k, c = (csc_array([[value]]) for value in (mass, stiffness, viscous))
    return DynamicSystem(m, k, (Dof(1, "Y"),), viscous=c)
