"""Attachments folded into the matrices change no receptance, and are folded once."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.condensation import condense_if_cheaper
from modallab.fe.damping import StructuralDamping
from modallab.fe.receptance import direct_receptance
from modallab.fe.system import DynamicSystem
from modallab.fe.variants import attached_variants

FREQ = np.array([3.0, 17.0, 61.0, 240.0, 800.0])


def many_masses() -> DynamicSystem:
    system = assemble(replace(STRUCTURES["chapter-5-beam"](), damping=StructuralDamping(0.005, 100.0)))
    return system.add_masses([*range(2, 20), 2, 3], 0.02)  # some nodes carry two


def test_many_attachments_are_folded_once_and_for_all_that_follow() -> None:
    system = many_masses()
    few_more = system.change_member(7, bending=0.3).add_mass(5, 0.1)
    at = system.selection((Dof(1, "Y"), Dof(9, "Y")))
    assert condense_if_cheaper(system).attachments == ()
    assert condense_if_cheaper(few_more).mass is condense_if_cheaper(system).mass
    for loaded in (system, few_more):
        folded = attached_variants([loaded], 2 * np.pi * FREQ, [at], [at])[0]
        # modes of other matrices against the Woodbury identity: rounding, magnified at antiresonances
        np.testing.assert_allclose(folded, direct_receptance(loaded, FREQ, at, at), rtol=1e-6)


def test_a_damper_stays_attached_where_masses_are_folded() -> None:
    system = many_masses().add_damper(Dof(7, "Y"), 40.0)
    at = system.selection((Dof(1, "Y"), Dof(9, "Y")))
    folded = condense_if_cheaper(system)
    assert folded.viscous is None  # which would couple the modes at every frequency
    assert [a.viscous is not None for a in folded.attachments] == [True]
    found = attached_variants([system], 2 * np.pi * FREQ, [at], [at])[0]
    np.testing.assert_allclose(found, direct_receptance(system, FREQ, at, at), rtol=1e-6)  # as above


def test_what_hangs_twice_does_not_stand_in_for_what_was_folded_before() -> None:
    system = many_masses()
    at = system.selection((Dof(1, "Y"), Dof(9, "Y")))
    condense_if_cheaper(system.change_member(7, bending=0.3))
    other = system.change_member(7, bending=0.6).add_mass(5, 0.02)  # as many, one as another that it has
    folded = attached_variants([other], 2 * np.pi * FREQ, [at], [at])[0]
    np.testing.assert_allclose(folded, direct_receptance(other, FREQ, at, at), rtol=1e-6)  # as above


@pytest.mark.parametrize("coupled", [False, True], ids=["masses alone", "what couples motions too"])
def test_many_attachments_at_few_frequencies_are_not_folded_and_give_the_direct_solution(
    coupled: bool,
) -> None:
    system = many_masses()
    if coupled:
        system = system.change_member(7, bending=0.3).add_oscillator(Dof(5, "Y"), 0.05, 90.0, 0.02)
    at = system.selection((Dof(1, "Y"), Dof(9, "Y"), Dof(2, "Y")))
    assert condense_if_cheaper(system, len(FREQ)) is system
    found = attached_variants([system, system], 2 * np.pi * FREQ, [at, at[:, ::-1]], [at[:, :1]] * 2)
    beyond = np.zeros((sum(a.inner for a in system.attachments), 3))
    everything = np.vstack([at, beyond])
    wanted = direct_receptance(system, FREQ, everything, everything[:, :1])
    # rounding of the eigen-solution, magnified at antiresonances
    np.testing.assert_allclose(found, [wanted, wanted[:, ::-1]], rtol=1e-6)


def test_a_few_sets_of_attachments_stay_folded_beside_one_another() -> None:
    system, other = many_masses(), many_masses()
    other = replace(other, attachments=system.attachments[:11], cache=system.cache)
    first = condense_if_cheaper(system).mass
    assert condense_if_cheaper(other).mass is not first
    assert condense_if_cheaper(system).mass is first
