"""Measured responses and their random errors."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.fe.assembly import assemble
from modallab.rig.analyser import Analyser
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Accelerometers, Noise
from modallab.rig.measure import measurement_of
from modallab.rig.setup import RigSetup
from modallab.rig.wishart import wishart_spectra
from modallab.updating.responses.settings import RESPONSE_ERRORS
from modallab.updating.responses.target import target_responses
from tests.service.updating.responses.cases import AVERAGES, BEAM, BEAM_LINES, BEAM_SENSORS, measured

FRF = measured(BEAM, BEAM_LINES[:20], BEAM_SENSORS)
FULL = np.ones(FRF.values.shape[:2])


def test_coherence_says_how_large_random_errors_are() -> None:
    target = target_responses(FRF, 0.9 * FULL, AVERAGES)
    np.testing.assert_allclose(target.errors, np.sqrt(0.1 / (2 * 0.9 * 98)), rtol=1e-6)
    assert target.n_numbers == 2 * FRF.values.size


def test_a_full_coherence_leaves_the_error_of_the_model_itself() -> None:
    np.testing.assert_allclose(target_responses(FRF, FULL, AVERAGES).errors, RESPONSE_ERRORS.model_error)


def test_a_stated_error_is_of_the_median_where_a_structure_hardly_moves() -> None:
    target = target_responses(FRF, None, 1.0, 0.01)
    size = np.abs(FRF.values)
    strong = size >= np.median(size, axis=0)
    np.testing.assert_allclose(target.errors[strong], 0.01, rtol=1e-6)
    np.testing.assert_allclose(
        (target.errors * size)[~strong].min(), 0.01 * np.median(size, axis=0).min(), rtol=0.5
    )
    assert (target.errors[~strong] > 0.01).all()


def test_inertance_becomes_receptance_and_the_line_at_zero_goes() -> None:
    lines = np.concatenate([[0.0], FRF.freq])
    values = np.concatenate([FRF.values[:1], FRF.to(FrfKind.INERTANCE).values])
    other = replace(FRF, freq=lines, values=values, kind=FrfKind.INERTANCE)
    target = target_responses(other, np.ones(values.shape[:2]), AVERAGES)
    np.testing.assert_array_equal(target.freq, FRF.freq)
    np.testing.assert_allclose(target.values, FRF.values, rtol=1e-12)


def test_dead_channels_and_vague_lines_say_nothing() -> None:
    values, coherence = FRF.values.copy(), 0.9 * FULL
    values[:, 2] = 0.0
    values[:, 3] = 1e-200  # its square is none
    coherence[5, :] = 0.001
    used = target_responses(replace(FRF, values=values), coherence, AVERAGES).used
    assert not used[:, 2:4].any()
    assert not used[5].any()
    assert used.sum() == (len(FRF.freq) - 1) * (len(BEAM_SENSORS) - 2)


@pytest.mark.parametrize(("coherence", "averages"), [(None, AVERAGES), (FULL, 2.0)])
def test_without_coherence_or_averages_an_error_must_be_stated(coherence: object, averages: float) -> None:
    with pytest.raises(InvalidInputError, match="noise floor"):
        target_responses(FRF, coherence, averages)  # type: ignore[arg-type]


def test_what_is_common_to_all_outputs_is_known_apart_from_chance() -> None:
    common = np.full(FRF.values.shape, 1e-4)
    target = target_responses(FRF, 0.9 * FULL, AVERAGES, 0.01, common)
    assert (target.errors > np.sqrt(0.1 / (2 * 0.9 * 98))).all()
    np.testing.assert_allclose(target.common * target.errors**2, 1e-4)
    # by chance coherence may tell less than that: what each has of its own must count
    target = target_responses(FRF, FULL, AVERAGES, None, common)
    np.testing.assert_allclose(target.errors**2 * 0.95, 1e-4)


def test_sizes_weighted_by_what_coherence_tells_have_no_bias() -> None:
    rng, n, n_tests, noise = np.random.default_rng(0), 20, 100_000, 0.2
    force, own = (rng.standard_normal((n_tests, n, 2)).view(complex)[..., 0] for _ in range(2))
    response = force + np.sqrt(noise) * own
    ff, xx = (np.abs(force) ** 2).mean(axis=1), (np.abs(response) ** 2).mean(axis=1)
    fx = (force.conj() * response).mean(axis=1)
    frf = replace(
        FRF, freq=np.arange(1.0, n_tests + 1), values=(fx / ff)[:, None, None], outputs=FRF.outputs[:1]
    )
    target = target_responses(frf, (np.abs(fx) ** 2 / (ff * xx))[:, None], n)
    sizes, raw = (np.log(np.abs(one[:, 0, 0])) for one in (target.values, frf.values))
    weight = target.errors[:, 0, 0] ** -2
    error = float(np.sqrt(noise / (2 * n)) / np.sqrt(n_tests))
    # four random errors of the mean, and what is left of third order in the noise
    assert abs(np.average(sizes, weights=weight)) < 4 * error + noise**1.5 / n**1.5
    assert np.average(raw, weights=weight) > 20 * error


def test_responses_of_nothing_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="no response says anything"):
        target_responses(FRF, 0.0 * FULL, AVERAGES)


def test_chosen_lines_span_the_band_and_hold_no_more_than_asked() -> None:
    target = target_responses(FRF, FULL, AVERAGES)
    lines = target.evenly_spaced(5 * 2 * len(BEAM_SENSORS))
    assert (lines[0], lines[-1], len(lines)) == (0, 19, 5)
    assert target.at(lines).n_numbers == 5 * 2 * len(BEAM_SENSORS)


def test_errors_of_frfs_to_simultaneous_shakers_are_those_that_repeated_tests_show() -> None:
    setup = RigSetup(
        (Dof(1, "Y"), Dof(16, "Y")),
        (Dof(1, "Y"), Dof(7, "Y"), Dof(16, "Y")),
        accelerometers=Accelerometers(roving=False),
        noise=Noise(0.0, 1e-2),
        analyser=Analyser(400.0, 41, averages=12),
    )
    expected = expected_spectra(chain(assemble(BEAM), setup))
    targets = []
    for seed in range(100):
        test = measurement_of(wishart_spectra(expected, np.random.default_rng(seed)), setup)
        assert test.coherence is not None
        targets.append(target_responses(test.frf, test.coherence, test.averages))
    sizes = np.maximum([np.abs(target.values) for target in targets], 1e-300)  # an antiresonance may be 0
    scatter = np.std(np.log(sizes), axis=0)
    stated = np.sqrt(np.mean([target.errors**2 for target in targets], axis=0))
    told = stated < 0.1  # of lines that nearly vanish the logarithm has no variance of first order
    ratio = (scatter / stated)[told]
    # 100 tests tell a standard deviation to 7 %; forces of unequal power at the points cost some more
    assert np.median(ratio) == pytest.approx(1.0, abs=0.1)
    assert (np.abs(np.log(ratio)) < np.log(1.4)).mean() > 0.95
