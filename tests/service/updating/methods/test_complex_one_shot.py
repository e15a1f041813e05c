"""Mass, stiffness and damping of all elements at once, from complex modes."""

import pytest

from modallab.core.errors import InvalidInputError
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import Distribution, ModeNoise
from modallab.updating.methods.complex_one_shot import complex_one_shot
from modallab.updating.parameterisation import parameterise
from tests.service.updating.cases import BAY, BAY_DOFS, modes_of

EACH = parameterise([(member.number,) for member in BAY.members], ("mass", "stiffness", "damping"))
NL3 = ModeNoise(0.005, 0.05, Distribution.UNIFORM)


def lossy(loss: float) -> Structure:
    """The bay of which five members are wrong and two lose energy."""
    return change(
        BAY,
        [
            MemberChange((25, 26), MemberProperty.DENSITY, factor=1.5),
            MemberChange((12, 13, 31), MemberProperty.MODULUS, factor=2.0),
            MemberChange((1, 2), MemberProperty.LOSS_FACTOR, value=loss),
        ],
    )


@pytest.mark.parametrize("loss", [0.05, 0.3])
def test_all_three_coefficients_of_every_member_of_the_bay_are_found_at_once(loss: float) -> None:
    result = complex_one_shot(BAY, EACH, modes_of(lossy(loss), 10, BAY_DOFS))
    assert result.converged, result.stopped_because
    assert result.iterations["updating"] <= 8
    assert result.suspected == {"mass": (25, 26), "stiffness": (12, 13, 31), "damping": (1, 2)}
    wrong = {
        "mass": {25: 1.5, 26: 1.5},
        "stiffness": {12: 2.0, 13: 2.0, 31: 2.0},
        "damping": {1: loss, 2: loss},
    }
    for part, table in result.coefficients.items():
        for number, value in table.items():
            # it stops at steps of 1e-4, after which the next would be their square or so
            expected = wrong[part].get(number, float(part != "damping"))
            assert value == pytest.approx(expected, abs=1e-6), (part, number)


def test_noise_leaves_losses_where_they_are() -> None:
    # without any stated error masses and stiffnesses are suspected too freely; nothing else looks like a loss
    for seed in range(3):
        result = complex_one_shot(BAY, EACH, modes_of(lossy(0.05), 10, BAY_DOFS, NL3, seed))
        assert result.suspected["damping"] == (1, 2)
        for member in (1, 2):
            # three times the standard errors it states, 0.0027 and 0.0066
            assert result.coefficients["damping"][member] == pytest.approx(0.05, abs=0.02)


def test_real_modes_are_refused_by_field() -> None:
    with pytest.raises(InvalidInputError) as caught:
        complex_one_shot(BAY, EACH, modes_of(BAY, 5, BAY_DOFS))
    assert caught.value.context["field"] == "loss_factors"
