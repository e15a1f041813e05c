"""Random errors where coherence tells them, and where they have to be stated."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.predicting.limitations import limitations
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.channel_spectra import ChannelSpectra
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.random_error import shared_noise
from modallab.diagnosis.residuals.residual import gap_errors
from modallab.effects.force_noise import ForceNoise
from modallab.effects.stiffness_error import StiffnessError
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from tests.diagnosing import draw_measurement, exact, model, predicting, rig

FLOOR = 0.02


def scattered(seed: int) -> Measurement:
    """Return FRFs with a relative error of their own and nothing that tells of it."""
    measurement = exact(rig(noise=0.0))
    rng = np.random.default_rng(seed)
    values = measurement.frf.values
    error = FLOOR * rng.standard_normal((*values.shape, 2)).view(complex)[..., 0]
    error *= np.maximum(1.0, np.median(np.abs(values), axis=0) / np.maximum(np.abs(values), 1e-9))
    return replace(
        measurement,
        frf=replace(measurement.frf, values=values * (1 + error)),
        coherence=None,
        force_spectrum=None,
        response_spectrum=None,
        noise_floor=FLOOR,
    )


def test_a_stated_error_weighs_frfs_without_coherence() -> None:
    predictor, observed = predicting(scattered(1))
    left = predictor.residual(())
    assert set(left.parts) == {"frf"}
    # 160 lines of 6 channels: 3 % of complex squares; four of these
    assert left.gap(observed.usable) == pytest.approx(1.0, abs=0.13)
    assert gap_errors(observed, left, observed.usable)["frf"] == pytest.approx(1 / np.sqrt(960), rel=0.1)


def test_an_effect_is_found_by_a_stated_error() -> None:
    hidden = StiffnessError(factor=1.03)
    test = exact(rig(noise=0.0), [hidden])
    bare = replace(test, coherence=None, force_spectrum=None, response_spectrum=None, noise_floor=FLOOR)
    found = diagnose(model(), bare, suspects=["stiffness_error"])
    assert (found.steps[0].effect.kind, found.steps[0].effect.at) == ("stiffness_error", None)
    factor = found.steps[0].effect.parameters["factor"]
    assert abs(factor.value - 1.03) < factor.standard_error  # the test itself has no error
    assert any("no usable coherence" in note for note in found.notes)


def test_a_stated_error_adds_to_the_one_that_coherence_tells() -> None:
    measurement = draw_measurement(rig(noise=1e-3))
    plain, wider = (
        observe(replace(measurement, noise_floor=floor), (), fraction=0.0) for floor in (None, FLOOR)
    )
    size = np.abs(measurement.frf.values[1:, :, 0])
    stated = FLOOR * np.maximum(1.0, np.median(np.abs(measurement.frf.values[..., 0]), axis=0) / size)
    np.testing.assert_allclose(wider.error[1:] ** 2, plain.error[1:] ** 2 + stated**2, rtol=1e-9)  # rounding
    # power has twice the relative error that amplitude has
    assert wider.incoherent_variance is not None
    assert plain.incoherent_variance is not None
    np.testing.assert_allclose(wider.incoherent_variance - plain.incoherent_variance, 4 * FLOOR**2, rtol=1e-9)
    np.testing.assert_allclose(
        np.asarray(wider.force_variance) - plain.force_variance, 4 * FLOOR**2, rtol=1e-9
    )


@pytest.mark.parametrize("floor", [0.0, -1.0, 2.0, float("nan")])
def test_a_noise_floor_out_of_bounds_is_refused(floor: float) -> None:
    with pytest.raises(InvalidInputError) as refused:
        replace(exact(rig()), noise_floor=floor)
    assert refused.value.context["field"] == "noise_floor"


def test_what_a_test_cannot_tell_is_said() -> None:
    measurement = draw_measurement(rig(noise=1e-3))
    observed = observe(measurement, (), fraction=0.0)
    assert limitations(measurement, observed) == ()
    bare = replace(measurement, coherence=None, force_spectrum=None, response_spectrum=None, noise_floor=0.01)
    said = " ".join(limitations(bare, observe(bare, (), fraction=0.25)))
    for words in ("no force spectrum", "no response spectra", "no usable coherence", "lines are held out"):
        assert words in said
    few = replace(measurement, averages=5.0)
    assert "5 averages" in " ".join(limitations(few, observed))


def test_lines_of_low_coherence_are_counted() -> None:
    measurement = draw_measurement(rig(noise=0.3))
    observed = observe(measurement, (), fraction=0.0)
    assert observed.coherence.min() < 0.3
    assert any("coherence below 0.3" in note for note in limitations(measurement, observed))
    # and are weighed: with nothing missing the gap is 1
    left = SingleTestPredictor.of(model(), measurement.setup, observed).residual(())
    error = gap_errors(observed, left, observed.usable)["frf"]
    assert (
        abs(left.gaps(observed.usable)["frf"] - 1) < 4 * error + 0.01
    )  # where logarithm and difference meet


@pytest.mark.parametrize("noise", [0.0, 1e-14, 1e-4])
@pytest.mark.parametrize("kind", ["periodic_random", "random"])
def test_the_share_of_the_force_is_a_number_with_any_noise_or_none(noise: float, kind: str) -> None:
    window = "hann" if kind == "random" else "rectangular"
    setup = rig(roving=False, noise=noise, kind=kind, window=window)
    test = measure(model(), setup, [], route=Route.SAMPLED, rng=np.random.default_rng(0))
    share = shared_noise(ChannelSpectra.of(test))
    if noise == 0 and kind == "periodic_random":
        assert share is None
    elif noise == 1e-4:
        assert share is not None
    if share is not None:
        assert (np.isfinite(share) & (share >= 0) & (share < 1)).all()


def test_a_line_that_came_out_large_by_chance_weighs_no_more() -> None:
    more = ForceNoise(ratio=0.01)
    test = measure(model(), rig(roving=False), [more], route=Route.SAMPLED, rng=np.random.default_rng(0))
    assert test.coherence is not None
    line = (
        int(np.abs(test.coherence[1:] - 0.98).sum(axis=1).argmin()) + 1
    )  # neither all noise nor next to none
    louder = test.coherence.copy()
    louder[line] = 1 - 1.3 * (1 - louder[line])  # three random errors of 100 averages
    plain, loud = (
        shared_noise(ChannelSpectra.of(replace(test, coherence=own))) for own in (test.coherence, louder)
    )
    assert plain is not None
    assert loud is not None
    # both noises are estimated from all 160 lines, of which one is 30 % louder
    np.testing.assert_allclose(loud[line], plain[line], rtol=0.3 / 160)
