"""The stingers of the thesis's experiment: bending and axial resonances of appendix D."""

import numpy as np
import pytest

from modallab.rig.settings import STINGER
from modallab.rig.stinger import StingerRod, axial_frequency
from tests.published.tables import table

PRINTED = table("stinger_1992")
BENDING, AXIAL, MATERIAL = PRINTED["bending"], PRINTED["axial"], PRINTED["material"]


def rod(which: str) -> StingerRod:
    return StingerRod(
        MATERIAL["diameter"], PRINTED["lengths"][which], MATERIAL["modulus"], MATERIAL["density"]
    )


def by_the_thesis(which: str) -> float:
    """Equation D.3 with the printed constant."""
    one = rod(which)
    return float(BENDING["constant"] * one.diameter / one.length**2 * np.sqrt(one.modulus / one.density))


@pytest.mark.parametrize("which", ["long", "short"])
def test_the_first_bending_frequency_is_the_printed_one_by_the_printed_formula(which: str) -> None:
    assert by_the_thesis(which) == pytest.approx(
        BENDING[which], rel=5e-5, abs=0.5
    )  # speed of sound rounded; whole Hz


def test_the_printed_constant_takes_the_root_of_the_frequency_equation_to_be_three_half_pi() -> None:
    assert (
        pytest.approx((1.5 * np.pi) ** 2 / (8 * np.pi), abs=1e-3) == BENDING["constant"]
    )  # cut, not rounded
    exact = STINGER.clamped_root**2 / (8 * np.pi)
    assert np.cosh(STINGER.clamped_root) * np.cos(STINGER.clamped_root) == pytest.approx(1.0, abs=1e-9)
    assert round(exact, 3) == BENDING["exact_constant"]


@pytest.mark.parametrize("which", ["long", "short"])
def test_the_exact_bending_frequency_is_eight_tenths_of_a_percent_above_the_printed_one(which: str) -> None:
    ratio = rod(which).bending_frequency / BENDING[which]
    assert ratio == pytest.approx(BENDING["exact_constant"] / BENDING["constant"], abs=1e-3)  # three digits


def test_the_axial_stiffness_is_the_printed_one() -> None:
    assert rod("long").axial_stiffness == pytest.approx(AXIAL["long_stiffness"], abs=0.5e3)
    assert rod("short").axial_stiffness == pytest.approx(AXIAL["short_stiffness"], rel=5e-4)


def test_the_axial_frequency_is_the_printed_one_but_for_two_digits_that_changed_places() -> None:
    mass = MATERIAL["armature_mass"]
    assert axial_frequency(rod("long").axial_stiffness, mass) == pytest.approx(AXIAL["long"], abs=1.0)
    found = axial_frequency(AXIAL["short_stiffness"], mass)
    assert found == pytest.approx(AXIAL["short"], abs=0.5)
    as_printed = str(round(AXIAL["short_as_printed"]))
    assert sorted(as_printed) == sorted(str(round(found)))
    assert abs(found - AXIAL["short_as_printed"]) > 50
