from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

import modallab.diagnosis.searching.shortlist as module
from modallab.core.dof import Dof
from modallab.core.place import Channels
from modallab.core.progress import silent
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.searching.modification_screen import ModificationScreen
from modallab.diagnosis.searching.scan_settings import SHORTLIST
from modallab.diagnosis.searching.shortlist import ListedPlace, shortlist
from modallab.diagnosis.searching.starting_values import scan_sizes
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.friction import Friction
from modallab.effects.ground_spring import GroundSpring
from modallab.effects.local_damping import LocalDamping
from modallab.effects.mounted_resonance import MountedResonance
from modallab.effects.stinger_axial import StingerAxial
from modallab.rig.effect import Effect
from tests.diagnosing import draw_measurement, predicting, rig

NODES = range(1, 10)


def looking_for(hidden: Effect, *, roving: bool = False) -> CoarsePrediction:
    predictor, _ = predicting(draw_measurement(rig(roving=roving), [hidden]))
    return predictor.coarse_prediction([])


def places_of(found: Sequence[ListedPlace], kind: str) -> list[object]:
    return [place.sizes[0].at for place in found if place.sizes[0].kind == kind]


def test_places_are_told_apart_by_a_sample_of_lines_as_well(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    coarse = looking_for(ExtraMass(Dof(6, "Y"), 0.1))
    suspects = [ExtraMass(Dof(n, "Y")) for n in NODES]
    size = int(coarse.observed.fitted.sum()) // 5
    monkeypatch.setattr(module, "SHORTLIST", replace(SHORTLIST, sample_size=size))
    found = places_of(shortlist(coarse, [], suspects, silent), "extra_mass")
    assert Dof(6, "Y") in found
    assert SHORTLIST.max_places <= len(found) < len(suspects)


@pytest.mark.parametrize("mass", [0.05, 0.06, 0.07])
def test_an_amount_between_those_of_the_grid_is_listed_at_the_right_place(mass: float) -> None:
    # The grid has steps of a factor of 1.78; the last amounts that are tried are 2.5 % apart.
    prediction = looking_for(ExtraMass(Dof(6, "Y"), mass))
    found = shortlist(prediction, [], [ExtraMass(Dof(n, "Y")) for n in NODES], silent)
    amounts = [
        effect.parameters["mass"] for place in found for effect in place.sizes if effect.at == Dof(6, "Y")
    ]
    assert min(abs(amount / mass - 1) for amount in amounts) < 0.025


def test_of_a_kind_that_is_of_no_use_one_place_is_listed() -> None:
    # More mass raises no frequency: a spring to the ground makes predictions worse at every node.
    prediction = looking_for(ExtraMass(Dof(6, "Y"), 0.1))
    found = shortlist(prediction, [], [GroundSpring(Dof(n, "Y")) for n in NODES], silent)
    assert len(found) <= 3  # at most one at each noise inflation


def test_a_sample_has_every_line_and_every_channel() -> None:
    coarse = looking_for(ExtraMass(Dof(6, "Y"), 0.1))
    whole, sample = coarse.observed.fitted, coarse.subsampled(3).observed.fitted
    assert not (sample & ~whole).any()
    assert (sample.any(axis=0) == whole.any(axis=0)).all()
    assert (sample.any(axis=1) == whole.any(axis=1)).all()
    assert abs(sample.sum() / whole.sum() - 1 / 3) < 0.05  # lines are no multiple of three


@pytest.mark.parametrize("every", [1, 3], ids=["all lines", "a sample"])
@pytest.mark.parametrize("noise", [1e-4, 3e-2], ids=["little noise", "much noise"])
def test_residuals_without_an_effect_are_those_of_the_prediction(every: int, noise: float) -> None:
    # Noise that the channels of a run share is taken once, and large errors go without a logarithm.
    predictor, _ = predicting(draw_measurement(rig(roving=False, noise=noise)))
    sample = predictor.coarse_prediction([]).subsampled(every)
    screen = ModificationScreen(sample, [])
    nothing = np.ones((1, int(sample.observed.fitted.sum())), complex)
    np.testing.assert_allclose(screen.vectors(nothing)[0], screen.unmodified, rtol=1e-9, atol=1e-9)


def test_a_nonlinear_force_is_looked_for_at_few_places_the_right_one_among_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # What has no closed form is predicted once a place: here a spring and a dashpot.
    monkeypatch.setattr(module, "_screened", lambda *_: None)
    for hidden in (GroundSpring(Dof(7, "Y"), 3e4), LocalDamping(Dof(3, "Y"), 20.0)):
        suspects = [replace(type(hidden)(), at=Dof(n, "Y")) for n in NODES]
        found = places_of(shortlist(looking_for(hidden), [], suspects, silent), hidden.kind)
        assert hidden.at in found
        assert SHORTLIST.max_nonlinear_places <= len(found) <= 3 * SHORTLIST.max_nonlinear_places


@pytest.mark.parametrize("share", [1e-4, 4e-4, 1e-2], ids=["weakest", "between", "strong"])
@pytest.mark.parametrize("node", [1, 2, 9])
def test_a_nonlinear_force_of_any_strength_is_looked_for_where_it_is(node: int, share: float) -> None:
    # 1 is as stiff as all that the DoF feels: what explains a weak one is hidden by what a strong one does.
    bare = CubicStiffness(Dof(node, "Y"))
    setup = rig(roving=False, noise=1e-3)
    predictor, _ = predicting(draw_measurement(setup))
    whole = max(bare.scan_values(predictor.system, setup)["stiffness"])
    suspects = [CubicStiffness(Dof(n, "Y")) for n in (1, 2, 4, 5, 7, 9)]
    predictor, _ = predicting(draw_measurement(setup, [replace(bare, stiffness=share * whole)]))
    assert bare.at in places_of(shortlist(predictor.coarse_prediction([]), [], suspects, silent), bare.kind)


@pytest.mark.parametrize("hidden", [CubicStiffness(Dof(6, "Y")), Friction(Dof(6, "Y"))], ids=lambda e: e.kind)
def test_measured_places_of_a_nonlinear_force_are_predicted_and_others_by_its_linearisation(
    hidden: CubicStiffness | Friction, monkeypatch: pytest.MonkeyPatch
) -> None:
    setup = rig(roving=False, noise=1e-3)
    predictor, _ = predicting(draw_measurement(setup))
    amount, sizes = next(iter(hidden.scan_values(predictor.system, setup).items()))
    hidden = hidden.with_parameters({amount: sizes[len(sizes) // 2]})
    predictor, _ = predicting(draw_measurement(setup, [hidden]))
    predicted: list[list[Effect]] = []

    def likely(_prediction: object, _accepted: object, places: list[list[Effect]]) -> list[list[Effect]]:
        predicted.extend(places)
        return places

    monkeypatch.setattr(module, "_likely", likely)
    suspects = [replace(hidden, at=place) for place in type(hidden).places(predictor.system, setup)]
    found = places_of(shortlist(predictor.coarse_prediction([]), [], suspects, silent), hidden.kind)
    assert hidden.at in found
    measured = {dof.point for dof in setup.responses}
    unmeasured = [sizes for sizes in predicted if sizes[0].at not in measured]
    assert len(predicted) == len(measured) + len(unmeasured)
    assert len(unmeasured) <= 3 * SHORTLIST.max_linearised_places  # for each of three noise inflations


@pytest.mark.parametrize(
    ("hidden", "name"),
    [
        (MountedResonance(Channels((Dof(5, "Y"),)), 260.0, 0.05), "frequency"),
        (StingerAxial(None, 3.3e4, 0.05), "stiffness"),
        (StingerAxial(Dof(1, "Y"), 3.3e4, 0.05), "stiffness"),
    ],
)
def test_of_a_scan_for_a_resonance_the_values_about_its_minima_are_listed(hidden: Effect, name: str) -> None:
    prediction = looking_for(hidden)
    (place,) = shortlist(prediction, [], [type(hidden)(hidden.at)], silent)
    values = np.array([effect.parameters[name] for effect in place.sizes])
    # a step of 1.5 % of the frequency is one of 3 % of the stiffness
    assert np.abs(values / hidden.parameters[name] - 1).min() < 0.04
    assert len(values) > 3  # not the best of each noise inflation alone
    system, setup = prediction.predictor.system, prediction.predictor.tests[0].setup
    assert len(values) < len(scan_sizes(hidden, hidden.scan_values(system, setup))) / 2
