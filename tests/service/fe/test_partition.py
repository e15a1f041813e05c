import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.partition import Partition
from modallab.fe.settings import EIGENSOLUTION
from tests.rigs import beam_system, dofs, steel_beam

BEAM = beam_system()


def test_masters_and_slaves_are_all_rows_once() -> None:
    split = Partition.of(BEAM, (Dof(5, "Y", -1), Dof(1, "RZ")))
    assert split.masters == (Dof(5, "Y"), Dof(1, "RZ"))
    assert [BEAM.dofs[row] for row in split.rows] == list(split.masters)
    assert sorted((*split.rows, *split.slaves)) == list(range(len(BEAM.dofs)))


def test_masters_follow_themselves() -> None:
    split = Partition.of(BEAM, dofs(9, 3))
    t = split.with_masters(np.full((len(split.slaves), 2), 7.0))
    np.testing.assert_array_equal(t[split.rows], np.eye(2))
    assert (t[split.slaves] == 7.0).all()


@pytest.mark.parametrize("frequency", [0.0, 100.0])
def test_forces_on_slaves_are_solved_for_with_masters_held(frequency: float) -> None:
    split = Partition.of(BEAM, dofs(1, 11, 21))
    omega = 2 * np.pi * frequency
    forces = np.random.default_rng(0).standard_normal((len(split.slaves), 2))
    found = (split.dynamic(omega) if omega else split.static())(forces)
    stiffness = (BEAM.stiffness - omega**2 * BEAM.mass).toarray()[np.ix_(split.slaves, split.slaves)]
    size = np.abs(stiffness) @ np.abs(found)  # of the terms that cancel
    assert (np.abs(stiffness @ found - forces) < 1e-10 * size).all()


def test_what_is_attached_has_rows_of_its_own() -> None:
    hung = Partition.of(BEAM.add_oscillator(Dof(11, "Y"), 0.3, 40.0, 0.0), dofs(1, 21))
    assert len(hung.rows) + len(hung.slaves) == len(BEAM.dofs) + 1


def test_large_structures_are_solved_no_further_than_asked() -> None:
    large = Partition.of(assemble(steel_beam(n_elements=EIGENSOLUTION.dense_dofs)), dofs(1, 100, 251))
    few = large.lowest(100, highest=130.0)
    assert len(few.eigenvalues) == 2 + 3  # rigid-body modes, and 23.6, 65.2 and 127.8 Hz
    assert len(large.lowest(100, highest=5.0).eigenvalues) > 2  # never without an elastic mode
    assert len(large.lowest(4).eigenvalues) >= 2 + 4
    assert len(Partition.of(BEAM, dofs(1)).lowest(1).eigenvalues) == len(BEAM.dofs)
