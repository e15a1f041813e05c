import numpy as np
import pytest

from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.updating.location import suspect_members
from modallab.updating.method import UPDATERS
from modallab.updating.parameterisation import (
    MacroElement,
    Parameterisation,
    Part,
    parameterise,
)
from modallab.updating.partitioning import automatic_groups
from tests.service.updating.cases import BEAM, BEAM_DOFS, modes_of

PAIR = Parameterisation((MacroElement((1, 2), Part.MASS), MacroElement((3, 4), Part.STIFFNESS)))


def test_macro_elements_beyond_the_threshold_are_suspected() -> None:
    found = suspect_members(PAIR, np.array([1.05, 0.8]), 0.08)
    assert found is not None
    assert [macro.members for macro in found.parameterisation.macros] == [(3,), (4,)]
    np.testing.assert_array_equal(found.start, [0.8, 0.8])


def test_below_the_threshold_the_farthest_is_suspected_if_it_moved_at_all() -> None:
    found = suspect_members(PAIR, np.array([1.01, 1.05]), 0.08)
    assert found is not None
    assert [macro.members for macro in found.parameterisation.macros] == [(3,), (4,)]
    assert suspect_members(PAIR, np.array([1.005, 0.99]), 0.08) is None


def test_loss_factors_are_judged_among_themselves() -> None:
    both = parameterise([(1, 2), (3, 4)], ("stiffness", "damping"))
    found = suspect_members(both, np.array([1.5, 1.0, 0.02, 0.009]), 0.08, 0.008)
    assert found is not None
    assert [str(macro) for macro in found.parameterisation.macros] == [
        *("stiffness of 1", "stiffness of 2"),
        *("damping of 1", "damping of 2", "damping of 3", "damping of 4"),
    ]
    np.testing.assert_array_equal(found.start, [1.5, 1.5, 0.02, 0.02, 0.009, 0.009])
    # below both thresholds: what moved farthest, in either kind, if at all
    slight = suspect_members(both, np.array([1.0, 1.01, 0.003, -0.004]), 0.08, 0.008)
    assert slight is not None
    assert [str(macro) for macro in slight.parameterisation.macros] == [
        *("damping of 1", "damping of 2", "damping of 3", "damping of 4")
    ]
    assert suspect_members(both, np.array([1.0, 1.01, 0.001, 0.0]), 0.08, 0.008) is None


def test_one_wrong_element_of_a_macro_element_of_four_is_found() -> None:
    truth = change(BEAM, [MemberChange((7,), MemberProperty.MODULUS, factor=1.3)])
    groups = parameterise(automatic_groups(BEAM))
    result = UPDATERS["inverse_eigensensitivity"](BEAM, groups, modes_of(truth, 8, BEAM_DOFS))
    # Noise-free modes: the iteration ends where a step is below its tolerance of 1e-3.
    assert result.coefficients[Part.STIFFNESS][7] == pytest.approx(1.3, abs=1e-3)


def test_one_macro_element_for_all_members_is_one_unknown_a_part() -> None:
    truth = change(
        BEAM,
        [
            MemberChange(tuple(range(1, 21)), MemberProperty.MODULUS, factor=1.2),
            MemberChange(tuple(range(1, 21)), MemberProperty.DENSITY, factor=1.3),
        ],
    )
    parameters = parameterise([tuple(range(1, 21))])
    result = UPDATERS["inverse_eigensensitivity"](BEAM, parameters, modes_of(truth, 2, BEAM_DOFS[:1]))
    assert {len(step.macros) for step in result.history} == {2}
    assert result.converged, result.stopped_because
    assert result.suspected == {"mass": tuple(range(1, 21)), "stiffness": tuple(range(1, 21))}
    # 1e-6: noise-free, it converges quadratically below the tolerance of its last step, 1e-4
    assert result.coefficients["mass"] == pytest.approx(dict.fromkeys(range(1, 21), 1.3), abs=1e-6)
    assert result.coefficients["stiffness"] == pytest.approx(dict.fromkeys(range(1, 21), 1.2), abs=1e-6)


def test_a_single_group_stays_whole_beside_nodes_of_which_several_may_be_wrong() -> None:
    masses = tuple(MacroElement((node,), Part.POINT_MASS) for node in (7, 9))
    groups = parameterise([(1, 2, 3)], nodal=masses)
    found = suspect_members(groups, np.array([1.3, 0.8, 1.2, 1.0]), 0.08)
    assert found is not None
    assert [str(macro) for macro in found.parameterisation.macros] == [
        *("mass of 1, 2, 3", "stiffness of 1, 2, 3", "point_mass of node 7")
    ]
    np.testing.assert_array_equal(found.start, [1.3, 0.8, 1.2])
