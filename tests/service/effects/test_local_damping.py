"""A damper at one point, held against closed forms and the energy it takes."""

import numpy as np
import pytest
from scipy.linalg import eig

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.effects.local_damping import LocalDamping
from modallab.fe.damping import StructuralDamping
from modallab.fe.receptance import receptance
from modallab.rig.chain import chain
from modallab.rig.setup import AcquisitionRun
from tests.rigs import beam_system, dofs, rig, steel_beam

UNDAMPED = beam_system(StructuralDamping())
AT = Dof(4, "Y")
SHOT = AcquisitionRun(dofs(1), dofs(1))


def test_at_resonance_of_a_lossless_structure_the_damper_alone_resists() -> None:
    damping = 3.0
    frequency = UNDAMPED.modes().elastic(5).frequencies
    loaded = LocalDamping(at=AT, damping=damping).on_system(UNDAMPED, SHOT)
    pick = loaded.selection((AT,))
    # 1e-9 beside the pole, where the structure alone moves some 1e6 times as much
    near = frequency * (1 + 1e-9)
    found = receptance(loaded, near, pick, pick)[:, 0, 0]
    np.testing.assert_allclose(found, 1 / (2j * np.pi * near * damping), rtol=1e-4)


def test_a_small_damper_gives_each_mode_the_loss_factor_of_the_energy_it_takes() -> None:
    damping = 0.2
    basis = UNDAMPED.modes().elastic(8)
    omega, phi = 2 * np.pi * basis.frequencies, basis.shapes[UNDAMPED.index(AT)]
    whole = LocalDamping(at=AT, damping=damping).on_system(UNDAMPED, SHOT).folded()
    assert whole.viscous is not None
    n = len(whole.dofs)
    # first-order form of M x'' + C x' + K x = 0
    m, c, k = (matrix.toarray() for matrix in (whole.mass, whole.viscous, whole.stiffness))
    eye, nought = np.eye(n), np.zeros((n, n))
    poles = eig(np.block([[nought, eye], [-k, -c]]), np.block([[eye, nought], [nought, m]]), right=False)
    found = np.array([poles[np.abs(poles - 1j * w).argmin()] for w in omega])
    # Twice the damping ratio. What the next order adds is 1e-5 of it; rounding of a solution whose
    # largest pole is 1e3 times as fast, 1e-9.
    np.testing.assert_allclose(
        -2 * found.real / np.abs(found), damping * phi**2 / omega, rtol=1e-4, atol=1e-9
    )


def test_what_a_rig_with_it_shows_is_the_structure_seen_through_one_more_impedance() -> None:
    damping = 5.0
    system, setup = beam_system(), rig(1, 7)
    freq = np.linspace(10.0, 700.0, 60)
    omega = 2 * np.pi * freq
    pick = system.selection((*dofs(1, 7), AT))
    bare = receptance(system, freq, pick, pick)
    # a force -i omega c x acts back at the damper
    back = 1j * omega * damping / (1 + 1j * omega * damping * bare[:, 2, 2])
    expected = -(omega**2) * (bare[:, 1, 0] - bare[:, 1, 2] * back * bare[:, 2, 0])
    found = chain(system, setup, [LocalDamping(at=AT, damping=damping)]).respond(freq).inertance[0, :, 1, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-9)  # rounding


def test_it_does_not_sit_at_a_rotation() -> None:
    with pytest.raises(InvalidInputError, match="5:"):
        LocalDamping(at=Dof(5, "RZ")).check(steel_beam())
