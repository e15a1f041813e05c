from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.frequency_inconsistency import InconsistencyCause
from modallab.effects.drift import Drift
from modallab.extraction.averaging.frequency_inconsistency import FittedModes, find_frequency_inconsistency
from modallab.extraction.extract import extract
from modallab.rig.hardware import Accelerometers, Noise
from modallab.rig.measure import Route, measure
from tests.rigs import beam_system, rig, steel_beam
from tests.service.extraction.conftest import Beam, beam

NOISE = 0.02  # of a bandwidth: the error of a frequency in good data


def fitted(of: Beam, *, seed: int | None = None, noise: float = NOISE, scaled: bool = True) -> FittedModes:
    """Return exact frequencies and shapes of a roving test, with random error if there is a seed."""
    error = noise * of.loss_factors * of.frequencies
    frequency = of.frequencies
    if seed is not None:
        frequency = frequency + error * np.random.default_rng(seed).standard_normal(error.shape)
    shape = of.constants / np.sqrt(of.constants[:, :1])
    return FittedModes(
        frequency=frequency,
        frequency_error=error,
        loss_factor=of.loss_factors,
        good=np.ones(error.shape, bool),
        shape=shape if scaled else shape / np.abs(shape).max(axis=1, keepdims=True),
        shape_error=0.002 * np.abs(shape),
        scaled=scaled,
    )


def drifting(change: float, of: Beam, seed: int) -> FittedModes:
    """Return a test in which all frequencies change evenly by this part."""
    modes = fitted(of, seed=seed)
    return replace(modes, frequency=modes.frequency * (1 + change * np.linspace(0, 1, 11)))


def test_random_error_alone_is_no_wander_but_one_time_in_a_thousand(plain_beam: Beam) -> None:
    found = [find_frequency_inconsistency(fitted(plain_beam, seed=seed)) for seed in range(300)]
    assert (
        sum(inconsistency is not None for inconsistency in found) <= 3
    )  # 0.3 expected, 3 or more once in 300 such runs


@pytest.mark.parametrize("grams", [2.0, 20.0, 50.0])
def test_the_mass_that_roves_is_found_within_its_error(grams: float) -> None:
    inconsistency = find_frequency_inconsistency(fitted(beam(grams / 1e3, 0.0), seed=1))
    assert inconsistency is not None
    assert inconsistency.cause is InconsistencyCause.ROVING_MASS
    assert inconsistency.explained > 0.8  # 2 g: shifts of 2 standard errors, the rest is random error
    # the error has the second order of the loading in it: 2 m phi^2, 1 to 7 % of the mass
    assert abs(inconsistency.size - grams / 1e3) < 2 * inconsistency.size_error
    assert inconsistency.size_error < 0.15 * grams / 1e3
    off = (inconsistency.mode_size - grams / 1e3) / inconsistency.mode_size_error
    assert np.sqrt((off**2).mean()) < 1.5  # 8 standard scores, known to a quarter, and conservative


def test_without_the_mass_frequencies_are_those_of_the_unloaded_structure(plain_beam: Beam) -> None:
    loaded = beam(0.02, 0.0)
    inconsistency = find_frequency_inconsistency(fitted(loaded))
    assert inconsistency is not None
    exact = plain_beam.frequencies[:, 0]
    before, after = (
        np.abs(loaded.frequencies.mean(axis=1) - exact),
        np.abs(inconsistency.still_frequency - exact),
    )
    assert (after < 0.1 * before).all()  # what stays is of second order, m phi^2 of a twentieth at most


def test_shifts_are_those_of_exact_poles_from_their_mean(roving_beam: Beam) -> None:
    inconsistency = find_frequency_inconsistency(fitted(roving_beam))
    assert inconsistency is not None
    exact = roving_beam.frequencies - roving_beam.frequencies.mean(axis=1, keepdims=True)
    np.testing.assert_allclose(inconsistency.shift, exact, atol=1e-12)  # rounding of 750 Hz


def test_shapes_without_scale_tell_the_pattern_and_not_the_mass(roving_beam: Beam) -> None:
    inconsistency = find_frequency_inconsistency(fitted(roving_beam, seed=2, scaled=False))
    assert inconsistency is not None
    assert inconsistency.cause is InconsistencyCause.SQUARED_SHAPE
    assert inconsistency.explained > 0.9
    assert np.isnan(inconsistency.mode_size).all()


