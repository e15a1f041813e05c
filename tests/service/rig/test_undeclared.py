"""Rigs that state absolute noise, a band of the source, or leave levels unknown."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Noise, NoiseDensity
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, steel_beam

RESPONSES = tuple(Dof.parse(f"{node}:+Y") for node in (1, 7))
RNG = np.random.default_rng(3)


def setup(noise: Noise | None = None, **excitation: object) -> RigSetup:
    analyser = Analyser(400.0, 201, averages=40, excitation=ExcitationSetting(**excitation))  # type: ignore[arg-type]
    return RigSetup(RESPONSES[:1], RESPONSES, analyser=analyser, noise=noise or Noise())


def measured(rig: RigSetup, route: Route) -> Measurement:
    return measure(steel_beam(), rig, route=route, rng=np.random.default_rng(1))


def test_noise_by_density_adds_itself_to_the_spectra_of_its_channels() -> None:
    density = NoiseDensity({"1:+Y": 3e-3, "7:+Y": 5e-3})
    noisy = expected_spectra(chain(beam_system(), setup(Noise(NoiseDensity(1e-4), density))))
    clean = expected_spectra(chain(beam_system(), setup()))
    np.testing.assert_allclose((noisy.ff - clean.ff)[0, :, 0, 0].real, 1e-4, rtol=1e-9)
    # differences of spectra up to 1e5 times as large
    np.testing.assert_allclose((noisy.xx - clean.xx)[0] / [3e-3, 5e-3], 1.0, rtol=1e-6)


def test_time_records_have_the_declared_density() -> None:
    level = NoiseDensity(2e-3)
    noisy = measured(setup(Noise(0.0, level)), Route.SAMPLED)
    assert noisy.response_spectrum is not None
    assert noisy.coherence is not None
    incoherent = (noisy.response_spectrum * (1 - noisy.coherence))[1:]
    # H1 of 40 averages takes one of them out; 400 values of 39 averages each scatter by 0.8 %
    assert incoherent.mean() * 40 / 39 == pytest.approx(2e-3, rel=0.03)


@pytest.mark.parametrize("kind", ["periodic_random", "random", "pseudo_random"])
@pytest.mark.parametrize("route", [Route.EXPECTED, Route.SAMPLED])
def test_a_source_drives_its_band_at_its_level_and_nothing_else(kind: str, route: Route) -> None:
    rig = setup(kind=kind, level=3.0, band=(100.0, 300.0))
    rig = replace(rig, analyser=replace(rig.analyser, window="hann" if kind == "random" else "rectangular"))
    test = measured(rig, route)
    assert test.force_spectrum is not None
    force, freq = test.force_spectrum[:, 0, 0], test.frf.freq
    inside = (freq > 104) & (freq < 296)  # a Hann window mixes two lines on either side
    # 97 lines of 40 averages scatter by 1.6 %
    assert force[inside].mean() == pytest.approx(9.0 / 200.0, rel=0.06)
    # the side lobes of the Hann window 8 lines off, and of what is clipped by rounding, are below 1e-4
    assert force[(freq < 84) | (freq > 316)].max() < 1e-4 * 9.0 / 200.0


def test_a_source_without_a_level_is_simulated_with_one_newton() -> None:
    unknown = setup(level=None, shape="unknown")
    unknown = replace(unknown, noise=Noise(None, None), analyser=replace(unknown.analyser, averages=None))
    test = measured(unknown, Route.EXPECTED)
    ideal = measured(setup(), Route.EXPECTED)
    np.testing.assert_array_equal(test.frf.values, ideal.frf.values)
    assert test.averages == 100
    assert test.setup.noise == Noise(None, None)


def test_a_transient_in_a_band_is_refused() -> None:
    with pytest.raises(InvalidInputError) as caught:
        measured(setup(kind="burst_random", band=(100.0, 300.0)), Route.EXPECTED)
    assert caught.value.context["field"] == "excitation.band"


def test_noise_by_channel_names_every_channel() -> None:
    rig = setup(Noise(0.0, NoiseDensity({"1:+Y": 1e-3})))
    with pytest.raises(InvalidInputError) as caught:
        rig.check_noise_channels()
    assert caught.value.context["field"] == "noise.response.psd"


def test_a_line_outside_the_band_by_less_than_its_spacing_is_not_driven() -> None:
    rig = setup(band=(101.0, 299.0))  # lines 2 Hz apart
    assert rig.analyser.driven_lines == (51, 149)
    assert setup(band=(102.0, 298.0)).analyser.driven_lines == (51, 149)
