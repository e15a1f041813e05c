"""What every effect must be."""

from dataclasses import replace
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, ModalLabError
from modallab.core.place import Channels, EffectSpec, Members, Place
from modallab.core.progress import silent
from modallab.correlation.evidence import Evidence
from modallab.estimation.coherence import coherence, coherence_error, frf_error
from modallab.estimation.estimator import ESTIMATORS
from modallab.fe.assembly import assemble
from modallab.fe.receptance import receptance
from modallab.fe.structure import Structure, Support
from modallab.rig.chain import chain
from modallab.rig.drive import Drive
from modallab.rig.effect import EFFECTS, Effect, Stage, build
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Accelerometers, Coil, Exciter, ForceTransducer, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.sampled import sampled_spectra
from modallab.rig.setup import AcquisitionRun, RigSetup
from modallab.rig.source import NoiseLevels, Source
from modallab.rig.stinger import StingerStiffness
from modallab.rig.suspension import Suspension
from tests.rigs import beam_system, dofs, rig, steel_beam, tilted_beam

KINDS = sorted(EFFECTS)
MECHANICAL = [kind for kind in KINDS if EFFECTS[kind].stage <= Stage.DRIVE]
FREQ = np.linspace(2.0, 800.0, 41)
SYSTEM = beam_system()
SETUP = rig(1, 7, 16)
# What needs motion across the beam's transverse axis finds it on the same beam, tilted.
TILTED = assemble(tilted_beam())
ACROSS = {kind for kind in KINDS if EFFECTS[kind].places(TILTED, SETUP)} - {
    kind for kind in KINDS if EFFECTS[kind].places(SYSTEM, SETUP)
}
# What needs a support finds it on the same beam, held at nodes that nothing else of these tests needs.
HELD_AT = (Support(18, ("Y",)), Support(19, ("RZ",)))
HELD = {
    kind for kind in KINDS if EFFECTS[kind].places(assemble(replace(steel_beam(), supports=HELD_AT)), SETUP)
} - {kind for kind in KINDS if EFFECTS[kind].places(SYSTEM, SETUP)}


def structure_for(*kinds: str) -> Structure:
    """A beam on which all of the effects can be."""
    beam = steel_beam() if ACROSS.isdisjoint(kinds) else tilted_beam()
    return beam if HELD.isdisjoint(kinds) else replace(beam, supports=HELD_AT)


STRUCTURES = {kind: structure_for(kind) for kind in KINDS}
SYSTEMS = {kind: assemble(structure) for kind, structure in STRUCTURES.items()}
# What a hand does finds a blow, and what changes from run to run several where the accelerometer roves.
STRUCK = {kind for kind in KINDS if not EFFECTS[kind].places(SYSTEMS[kind], SETUP)} & {
    kind for kind in KINDS if EFFECTS[kind].places(SYSTEMS[kind], rig(1, 7, 16, excitation="impact"))
}
LASTING = {kind for kind in KINDS if not EFFECTS[kind].places(SYSTEMS[kind], SETUP)} - STRUCK
SHOT = AcquisitionRun(SETUP.drives, SETUP.responses, elapsed=1.0)


def rig_for(*kinds: str, excitation: str = "periodic_random", **parts: Any) -> RigSetup:
    """A rig on which the effects can be seen."""
    roving = Accelerometers(roving=not LASTING.isdisjoint(kinds))
    signal = excitation if STRUCK.isdisjoint(kinds) else "impact"
    return rig(1, 7, 16, accelerometers=roving, excitation=signal, **parts)


