"""Frequency responses change kind by factors of i omega."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet

DOFS = (Dof(1, "Y"), Dof(2, "Y"))
KINDS = st.sampled_from(FrfKind)


def responses(freq: np.ndarray, kind: FrfKind = FrfKind.RECEPTANCE) -> FrfSet:
    values = np.random.default_rng(3).normal(size=(len(freq), 2, 1, 2)).view(complex)[..., 0]
    return FrfSet(freq, values, DOFS, DOFS[:1], kind)


@given(kind=KINDS, via=KINDS)
def test_there_and_back_is_where_it_was(kind: FrfKind, via: FrfKind) -> None:
    frf = responses(np.linspace(1.0, 50.0, 8), kind)
    np.testing.assert_allclose(frf.to(via).to(kind).values, frf.values, rtol=1e-12)


def test_inertance_is_minus_omega_squared_times_receptance() -> None:
    frf = responses(np.array([2.0, 10.0]))
    expected = -((2 * np.pi * frf.freq) ** 2)[:, None, None] * frf.values
    np.testing.assert_allclose(frf.to(FrfKind.INERTANCE).values, expected, rtol=1e-12)


def test_at_rest_nothing_can_be_integrated() -> None:
    frf = responses(np.array([0.0, 10.0]), FrfKind.INERTANCE)
    with pytest.raises(InvalidInputError, match="0 Hz"):
        frf.to(FrfKind.RECEPTANCE)
    assert frf.between(0.0, 20.0).to(FrfKind.RECEPTANCE).freq.tolist() == [10.0]


@pytest.mark.parametrize("freq", [[], [-1.0, 2.0], [1.0, 1.0], [2.0, 1.0]])
def test_an_axis_that_does_not_rise_is_refused(freq: list[float]) -> None:
    with pytest.raises(InvalidInputError) as caught:
        responses(np.array(freq))
    assert caught.value.context["field"] == "freq"
