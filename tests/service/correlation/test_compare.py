import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel
from modallab.correlation.compare import compare, correlate
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.reduction import reduce, reduction_of
from modallab.fe.synthetic_modes import ModeNoise, exact_modes, synthetic_modes
from tests.service.correlation.cases import POINTS, model, shapes


def test_modes_that_changed_places_find_each_other() -> None:
    values = shapes(3)
    found = compare(model(values), model(values[:, [1, 0, 3, 2]]))
    assert found.pairs == ((1, 2), (2, 1), (3, 4), (4, 3))
    np.testing.assert_allclose(found.frequency_differences, [-10.0, 10.0, -10.0, 10.0])
    np.testing.assert_allclose(found.comac, 1.0, rtol=1e-12)  # the same shapes, whatever their order


def test_more_measured_modes_than_the_model_has_leave_some_alone() -> None:
    values = shapes(5)
    found = compare(model(values[:, :2]), model(values))
    assert found.mac.shape == (4, 2)
    assert found.pairs == ((1, 1), (2, 2))


def test_only_common_dofs_count_and_a_turned_sensor_is_turned_back() -> None:
    values = shapes(7)
    measured = tuple(Dof(node, "Y", -1 if node % 2 else 1) for node in (7, 3, 2, 20, 5, 8))
    rows = np.array([6, 2, 1, 0, 4, 7])
    sign = np.array([dof.sign for dof in measured])
    seen = values[rows] * sign[:, None]
    seen[3] = 99  # at node 20, of which the model knows nothing
    found = compare(model(values), model(seen, measured))
    assert [str(dof) for dof in found.dofs] == ["2:+Y", "3:+Y", "5:+Y", "7:+Y", "8:+Y"]
    np.testing.assert_allclose(np.diag(found.mac), 1.0, rtol=1e-12)


def test_what_cannot_be_compared_is_named() -> None:
    values = shapes(1)
    elsewhere = tuple(Dof(node, "Z") for node in range(1, 9))
    with pytest.raises(InvalidInputError, match="no degree of freedom"):
        compare(model(values), model(values, elsewhere))
    with pytest.raises(InvalidInputError, match="no modes"):
        compare(model(values), ModalModel((), POINTS))


def test_a_model_held_against_itself_agrees_in_everything() -> None:
    system = assemble(STRUCTURES["chapter-5-beam"]())
    sensors = tuple(Dof(node, "Y", -1 if node % 3 else 1) for node in range(1, 22, 2))
    measured = synthetic_modes(system, 6, sensors, noise=ModeNoise(), rng=np.random.default_rng(0))
    reduced = reduce(system, tuple(dof.point for dof in sensors), reduction_of("serep", {"modes": 8}))
    found = compare(exact_modes(system, 6), measured, reduced=reduced)
    np.testing.assert_allclose(np.diag(found.mac), 1.0, rtol=1e-12)
    assert found.pole_weighted_mac is not None
    np.testing.assert_allclose(np.diag(found.pole_weighted_mac), 1.0, rtol=1e-12)
    assert found.ecomac is not None
    np.testing.assert_allclose(found.ecomac, 0.0, atol=1e-12)
    assert found.orthogonality is not None
    # a MAC at eleven points is not diagonal: mass tells modes apart exactly
    assert (found.mac - np.eye(6)).max() > 0.1
    np.testing.assert_allclose(found.orthogonality.cross, np.eye(6), atol=1e-9)  # rounding
    assert found.orthogonality.reduction == "serep"
    assert found.orthogonality.parameters == {"modes": 8.0}
    assert found.responses is None


def test_a_structure_is_held_against_as_many_modes_as_were_measured_unless_told() -> None:
    system = assemble(STRUCTURES["chapter-5-beam"]())
    sensors = tuple(Dof(node, "Y") for node in range(1, 22, 2))
    measured = synthetic_modes(system, 3, sensors, noise=ModeNoise(), rng=np.random.default_rng(0))
    assert correlate(system, measured).mac.shape == (3, 3)
    found = correlate(system, measured, count=5, reduction=reduction_of("serep"))
    assert found.mac.shape == (3, 5)
    assert found.orthogonality is not None
    # two rigid-body modes and the five that are compared: the band ends a tenth above the last of them
    assert found.orthogonality.n_motions == 7
    np.testing.assert_allclose(found.orthogonality.cross, np.eye(3, 5), atol=1e-9)  # rounding
