"""Resonances of a loaded system, against the modes of matrices that the loads were added into."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_array

from modallab.core.dof import Dof
from modallab.fe.attachment import Attachment
from modallab.fe.cache import Cache
from modallab.fe.damping import Damping, StructuralDamping, ViscousDamping
from modallab.fe.loaded_modes import half_power, only_loads
from modallab.fe.modes import ModalBasis
from modallab.fe.system import DynamicSystem
from tests.rigs import beam_system

LAWS = {
    "structural": StructuralDamping(stiffness_coefficient=0.005, mass_coefficient=100.0),
    "viscous": ViscousDamping(stiffness_coefficient=1e-6, mass_coefficient=1.0),
    "none": StructuralDamping(stiffness_coefficient=0.0, mass_coefficient=0.0),
}


def loaded(law: Damping) -> DynamicSystem:
    """A beam with two masses, a dashpot and a lossy patch on it."""
    system = beam_system(law).add_mass(1, 0.01).add_mass(9, 0.3).add_damper(Dof(5, "Y"), 2.0)
    columns = system.selection((Dof(3, "Y"), Dof(4, "Y")))
    return system.attach(Attachment(columns, damping=50.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])))


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_resonances_are_those_of_matrices_with_the_loads_in_them(law: Damping) -> None:
    system = loaded(law)
    whole = system.folded()
    assert only_loads(system.attachments)
    basis = whole.base_modes(800.0).elastic()
    frequencies, half = system.resonances(800.0)
    undamped = (
        replace(whole, damping=None, viscous=None, cache=Cache()).base_modes(800.0).elastic().frequencies
    )
    # rounding, 1e-16, times the ratio of the greatest eigenvalue to that of the first mode, 1e8
    np.testing.assert_allclose(frequencies, undamped, rtol=1e-7)
    light = basis.loss_factors < 0.02  # where the width is that of the complex pole, to the square of this
    np.testing.assert_allclose(
        half[light], (basis.loss_factors * basis.frequencies / 2)[light], rtol=0.02, atol=1e-9
    )
    assert light.sum() > 8


def test_oscillators_and_springs_between_motions_are_no_mere_loads() -> None:
    bare = beam_system()
    assert only_loads(())
    assert only_loads(bare.add_spring(Dof(1, "Y"), 1e3).attachments)
    assert not only_loads(bare.add_oscillator(Dof(1, "Y"), 0.1, 50.0, 0.01).attachments)
    columns = bare.selection((Dof(3, "Y"), Dof(4, "Y")))
    assert not only_loads((Attachment(columns, stiffness=50.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])),))


@pytest.mark.parametrize("where", [(1,), (1, 21), (5, 5), (3, 9, 17)], ids=str)
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_resonances_on_springs_are_those_of_matrices_with_the_springs_in_them(
    law: Damping, where: tuple[int, ...]
) -> None:
    system = loaded(law)
    for node in where:
        system = system.add_spring(Dof(node, "Y"), 2e4)
    frequencies, _ = system.resonances(800.0)
    whole = replace(system.folded(), damping=None, viscous=None, cache=Cache()).base_modes(800.0)
    # One rigid-body mode less for every place that is held, two at most: a free beam has two.
    assert whole.n_rigid_body == max(2 - len(set(where)), 0)
    # rounding of the greatest eigenvalue, 1e8 of the first mode's and of that on springs
    np.testing.assert_allclose(frequencies, whole.elastic().frequencies, rtol=1e-6)


def test_a_spring_takes_a_rigid_body_mode_among_the_resonances() -> None:
    system = beam_system().add_spring(Dof(1, "Y"), 1e3).add_spring(Dof(21, "Y"), 1e3)
    assert system.resonances(800.0)[0][0] < 5.0  # the beam on its springs, far below its first bending mode


def test_a_motion_that_rounding_leaves_without_stiffness_has_no_width() -> None:
    # of a spring so soft that its eigenvalue is rounding, of either sign
    basis = ModalBasis(np.array([-1e-9, 400.0], complex), np.eye(2), 0)
    frequencies, half = half_power(basis, csc_array(8.0 * np.eye(2)), None)
    np.testing.assert_allclose(frequencies, [0.0, 20 / (2 * np.pi)], rtol=1e-12)  # one square root
    np.testing.assert_allclose(half, [0.0, 8 / (2 * 20) / (2 * np.pi)], rtol=1e-12)