def some_places(kind: str) -> list[Place]:
    """The first, the last and one place in between of those where the effect can sit."""
    places = EFFECTS[kind].places(SYSTEMS[kind], rig_for(kind))
    return [places[i] for i in sorted({0, len(places) // 3, len(places) - 1})]


def examples(kind: str) -> list[Effect]:
    return [EFFECTS[kind](at=place) for place in some_places(kind)]


def absent(effect: Effect) -> Effect:
    specs = effect.specs().items()
    return effect.with_parameters({name: spec.absent for name, spec in specs if spec.absent is not None})


def near(found: ComplexArray, wanted: ComplexArray) -> None:
    """Equal up to the rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6."""
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


@pytest.mark.parametrize("kind", KINDS)
def test_it_says_what_it_is_and_what_its_numbers_mean(kind: str) -> None:
    cls = EFFECTS[kind]
    assert cls.kind == kind
    assert cls.summary
    assert isinstance(cls.stage, Stage)
    for i, (name, spec) in enumerate(cls.specs().items()):
        assert spec.unit, name
        assert spec.doc, name
        assert i > 0 or spec.absent is not None, "the first number says how much of the effect there is"
        assert spec.absent is None or spec.lower <= spec.absent <= spec.upper, name
        assert spec.lower <= getattr(cls(at=None), name) <= spec.upper, name
        assert all(spec.lower <= value <= spec.upper for value in spec.scan_values), name
        assert getattr(cls(at=None), name) != spec.absent, "the default shows the effect"


@pytest.mark.parametrize("kind", KINDS)
def test_a_number_out_of_bounds_is_refused_by_name(kind: str) -> None:
    for name, spec in EFFECTS[kind].specs().items():
        for wrong in (spec.lower - 1e-3, spec.upper * 1.01, np.nan):
            with pytest.raises(InvalidInputError, match=name) as caught:
                build(EffectSpec(kind, None, {name: wrong}))
            assert caught.value.context["field"] == name


@pytest.mark.parametrize("kind", KINDS)
def test_an_unknown_number_is_refused_by_name(kind: str) -> None:
    with pytest.raises(InvalidInputError, match="colour"):
        build(EffectSpec(kind, None, {"colour": 1.0}))


@pytest.mark.parametrize("kind", KINDS)
def test_it_comes_back_from_plain_data(kind: str) -> None:
    for effect in examples(kind):
        assert build(effect.spec) == effect


@pytest.mark.parametrize("kind", KINDS)
def test_it_takes_every_place_it_names_and_no_other(kind: str) -> None:
    structure = STRUCTURES[kind]
    for place in EFFECTS[kind].places(SYSTEMS[kind], rig_for(kind)):
        EFFECTS[kind](at=place).check(structure, SETUP)
    strangers: list[Place] = [Dof(99, "Y"), Dof(1, "X"), Members((99,)), Members((1, 1)), Channels(dofs(99))]
    for stranger in strangers:
        with pytest.raises(ModalLabError):
            EFFECTS[kind](at=stranger).check(structure, SETUP)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if EFFECTS[kind].at_drive])
def test_what_hangs_on_the_exciter_may_be_written_at_the_drive_point_only(kind: str) -> None:
    EFFECTS[kind](at=SETUP.drive).check(steel_beam(), SETUP)
    with pytest.raises(InvalidInputError, match="7:"):
        EFFECTS[kind](at=Dof(7, "Y")).check(steel_beam(), SETUP)


@pytest.mark.parametrize("kind", KINDS)
def test_ideal_hardware_implies_none_of_it(kind: str) -> None:
    assert list(EFFECTS[kind].from_setup(SETUP)) == []


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("cancelled", [False, True])
def test_the_heaviest_and_noisiest_hardware_of_a_log_book_is_within_its_bounds(
    kind: str, cancelled: bool
) -> None:
    heaviest = rig(
        7,
        exciter=Exciter("shaker", 4.5, 1e8, 1e5, Coil(100.0, 1e4, 0.1), "voltage"),
        stinger=StingerStiffness(1e12, 1e7, 3e13),
        force_transducer=ForceTransducer(0.5, mass_cancelled=cancelled, stiffness=1e12),
        accelerometers=Accelerometers(0.5, True, "magnet", 10.0, 1.0, np.pi / 2, cable_mass=0.5),
        noise=Noise(force=10.0, response=10.0),
        suspension=Suspension(dofs(1, 21), stiffness=1e9, loss_factor=1.0),
    )
    for effect in EFFECTS[kind].from_setup(heaviest):
        assert build(effect.spec) == effect


@pytest.mark.parametrize("kind", KINDS)
def test_what_it_is_given_stays_as_it_was(kind: str) -> None:
    system = SYSTEMS[kind].add_mass(3, 0.01)
    names = ("mass", "stiffness", "damping")
    before = [getattr(system, name).toarray() for name in names]
    for effect in examples(kind):
        effect.on_system(system, SHOT)
        assert len(system.attachments) == 1
        for name, matrix in zip(names, before, strict=True):
            np.testing.assert_array_equal(getattr(system, name).toarray(), matrix)
        given = Drive(SETUP.drive, 0.1), NoiseLevels(0.1, 0.2), Source(0.3)
        effect.on_drive(given[0]), effect.on_noise(given[1]), effect.on_source(given[2])
        assert given == (Drive(SETUP.drive, 0.1), NoiseLevels(0.1, 0.2), Source(0.3))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if EFFECTS[kind].same_in_all_runs])
