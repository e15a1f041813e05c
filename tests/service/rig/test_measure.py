"""The one way to a measurement."""

from dataclasses import fields, replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnknownDofError
from modallab.core.frf import FrfKind
from modallab.effects.extra_mass import ExtraMass
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from tests.rigs import beam_system, rig, steel_beam

ROVING = rig(
    *range(1, 22, 2),
    exciter=Exciter(armature_mass=0.02),
    force_transducer=ForceTransducer(0.01),
    accelerometers=Accelerometers(0.02, roving=True),
    noise=Noise(1e-2, 1e-5),
)
FIXED = replace(ROVING, accelerometers=Accelerometers(0.02))


def measured(route: Route, *effects: Effect, seed: int = 1, setup: object = ROVING) -> Measurement:
    assert setup in (ROVING, FIXED)
    bench = ROVING if setup is ROVING else FIXED
    return measure(steel_beam(), bench, effects, route=route, rng=np.random.default_rng(seed))


@pytest.mark.parametrize("route", Route)
@pytest.mark.parametrize("setup", [ROVING, FIXED])
def test_every_route_gives_every_response_its_frf_coherence_and_spectra(route: Route, setup: object) -> None:
    test = measured(route, setup=setup)
    assert test.frf.values.shape == (401, 11, 1)
    assert test.frf.kind is FrfKind.INERTANCE
    assert test.frf.outputs == ROVING.responses
    assert test.frf.inputs == (ROVING.drive,)
    assert test.coherence is not None
    assert test.force_spectrum is not None
    assert test.response_spectrum is not None
    # what the auto spectra and the FRF say of coherence is the coherence: gamma^2 = |H1|^2 G_ff/G_xx
    by_spectra = np.abs(test.frf.values) ** 2 * test.force_spectrum / test.response_spectrum[..., None]
    np.testing.assert_allclose(by_spectra[..., 0], test.coherence, rtol=1e-9)  # rounding


def test_runs_of_a_roving_accelerometer_are_put_side_by_side_in_order() -> None:
    roving = measured(Route.EXPECTED)
    for place in (0, 4, 10):
        alone = replace(ROVING, responses=(ROVING.responses[place],))
        one = measure(steel_beam(), alone, route=Route.EXPECTED, rng=np.random.default_rng(1))
        # rounding
        np.testing.assert_allclose(one.frf.values[:, 0], roving.frf.values[:, place], rtol=1e-12)


def test_only_drawn_and_sampled_measurements_depend_on_the_seed() -> None:
    for route in Route:
        a, b, c = (measured(route, seed=seed).frf.values.tobytes() for seed in (1, 1, 2))
        assert a == b
        assert (a == c) is (route is Route.EXPECTED)


@pytest.mark.parametrize("route", Route)
def test_a_route_goes_by_its_name_as_well(route: Route) -> None:
    named = measured(str(route))  # type: ignore[arg-type]
    assert np.array_equal(named.frf.values, measured(route).frf.values)


@pytest.mark.parametrize("route", Route)
def test_a_measurement_says_nothing_of_the_truth(route: Route) -> None:
    hidden = measured(route, ExtraMass(at=Dof(7, "Y"), mass=0.05))
    assert hidden.setup == ROVING, "the log book as declared"
    for field in fields(hidden):
        value = getattr(hidden, field.name)
        assert "extra_mass" not in repr(value)
    assert hidden.averages == measured(route).averages


def test_transducers_lower_every_mode_by_their_share_of_the_mass() -> None:
    loaded = chain(beam_system(), replace(ROVING, exciter=Exciter())).poles()[0][:, :8].mean(axis=0)
    bare = chain(beam_system(), rig(1)).poles()[0][0, :8]
    assert (loaded < bare).all()
    assert (loaded > 0.97 * bare).all()  # 30 g on 5.85 kg, at an end four times their share


def test_a_rig_that_listens_beside_the_structure_is_refused() -> None:
    with pytest.raises(UnknownDofError):
        measure(STRUCTURES["bay"](), rig(1, 999), route=Route.EXPECTED, rng=np.random.default_rng(1))


@pytest.mark.parametrize(
    ("name", "wrong"),
    [("coherence", np.full((401, 11), 1.5)), ("coherence", np.ones((3, 11))), ("averages", 0.0)],
)
def test_a_measurement_that_cannot_be_is_refused_by_name(name: str, wrong: object) -> None:
    with pytest.raises(InvalidInputError) as caught:
        replace(measured(Route.EXPECTED), **{name: wrong})  # type: ignore[arg-type]
    assert caught.value.context["field"] == name
