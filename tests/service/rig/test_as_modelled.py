from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import EffectSpec
from modallab.effects.attached_oscillator import AttachedOscillator
from modallab.effects.joint_flexibility import JointFlexibility
from modallab.fe.assembly import assemble
from modallab.fe.synthetic_modes import lowest_modes
from modallab.rig.effect import Effect
from modallab.rig.exact import as_modelled, exact_frf
from tests.rigs import dofs, steel_beam


@pytest.mark.parametrize(
    "effect",
    [AttachedOscillator(Dof(7, "Y"), 0.05, 150.0, 0.01), JointFlexibility(Dof(9, "RZ"), 1e-3)],
    ids=lambda effect: effect.kind,
)
def test_modes_and_frfs_of_a_model_with_an_effect_are_of_one_structure(effect: Effect) -> None:
    structure = effect.added_to(steel_beam())
    basis, _ = lowest_modes(as_modelled(structure), 5)
    bare, _ = lowest_modes(assemble(steel_beam()), 5)
    assert np.abs(basis.frequencies - bare.frequencies).max() > 0.5  # Hz
    assert basis.shapes.shape[0] == len(structure.dofs)
    frf = exact_frf(structure, Dof(1, "Y"), dofs(1), frequency_max=400.0, n_lines=8001)
    size = np.abs(frf.values[:, 0, 0])
    for frequency in basis.frequencies:
        near = np.abs(frf.freq - frequency) < 2.0
        # a peak of inertance lies within the half bandwidth of its mode and one line
        assert abs(frf.freq[near][size[near].argmax()] - frequency) < 0.01 * frequency + 0.05


def test_a_model_without_effects_is_what_it_was() -> None:
    plain, seen = assemble(steel_beam()), as_modelled(replace(steel_beam(), effects=()))
    np.testing.assert_array_equal(plain.stiffness.toarray(), seen.stiffness.toarray())


def test_what_drifts_is_as_it_is_at_first() -> None:
    drifting = replace(steel_beam(), effects=(EffectSpec("drift", None, {"change": 0.1}),))
    np.testing.assert_allclose(
        lowest_modes(as_modelled(drifting), 3)[0].frequencies,
        lowest_modes(assemble(steel_beam()), 3)[0].frequencies,
        rtol=1e-9,  # rounding of two solutions
    )