def test_a_structure_with_it_is_the_same_in_every_run(kind: str) -> None:
    # it says so, and chains ask it once for all runs
    last = AcquisitionRun((Dof.parse("16:+Y"),), (Dof.parse("3:+Y"),), elapsed=1.0)
    for effect in examples(kind):
        one, other = (
            effect.on_system(SYSTEMS[kind], acquisition_run)
            for acquisition_run in (replace(SHOT, elapsed=0.0), last)
        )
        assert one.mass is other.mass
        assert one.stiffness is other.stiffness
        assert [a.key for a in one.attachments] == [a.key for a in other.attachments]


# Next to a node of the motion the third power of a displacement is small.
STRONG = {"cubic_stiffness": {"stiffness": 3e9}}  # N/m^3


@pytest.mark.parametrize("kind", KINDS)
def test_it_changes_something_at_every_place_it_names(kind: str) -> None:
    # a spring between structure and armature is nothing without an armature
    setup = rig_for(kind, exciter=Exciter(armature_mass=0.02), analyser={"n_lines": 33, "window": "hann"})
    bare = expected_spectra(chain(SYSTEMS[kind], setup))
    places = EFFECTS[kind].places(SYSTEMS[kind], setup)
    assert places
    for place in places:
        effect = EFFECTS[kind](at=place).with_parameters(STRONG.get(kind, {}))
        found = expected_spectra(chain(SYSTEMS[kind], setup, [effect]))
        pairs = (found.ff, bare.ff), (found.xx[:, 1:], bare.xx[:, 1:]), (found.fx[:, 1:], bare.fx[:, 1:])
        changes = [np.abs(one / other - 1).max() for one, other in pairs]
        assert max(changes) > 1e-6, str(place)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if EFFECTS[kind].specs()])
def test_absent_it_leaves_the_exact_spectra(kind: str) -> None:
    setup = rig_for(kind, exciter=Exciter(armature_mass=0.02), analyser={"window": "hann"})
    bare = expected_spectra(chain(SYSTEMS[kind], setup))
    for effect in examples(kind):
        found = expected_spectra(chain(SYSTEMS[kind], setup, [absent(effect)]))
        near(ESTIMATORS["h1"](found), ESTIMATORS["h1"](bare))
        near(found.ff, bare.ff)
        near(found.xx.astype(complex), bare.xx.astype(complex))


@pytest.mark.parametrize("kind", MECHANICAL)
def test_a_structure_with_it_is_reciprocal_and_only_takes_power(kind: str) -> None:
    for effect in examples(kind):
        loaded = effect.on_system(SYSTEMS[kind], SHOT)
        points = loaded.selection(dofs(1, 7, 16, 21))
        alpha = receptance(loaded, FREQ, points, points)
        near(alpha, alpha.swapaxes(1, 2))
        assert (np.einsum("fii->fi", alpha).imag <= 0).all()


@pytest.mark.parametrize("kind", MECHANICAL)
def test_the_source_gives_power_to_a_rig_with_it(kind: str) -> None:
    for effect in examples(kind):
        bench = chain(SYSTEMS[kind], SETUP, [effect])
        pushed = bench.runs[0].drives[0].shaping(2 * np.pi * FREQ)  # force of the source as it is told to
        moved = bench.respond(FREQ).response[:, :, 0, 0] / pushed  # acceleration of the drive point
        assert (moved.imag >= 0).all()


@pytest.mark.parametrize(
    ("one", "other"),
    [
        pair
        for pair in combinations_with_replacement(KINDS, 2)
        if EFFECTS[pair[0]].stage == EFFECTS[pair[1]].stage
    ],
)
def test_effects_of_a_stage_commute(one: str, other: str) -> None:
    setup = rig_for(one, other, analyser={"n_lines": 33, "window": "hann"})
    system = assemble(structure_for(one, other))
    for a in examples(one):
        for b in examples(other):
            there, back = (expected_spectra(chain(system, setup, pair)) for pair in ([a, b], [b, a]))
            near(there.fx, back.fx)
            near(there.xx.astype(complex), back.xx.astype(complex))