@pytest.mark.parametrize("change", [-0.002, 0.001])
def test_a_structure_that_warms_drifts_in_all_modes_alike(plain_beam: Beam, change: float) -> None:
    modes = drifting(change, plain_beam, seed=3)
    inconsistency = find_frequency_inconsistency(modes)
    assert inconsistency is not None
    assert inconsistency.cause is InconsistencyCause.STEADY_DRIFT
    assert inconsistency.size == pytest.approx(change, abs=3 * inconsistency.size_error)
    assert inconsistency.size_error < 0.05 * abs(change)
    # to first order in the change; 1e-6 of 750 Hz is a millihertz, and 0.02 bandwidths are up to 0.08 Hz
    np.testing.assert_allclose(inconsistency.still_frequency, plain_beam.frequencies[:, 0], rtol=3e-4)


def test_a_stiffness_that_falls_during_a_roving_test_is_named_from_its_records() -> None:
    setup = rig(*range(1, 22, 2), noise=Noise(1e-2, 1e-5), accelerometers=Accelerometers(0.0, roving=True))
    warming = (Drift(change=-0.01),)
    records = measure(steel_beam(), setup, warming, route=Route.SAMPLED, rng=np.random.default_rng(0))
    model = extract(records.frf, coherence=records.coherence, averages=records.averages)
    inconsistency = model.frequency_inconsistency
    assert inconsistency is not None
    assert inconsistency.cause is InconsistencyCause.STEADY_DRIFT
    # frequencies go with the root of the stiffness; to first order in 1 % of it
    assert inconsistency.size == pytest.approx(np.sqrt(0.99) - 1, rel=0.01)
    exact = beam_system().modes().elastic(8).frequencies  # before it warms
    np.testing.assert_allclose(inconsistency.still_frequency, exact, rtol=2e-4)
    assert any("all modes drift by -0.50" in note for note in model.notes)


def test_changes_without_a_pattern_are_named_unknown(plain_beam: Beam) -> None:
    modes = fitted(plain_beam, seed=4)
    rng = np.random.default_rng(5)
    shaken = replace(modes, frequency=modes.frequency * (1 + 1e-3 * rng.standard_normal((8, 11))))
    inconsistency = find_frequency_inconsistency(shaken)
    assert inconsistency is not None
    assert (inconsistency.cause, inconsistency.explained, inconsistency.size) == (
        InconsistencyCause.UNKNOWN,
        0.0,
        0.0,
    )
    np.testing.assert_allclose(inconsistency.still_frequency, modes_mean(shaken))


def modes_mean(modes: FittedModes) -> FloatArray:
    return np.asarray(modes.frequency.mean(axis=1))


def test_one_frf_of_its_own_is_no_wander(plain_beam: Beam) -> None:
    modes = fitted(plain_beam, seed=6)
    frequency = modes.frequency.copy()
    frequency[2, 4] += 0.5  # Hz, 30 standard errors
    assert find_frequency_inconsistency(replace(modes, frequency=frequency)) is None


def test_agreement_beyond_what_a_single_mode_fit_can_give_is_not_asked_for(plain_beam: Beam) -> None:
    modes = fitted(plain_beam, seed=7, noise=1e-4)
    stated = replace(modes, frequency_error=1e-6 * modes.frequency_error)
    assert find_frequency_inconsistency(stated) is None


def test_fits_that_do_not_count_have_no_shift(roving_beam: Beam) -> None:
    modes = fitted(roving_beam)
    good = modes.good.copy()
    good[0, 3] = False
    wild = modes.frequency.copy()
    wild[0, 3] = np.nan
    inconsistency = find_frequency_inconsistency(replace(modes, good=good, frequency=wild))
    assert inconsistency is not None
    assert np.isnan(inconsistency.shift[0, 3])
    assert np.isfinite(np.delete(inconsistency.shift[0], 3)).all()
    assert inconsistency.degrees[0] == 9


def test_nothing_to_compare_is_no_wander() -> None:
    none = np.zeros((0, 3))
    assert (
        find_frequency_inconsistency(
            FittedModes(none, none, none, none > 0, none.astype(complex), none, True)
        )
        is None
    )
    one = np.ones((2, 1))
    assert (
        find_frequency_inconsistency(FittedModes(one, one, one, one > 0, one.astype(complex), one, True))
        is None
    )
