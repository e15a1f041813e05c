"""Wrong stiffness, held against scaling laws, energy shares and matrices put together by hand."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.effects.stiffness_error import StiffnessError
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.receptance import direct_receptance
from modallab.fe.structure import GroundSpringElement, Support
from modallab.rig.chain import chain
from modallab.rig.setup import AcquisitionRun
from tests import bernoulli
from tests.rigs import BAR, STEEL, beam_system, dofs, rig, steel_beam, tilted_beam

FREQ = np.linspace(5.0, 800.0, 60)
SHOT = AcquisitionRun(dofs(1), dofs(1))


@pytest.mark.parametrize("factor", [0.25, 1.1, 9.0])
def test_everywhere_all_frequencies_go_with_the_root_of_the_factor(factor: float) -> None:
    bare = beam_system().modes().elastic(8)
    bench = chain(beam_system(), rig(1, analyser={"frequency_max": 2500.0}), [StiffnessError(factor=factor)])
    found = bench.runs[0].system.modes().elastic(8)
    # rounding of a stiff beam: 1e-16 times the ratio of its eigenvalues, 1e6
    np.testing.assert_allclose(found.frequencies, bare.frequencies * np.sqrt(factor), rtol=1e-9)
    np.testing.assert_allclose(bench.poles()[0][0, :4], bare.frequencies[:4] * np.sqrt(factor), rtol=1e-9)
    # D = a M + b K goes with the stiffness that it is tied to: eta_r = a / lambda_r + b
    wanted = 100.0 / (2 * np.pi * found.frequencies) ** 2 + 0.005
    np.testing.assert_allclose(
        found.loss_factors, wanted, rtol=1e-6
    )  # the same rounding, and 100 eigenvalues


def test_a_little_in_one_member_shifts_each_mode_by_half_its_share_of_the_strain_energy() -> None:
    """Rayleigh, The Theory of Sound (1894), chapter IV, with the curvatures of the continuous beam."""
    bare, small = chain(beam_system(), rig(1)).poles()[0][0, :6], 1e-4
    for member in (1, 4, 10):
        effect = StiffnessError(at=Members((member,)), factor=1 + small)
        found = chain(beam_system(), rig(1), [effect]).poles()[0][0, :6] / bare - 1
        share = bernoulli.energy_shares(member, strain=True)
        # Next order: 1e-4 of it. Curvature is straight within an element: what that leaves out of a member's
        # energy, a tenth, is (z/20)^4/720 of it, z = 20.4 at the most.
        np.testing.assert_allclose(found, small * share / 2, rtol=0, atol=1.5e-4 * small / 2)


@pytest.mark.parametrize("factor", [0.1, 1.5, 12.0])
def test_in_some_members_the_frf_is_that_of_matrices_put_together_by_hand(factor: float) -> None:
    effect = StiffnessError(at=Members((4, 13)), factor=factor)
    found = chain(beam_system(), rig(1, 7, 16), [effect]).respond(FREQ).inertance[0, ..., 0]
    wanted = bernoulli.inertance(*bernoulli.matrices({}, {4: factor, 13: factor}), FREQ, (1, 7, 16))
    # rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def test_everywhere_and_in_a_member_multiply() -> None:
    effects = [StiffnessError(at=Members((4,)), factor=2.0), StiffnessError(factor=1.5)]
    found = chain(beam_system(), rig(1, 7, 16), effects).respond(FREQ).inertance[0, ..., 0]
    factors = dict.fromkeys(range(1, 21), 1.5) | {4: 3.0}
    wanted = bernoulli.inertance(*bernoulli.matrices({}, factors), FREQ, (1, 7, 16))
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())  # as above


@pytest.mark.parametrize("factor", [0.3, 4.0])
def test_a_clamped_beam_softer_at_its_root_gives_way_as_its_flexibilities_add_up(factor: float) -> None:
    """Mohr: of a tip deflection F L^3/(3 E I) the root has the share 1 - (1 - h/L)^3."""
    length, n = 0.8, 4
    held = (Support(1, ("Y", "RZ")),)
    system = assemble(beam(length=length, n_elements=n, section=BAR, material=STEEL, supports=held))
    tip = system.selection((Dof(n + 1, "Y"),))
    softer = StiffnessError(at=Members((1,)), factor=factor).on_system(system, SHOT)
    rigidity = STEEL.modulus * BAR.second_moment
    root = 1 - (1 - 1 / n) ** 3
    wanted = length**3 / (3 * rigidity) * (1 - root + root / factor)
    slow = np.array([1e-5])  # (10 uHz / 9 Hz)^2 is below rounding
    assert direct_receptance(softer, slow, tip, tip)[0, 0, 0].real == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("at", [None, Members((4, 13))])
def test_added_to_the_model_it_is_the_model_with_another_modulus(at: Members | None) -> None:
    numbers = at.numbers if at else tuple(range(1, 21))
    # A spring to the ground is no member's: it stays as it is. Tilted, members stretch as well.
    structure = replace(
        steel_beam() if at else tilted_beam(), springs=(GroundSpringElement(Dof(5, "Y"), 3e3),)
    )
    effect = StiffnessError(at=at, factor=1.7)
    model = effect.added_to(structure)
    assert model.springs == structure.springs
    assert model.effects == ()
    changed = change(structure, [MemberChange(numbers, MemberProperty.MODULUS, factor=1.7)])
    pick = assemble(structure).selection(dofs(1, 7))
    wanted = direct_receptance(assemble(changed), FREQ, pick, pick)
    for found in (assemble(model), chain(assemble(structure), rig(1), [effect]).runs[0].system.folded()):
        np.testing.assert_allclose(
            direct_receptance(found, FREQ, pick, pick), wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max()
        )
