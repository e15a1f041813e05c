"""Zhang's two methods on the thesis's bay, which reports that both fail: sections 2.3.3 and 2.4."""

from functools import cache

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes
from modallab.updating.error_location.method import LocationResult
from modallab.updating.error_location.run import locate
from modallab.updating.parameterisation import parameterise
from tests.published.tables import table

TABLES = table("frames_1992")
BAY = STRUCTURES["bay"]()
DOFS = tuple(
    Dof(node, direction) for node in TABLES["table_3_1"]["measured_nodes"] for direction in ("X", "Y")
)
# mass and stiffness members that are wrong, by half and by double
CASES: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {
    "first": ((), (12, 13, 31)),
    "second": ((11, 12), (25, 26, 27)),
    "chapter 3": ((25, 26), (12, 13, 31)),
}


@cache
def located(method: str, case: str) -> LocationResult:
    heavier, stiffer = CASES[case]
    changes = [MemberChange(stiffer, MemberProperty.MODULUS, factor=2.0)]
    if heavier:
        changes.append(MemberChange(heavier, MemberProperty.DENSITY, factor=1.5))
    system, rng = assemble(change(BAY, changes)), np.random.default_rng(0)
    target = synthetic_modes(system, 10, DOFS, noise=ModeNoise(), rng=rng)
    return locate(BAY, parameterise([(n,) for n in range(1, 32)]), method, target)


def suspects(result: LocationResult) -> int:
    return sum(map(len, result.suspected.values()))


@pytest.mark.parametrize("case", CASES)
def test_solving_for_all_coefficients_at_once_suspects_half_the_bay(case: str) -> None:
    found = located("zhang_sensitivity", case)
    # the failure that the thesis reports: 62 coefficients of condition 1e3, and errors of 100 %
    assert found.condition_number == pytest.approx(1.02e3, rel=0.01)
    assert 25 <= suspects(found) <= 35


def test_and_misses_wrong_members_all_the_same() -> None:
    assert 12 not in located("zhang_sensitivity", "first").suspected["stiffness"]
    assert 26 not in located("zhang_sensitivity", "second").suspected["stiffness"]


@pytest.mark.parametrize("case", CASES)
def test_a_growing_subspace_holds_every_wrong_member_and_few_others(case: str) -> None:
    # The thesis has it miss member 13 in the first case and 27 in the second: with frequencies and shapes,
    # and all chosen coefficients solved for again at each step, it misses none.
    heavier, stiffer = CASES[case]
    found = located("zhang_subspace", case)
    assert set(heavier) <= set(found.suspected["mass"])
    assert set(stiffer) <= set(found.suspected["stiffness"])
    assert suspects(found) - len(heavier) - len(stiffer) <= 4
