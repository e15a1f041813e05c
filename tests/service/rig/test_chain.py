"""A structure, a rig and effects put together."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import UnknownDofError
from modallab.core.place import Channels, EffectSpec, Members
from modallab.effects.drift import Drift
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.gain_error import GainError
from modallab.effects.stiffness_error import StiffnessError
from modallab.fe.assembly import assemble
from modallab.fe.condensation import FOLDED_SYSTEMS
from modallab.fe.damping import StructuralDamping
from modallab.fe.receptance import direct_receptance
from modallab.fe.settings import RECEPTANCE
from modallab.fe.structure import PointMass
from modallab.rig.chain import all_effects, chain
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, dofs, rig, steel_beam

FREQ = np.linspace(2.0, 800.0, 57)


def test_a_roving_accelerometer_measures_each_frf_on_another_structure() -> None:
    nodes = (1, 4, 7, 21)
    setup = rig(
        *nodes, accelerometers=Accelerometers(0.02, roving=True), force_transducer=ForceTransducer(0.01)
    )
    found = chain(beam_system(), setup).respond(FREQ).inertance
    for run, node in enumerate(nodes):
        loaded = assemble(steel_beam(masses=(PointMass(1, 0.01), PointMass(node, 0.02))))
        alpha = direct_receptance(loaded, FREQ, loaded.selection(dofs(node)), loaded.selection(dofs(1)))
        wanted = -((2 * np.pi * FREQ) ** 2) * alpha[:, 0, 0]
        # rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6
        np.testing.assert_allclose(found[run, :, 0, 0], wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def test_fixed_accelerometers_load_the_structure_all_at_once() -> None:
    setup = rig(1, 7, 21, accelerometers=Accelerometers(0.02))
    bench = chain(beam_system(), setup)
    loaded = assemble(steel_beam(masses=tuple(PointMass(node, 0.02) for node in (1, 7, 21))))
    alpha = direct_receptance(loaded, FREQ, loaded.selection(setup.responses), loaded.selection(dofs(1)))
    wanted = -((2 * np.pi * FREQ) ** 2)[:, None] * alpha[..., 0]
    assert len(bench.runs) == 1
    np.testing.assert_allclose(
        bench.respond(FREQ).inertance[0, ..., 0], wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max()
    )


def test_runs_of_a_drifting_structure_with_many_altered_members_fold_these_into_its_matrices() -> None:
    """With columns of every member at every line such a test took ten times as long."""
    nodes, freq = (1, 7, 21), np.linspace(2.0, 800.0, 3000)
    setup = rig(*nodes, accelerometers=Accelerometers(0.02, roving=True))
    altered = [StiffnessError(Members((number,)), 0.9) for number in range(3, 9)]
    found = chain(beam_system(), setup, [*altered, Drift(change=-0.02)])
    inertance = found.respond(freq).inertance[..., ::300, 0, 0]
    for run, wanted_of_run in zip(found.runs, inertance, strict=True):
        assert run.system.stacked_columns.shape[1] > RECEPTANCE.woodbury_columns
        (response,) = run.responses
        outputs, inputs = run.system.selection((response.dof,)), run.system.selection(dofs(1))
        alpha = direct_receptance(run.system, freq[::300], outputs, inputs)[:, 0, 0]
        wanted = -((2 * np.pi * freq[::300]) ** 2) * alpha
        # rounding of two solutions, as above; six altered members add a digit
        np.testing.assert_allclose(wanted_of_run, wanted, rtol=1e-6, atol=1e-9 * np.abs(wanted).max())
    assert all(run.system.cache.entries(FOLDED_SYSTEMS) for run in found.runs)


def test_two_channels_at_one_place_measure_the_same() -> None:
    bench = chain(beam_system(), rig(1, 7))
    (run,) = bench.runs
    twice = replace(bench, runs=(replace(run, responses=(*run.responses, run.responses[1])),))
    found = twice.respond(FREQ).response
    assert found.shape[2] == 3
    np.testing.assert_array_equal(found[0, :, 2], found[0, :, 1])


def test_a_rig_on_a_linear_structure_is_reciprocal() -> None:
    setup = RigSetup(dofs(3), dofs(3, 15), accelerometers=Accelerometers(0.02))
    there = chain(beam_system(), setup)
    # the masses stay where they are while force and response change places
    system = there.runs[0].system
    back = chain(system, RigSetup(dofs(15), dofs(3, 15)))
    np.testing.assert_allclose(
        there.respond(FREQ).inertance[0, :, 1], back.respond(FREQ).inertance[0, :, 0], rtol=1e-8
    )


def test_a_sensor_that_looks_the_other_way_turns_the_sign() -> None:
    plain = chain(beam_system(), rig(7)).respond(FREQ).inertance
    turned = RigSetup(dofs(1), (Dof(7, "Y", -1),))
    np.testing.assert_array_equal(chain(beam_system(), turned).respond(FREQ).inertance, -plain)


def test_the_armature_is_on_the_structure_in_the_spectra_and_not_in_the_frf() -> None:
    armature = 0.05
    free = chain(beam_system(), rig(1, 7))
    driven = chain(beam_system(), rig(1, 7, exciter=Exciter(armature_mass=armature)))
    on_structure = chain(assemble(steel_beam(masses=(PointMass(1, armature),))), rig(1, 7))
    # multiplied by F/P and divided by it again: rounding
    np.testing.assert_allclose(driven.respond(FREQ).inertance, free.respond(FREQ).inertance, rtol=1e-12)
    answer, together = driven.respond(FREQ), on_structure.respond(FREQ)
    # a/P of the driven beam is a/F of the beam that carries the armature; rounding as above
    np.testing.assert_allclose(answer.response, together.inertance, rtol=1e-7, atol=1e-9 * 20)
    np.testing.assert_allclose(driven.poles()[0], on_structure.poles()[0], rtol=1e-9)


@pytest.mark.parametrize("loss", [0.0, 0.05])
def test_at_zero_hertz_a_free_beam_moves_as_a_rigid_body(loss: float) -> None:
    bench = chain(beam_system(StructuralDamping(stiffness_coefficient=loss)), rig(1))
    ends = 4 / (7800 * 5e-4 * 1.5)  # 1/m + (l/2)^2 / (m l^2/12)
    # near 0 Hz is not 0 Hz: 1e-6; rounding of a rigid body's damping: 1e-5
    assert np.isclose(bench.respond(np.array([0.0, 800.0])).inertance[0, 0, 0, 0], ends, rtol=2e-5)


def test_poles_are_where_the_response_peaks_and_as_wide() -> None:
    bench = chain(beam_system(StructuralDamping(stiffness_coefficient=0.01)), rig(1))
    frequency, half = (values[0, 2] for values in bench.poles())
    offset = np.array([-1.0, 0.0, 1.0])
    size = np.abs(bench.respond(frequency + half * offset).inertance[0, :, 0, 0])
    # the neighbours' share and the factor omega^2 are some per cent of a peak of loss factor 0.01
    np.testing.assert_allclose(size[[0, 2]] / size[1], np.sqrt(0.5), rtol=0.05)


def test_an_effect_that_rebuilds_the_structure_brings_its_own_modes() -> None:
    softer = StiffnessError(factor=0.5)
    setup = rig(1, 7, 16, accelerometers=Accelerometers(0.02, roving=True))
    all_members = StiffnessError(at=Members(tuple(range(1, 21))), factor=0.5)
    whole, by_member = (
        chain(beam_system(), setup, [effect]).respond(FREQ).inertance for effect in (softer, all_members)
    )
    np.testing.assert_allclose(whole, by_member, rtol=1e-6, atol=1e-7 * np.abs(whole).max())


def test_hardware_the_log_book_and_what_is_added_all_act_in_stage_order() -> None:
    setup = rig(
        1,
        7,
        exciter=Exciter(armature_mass=0.02),
        force_transducer=ForceTransducer(0.01),
        accelerometers=Accelerometers(0.02),
        noise=Noise(1e-3, 1e-4),
        effects=(EffectSpec("leakage", None, {"share": 0.2}),),
    )
    effects = all_effects(setup, [ExtraMass(at=Dof(4, "Y"), mass=0.1)])
    stages = [effect.stage for effect in effects]
    assert stages == sorted(stages)
    assert {effect.kind for effect in effects} == {
        "accelerometer_mass",
        "exciter_armature",
        "extra_mass",
        "force_noise",
        "force_transducer_mass",
        "leakage",
        "response_noise",
    }


def test_a_mass_the_analyser_has_cancelled_leaves_the_frf_and_stays_in_the_force() -> None:
    cancelled = rig(1, 7, force_transducer=ForceTransducer(0.05, mass_cancelled=True))
    plain, found = chain(beam_system(), rig(1, 7)), chain(beam_system(), cancelled)
    # multiplied by F/P and divided by it again: rounding
    np.testing.assert_allclose(found.respond(FREQ).inertance, plain.respond(FREQ).inertance, rtol=1e-12)
    assert found.runs[0].drives[0].cancelled_mass == 0.05


@pytest.mark.parametrize(("drive", "response"), [("30:+Y", "1:+Y"), ("1:+Y", "30:+Y"), ("1:+X", "1:+Y")])
def test_driving_or_listening_where_the_structure_is_not_is_refused(drive: str, response: str) -> None:
    with pytest.raises(UnknownDofError, match="no degree of freedom"):
        chain(beam_system(), RigSetup((Dof.parse(drive),), (Dof.parse(response),)))


def test_a_structure_that_is_loaded_otherwise_is_not_answered_from_memory() -> None:
    system, setup = beam_system(), rig(1, 4, 7, accelerometers=Accelerometers(0.02, roving=True))
    louder = GainError(Channels((setup.responses[1],)), 1.2)
    every = [
        (),
        (louder,),
        (ExtraMass(Dof(9, "Y"), 0.1),),
        (louder,),
        (),
        (StiffnessError(Members((3,)), 0.5),),
    ]
    answers = [chain(system, setup, effects).respond(FREQ[::step]) for step in (1, 2) for effects in every]
    anew = [
        chain(beam_system(), setup, effects).respond(FREQ[::step]) for step in (1, 2) for effects in every
    ]
    for found, wanted in zip(answers, anew, strict=True):
        np.testing.assert_array_equal(found.channels, wanted.channels)
