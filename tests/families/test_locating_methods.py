"""What every method of error location by one linear step must do."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnderdeterminedError, UnknownDofError
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.updating.error_location.method import LOCATORS
from modallab.updating.error_location.run import locate
from modallab.updating.options import LocationOptions
from modallab.updating.parameterisation import parameterise
from tests.service.updating.cases import BEAM, BEAM_DOFS, modes_of

FOUR = parameterise([tuple(range(i, i + 5)) for i in range(1, 21, 5)])
STIFFER = change(BEAM, [MemberChange((6, 7, 8, 9, 10), MemberProperty.MODULUS, factor=1.2)])


@pytest.mark.parametrize("kind", LOCATORS)
def test_one_wrong_macro_element_is_suspected_and_no_other(kind: str) -> None:
    found = locate(BEAM, FOUR, kind, modes_of(STIFFER, 8, BEAM_DOFS))
    assert found.suspected == {"mass": (), "stiffness": (6, 7, 8, 9, 10)}
    # to first order: what is neglected is about the change squared
    assert found.changes["stiffness"][7] == pytest.approx(0.2, abs=0.05)
    assert found.weights["stiffness"][7] > 0.5


@pytest.mark.parametrize("kind", LOCATORS)
def test_a_model_without_errors_is_not_suspected(kind: str) -> None:
    found = locate(BEAM, FOUR, kind, modes_of(BEAM, 8, BEAM_DOFS))
    assert found.suspected == {"mass": (), "stiffness": ()}


@pytest.mark.parametrize("kind", LOCATORS)
def test_what_is_within_the_threshold_is_not_suspected(kind: str) -> None:
    target = modes_of(STIFFER, 8, BEAM_DOFS)
    found = locate(BEAM, FOUR, kind, target, options=LocationOptions(suspect_threshold=0.3))
    assert found.suspected == {"mass": (), "stiffness": ()}


@pytest.mark.parametrize("kind", LOCATORS)
def test_what_cannot_be_located_is_refused(kind: str) -> None:
    target = modes_of(STIFFER, 8, BEAM_DOFS)
    with pytest.raises(UnderdeterminedError):
        locate(
            BEAM, parameterise([(n,) for n in range(1, 21)]), kind, replace(target, modes=target.modes[:1])
        )
    with pytest.raises(UnknownDofError):
        locate(BEAM, FOUR, kind, replace(target, dofs=(Dof(99, "Y"), *BEAM_DOFS[1:])))
    with pytest.raises(InvalidInputError):
        locate(BEAM, FOUR, kind, replace(target, modes=()))


@pytest.mark.parametrize("kind", LOCATORS)
def test_a_method_says_what_it_is_and_what_it_does(kind: str) -> None:
    told: list[float] = []

    def hear(fraction: float, message: str) -> None:
        assert message
        told.append(fraction)

    locate(BEAM, FOUR, kind, modes_of(STIFFER, 8, BEAM_DOFS), progress=hear)
    assert 0 < told[0] <= told[-1] <= 1
    assert (LOCATORS[kind].__doc__ or "").strip()


def test_a_method_that_is_none_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="no updating method"):
        locate(BEAM, FOUR, "guess", modes_of(STIFFER, 8, BEAM_DOFS))
    with pytest.raises(InvalidInputError):
        LocationOptions(suspect_threshold=np.nan)