# What is nonlinear agrees to first order, on a structure of its own: tests/service/rig/
# test_distorted_records.py.
@pytest.mark.parametrize("excitation", ["periodic_random", "random"])
@pytest.mark.parametrize("kind", [kind for kind in KINDS if EFFECTS[kind].stage is not Stage.MOTION])
def test_records_and_expected_spectra_agree_within_their_random_error(kind: str, excitation: str) -> None:
    averages = 200
    setup = rig(
        1,
        7,
        16,
        excitation=excitation,
        noise=Noise(1e-3, 1e-4),
        accelerometers=Accelerometers(0.01, roving=True),
        analyser={"window": "hann", "averages": averages},
    )
    for effect in examples(kind)[:2]:
        bench = chain(SYSTEMS[kind], setup, [effect])
        expected, sampled = expected_spectra(bench), sampled_spectra(bench, np.random.default_rng(7), silent)
        g2 = coherence(expected)
        ratio = np.abs(ESTIMATORS["h1"](sampled) / ESTIMATORS["h1"](expected))[..., 0]
        assert (np.abs(ratio - 1) < 3 * frf_error(g2, averages)).mean() >= 0.99  # 0.997 if normal
        within = np.abs(coherence(sampled) / g2 - 1) < 3 * coherence_error(g2, averages)
        assert within.mean() >= 0.98  # skew where coherence is near 1
        power = np.abs(sampled.xx / expected.xx - 1) < 3 / np.sqrt(averages)
        assert power.mean() >= 0.97  # resonances much narrower than a line remember the record before


def evidence(frf: float, force: float | None, shift: float, n_modes: int = 4) -> Evidence:
    """Residuals of one size everywhere, and modes that all shift alike."""
    n, shape = len(FREQ), (len(FREQ), 3)
    return Evidence(
        freq=FREQ,
        outputs=SETUP.responses,
        drive=SETUP.drive,
        frf=np.full(shape, frf * (1 + 1j) / np.sqrt(2)),
        force=None if force is None else np.full(shape, force),
        response=None,
        coherence_drop=np.outer(np.linspace(-frf, frf, n), np.full(3, 1e-3)),
        weight=np.ones(shape),
        mode_frequency=np.linspace(20.0, 700.0, n_modes),
        frequency_shift=np.full(n_modes, shift),
        response_amplitude=np.ones((n_modes, 3)),
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("frf", [0.0, 1.0, 1e6])
@pytest.mark.parametrize("force", [None, 0.0, 1.0, 1e6])
@pytest.mark.parametrize("shift", [0.0, -0.1, 0.1])
def test_suspicion_lies_between_none_and_certainty(
    kind: str, frf: float, force: float | None, shift: float
) -> None:
    assert 0 <= EFFECTS[kind].signature(evidence(frf, force, shift)) <= 1


@pytest.mark.parametrize("kind", KINDS)
def test_suspicion_can_be_had_in_a_band_without_modes(kind: str) -> None:
    assert 0 <= EFFECTS[kind].signature(evidence(1.0, 1.0, 0.0, n_modes=0)) <= 1


@pytest.mark.parametrize("kind", KINDS)
def test_in_the_log_book_or_added_it_acts_alike(kind: str) -> None:
    for effect in examples(kind):
        declared = expected_spectra(chain(SYSTEMS[kind], replace(rig_for(kind), effects=(effect.spec,))))
        added = expected_spectra(chain(SYSTEMS[kind], rig_for(kind), [effect]))
        assert declared.fx.tobytes() == added.fx.tobytes()


@pytest.mark.parametrize("kind", [kind for kind in KINDS if EFFECTS[kind].structural])
def test_a_model_that_has_it_measures_as_the_bare_one_with_it(kind: str) -> None:
    def inertance(structure: Structure, effects: list[Effect]) -> ComplexArray:
        rng = np.random.default_rng(0)
        return measure(structure, rig_for(kind), effects, route=Route.EXPECTED, rng=rng).frf.values

    for effect in examples(kind):
        bare = STRUCTURES[kind]
        near(inertance(effect.added_to(bare), []), inertance(bare, [effect]))
