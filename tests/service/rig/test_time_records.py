"""Time records that a measurement keeps are those that its spectra were made of."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.effects.overload import Overload
from modallab.estimation.averaging import Averager
from modallab.estimation.coherence import coherence
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.time_records import TimeRecords
from tests.rigs import dofs, rig, steel_beam

SMALL = {"frequency_max": 200.0, "n_lines": 101, "averages": 20}


def measured(setup: object, records: int = 20, *effects: object, seed: int = 1) -> Measurement:
    rng = np.random.default_rng(seed)
    return measure(steel_beam(), setup, effects, rng=rng, records=records)  # type: ignore[arg-type]


def kept(measurement: Measurement) -> TimeRecords:
    assert measurement.records is not None
    return measurement.records


@pytest.mark.parametrize(
    ("excitation", "window"),
    [
        ("random", "hann"),
        ("periodic_random", "rectangular"),
        ("burst_random", "rectangular"),
        ("chirp", "rectangular"),
    ],
)
@pytest.mark.parametrize("estimator", ["h1", "h2", "hv"])
def test_an_estimator_makes_the_measured_frf_of_the_records(
    excitation: str, window: str, estimator: str
) -> None:
    analyser = SMALL | {"window": window, "estimator": estimator}
    setup = rig(1, 7, excitation=excitation, noise=Noise(1e-2, 1e-2), analyser=analyser)
    test = measured(setup)
    records, line_window = kept(test), setup.analyser.line_window
    samples = np.concatenate([records.force, records.response], axis=-1)[:, :, 0].swapaxes(1, 2)
    averager = Averager(line_window, samples.shape[1:], records.sample_rate, n_lines=101, n_in=1)
    averager.add(samples)
    ff, fx, xx = averager.densities()
    spectra = CrossSpectra(test.frf.freq, ff[None], fx[None], xx[None], 20.0)
    # the same sums in another order; rounding
    np.testing.assert_allclose(ESTIMATORS[estimator](spectra)[0], test.frf.values, rtol=1e-9)
    assert test.coherence is not None
    np.testing.assert_allclose(coherence(spectra)[0], test.coherence, rtol=1e-9)


def test_numpy_alone_makes_the_measured_frf_of_the_records() -> None:
    test = measured(rig(1, 7, analyser=SMALL, noise=Noise(1e-2, 1e-2)))
    records = kept(test)
    force, response = np.fft.rfft(records.force[:, :, 0, 0]), np.fft.rfft(records.response[:, :, 0, 1])
    h1 = (force.conj() * response).mean(axis=0) / (np.abs(force) ** 2).mean(axis=0)
    np.testing.assert_allclose(h1[:101], test.frf.values[:, 1, 0], rtol=1e-9)  # rounding


def test_the_mean_square_of_the_records_is_the_area_of_the_auto_spectrum() -> None:
    """Parseval; without noise, and so without power beyond the last line."""
    test = measured(rig(1, 7, analyser=SMALL))
    records, spacing = kept(test), 2.0
    pairs = [
        (records.force[..., 0, 0], test.force_spectrum[:, 0, 0]),  # type: ignore[index]
        (records.response[..., 0, 1], test.response_spectrum[:, 1]),  # type: ignore[index]
    ]
    for samples, spectrum in pairs:
        # at 0 Hz the density is twice the power: it has no line of negative frequency beside it
        area = (spectrum.sum() - spectrum[0] / 2) * spacing
        np.testing.assert_allclose((samples**2).mean(), area, rtol=1e-9)  # rounding


def test_records_change_nothing_of_the_measurement() -> None:
    setup = rig(1, 7, excitation="random", analyser=SMALL | {"window": "hann", "overlap": 0.5})
    with_records, without = measured(setup, 7), measured(setup, 0)
    assert without.records is None
    assert kept(with_records).force.shape[0] == 7
    np.testing.assert_array_equal(with_records.frf.values, without.frf.values)
    np.testing.assert_array_equal(kept(with_records).force, kept(measured(setup, 20)).force[:7])


def test_records_that_overlap_share_their_samples() -> None:
    records = kept(measured(rig(1, excitation="random", analyser=SMALL | {"window": "hann", "overlap": 0.5})))
    half = records.force.shape[1] // 2
    np.testing.assert_array_equal(records.force[1, :half], records.force[0, half:])


def test_what_the_converter_clips_is_clipped_in_the_records() -> None:
    records = kept(measured(rig(1, 7, analyser=SMALL), 20, Overload(None, level=2.0)))
    response = records.response[..., 0, 1]
    # 2 rms of the expected signal; 20 records of it scatter by some percent
    assert np.abs(response).max() == pytest.approx(2 * response.std(), rel=0.2)
    assert (np.abs(response) == np.abs(response).max()).sum() > 10  # many samples stand at the limit


def test_every_run_of_a_roving_accelerometer_has_its_force() -> None:
    setup = rig(1, 7, 13, accelerometers=Accelerometers(mass=0.02, roving=True), analyser=SMALL)
    test = measured(setup)
    records = kept(test)
    assert records.force.shape[2:] == (3, 1)
    assert records.response.shape[2:] == (3, 1)
    force, response = (
        np.fft.rfft(records.force[..., 0], axis=1),
        np.fft.rfft(records.response[..., 0], axis=1),
    )
    h1 = (force.conj() * response).mean(axis=0) / (np.abs(force) ** 2).mean(axis=0)
    np.testing.assert_allclose(h1[:101], test.frf.values[:, :, 0], rtol=1e-9)  # rounding


def test_every_run_of_a_roving_hammer_has_its_force() -> None:
    setup = rig(1, exciter=Exciter("hammer"), excitation="impact", analyser=SMALL)
    test = measured(replace(setup, drives=dofs(1, 7)))
    force, response = (
        np.fft.rfft(kept(test).force[..., 0], axis=1),
        np.fft.rfft(kept(test).response[..., 0], axis=1),
    )
    h1 = (force.conj() * response).mean(axis=0) / (np.abs(force) ** 2).mean(axis=0)
    np.testing.assert_allclose(h1[:101], test.frf.values[:, 0], rtol=1e-9)  # rounding


@pytest.mark.parametrize("route", [Route.EXPECTED, Route.DRAWN])
def test_a_route_without_records_keeps_none(route: Route) -> None:
    with pytest.raises(InvalidInputError, match="only the route sampled has time records"):
        measure(steel_beam(), rig(1, analyser=SMALL), route=route, rng=np.random.default_rng(1), records=3)


def test_more_records_than_averages_are_refused() -> None:
    with pytest.raises(InvalidInputError) as caught:
        measured(rig(1, analyser=SMALL), 21)
    assert caught.value.context["allowed"] == {"minimum": 0, "maximum": 20}


def test_records_of_more_samples_than_the_limit_are_refused() -> None:
    analyser = {"frequency_max": 800.0, "n_lines": 6401, "averages": 400}
    with pytest.raises(InvalidInputError, match="can be kept") as caught:
        measured(rig(*range(1, 22), analyser=analyser), 400)
    largest = caught.value.context["allowed"]["maximum"]
    assert 22 * largest * 2 * 6400 <= 2**21  # samples are at least twice the lines
