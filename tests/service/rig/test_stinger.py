"""The stinger as declared, and its own resonances."""

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.structure import Material, Section, Support
from modallab.rig.hardware import Exciter, ForceTransducer
from modallab.rig.setup import RigSetup
from modallab.rig.stinger import Stinger, StingerRod, StingerStiffness
from modallab.rig.stinger_check import stinger_axial_check, stinger_checks
from tests.rigs import rig

LONG = {"diameter": 1.5e-3, "length": 67e-3, "modulus": 2.07e11, "density": 7850.0}


def test_a_rod_s_first_bending_mode_is_that_of_a_beam_between_two_clamps() -> None:
    rod = StingerRod(**LONG)
    clamped = beam(
        length=rod.length,
        n_elements=30,
        section=Section(np.pi / 4 * rod.diameter**2, np.pi / 64 * rod.diameter**4),
        material=Material(rod.modulus, rod.density),
        supports=(Support(1, ("Y", "RZ")), Support(31, ("Y", "RZ"))),
    )
    found = assemble(clamped).modes().frequencies[0]
    # 30 elements err by some 1e-7, falling with the fourth power of their number
    assert rod.bending_frequency == pytest.approx(found, rel=1e-6)


def test_its_stiffness_is_that_of_a_beam_with_one_end_clamped() -> None:
    rod = StingerRod(**LONG)
    structure = beam(
        length=rod.length,
        n_elements=1,
        section=Section(np.pi / 4 * rod.diameter**2, np.pi / 64 * rod.diameter**4),
        material=Material(rod.modulus, rod.density),
        supports=(Support(2, ("Y", "RZ")),),
    )
    lateral, turning = assemble(structure).stiffness.toarray().diagonal()
    assert rod.bending_stiffness == pytest.approx(turning)
    assert StingerStiffness(None, turning, lateral).length == pytest.approx(rod.length)


@pytest.mark.parametrize("name", list(LONG))
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), 1e20])
def test_a_rod_that_is_none_is_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(InvalidInputError, match=name) as caught:
        StingerRod(**(LONG | {name: value}))
    assert caught.value.context["field"] == f"stinger.{name}"


@pytest.mark.parametrize(
    "values",
    [
        {"axial_stiffness": 0.0},
        {"bending_stiffness": -1.0},
        {"lateral_stiffness": 1e4},
        {"lateral_stiffness": -1.0},
    ],
)
def test_stiffness_that_no_stinger_has_is_refused_by_name(values: dict[str, float]) -> None:
    with pytest.raises(InvalidInputError, match=next(iter(values))):
        StingerStiffness(**values)


def test_a_slack_wire_is_no_stinger() -> None:
    with pytest.raises(InvalidInputError, match="axial stiffness"):
        StingerRod(1e-5, 10.0, 1e7, 1000.0)


def shaken(
    stinger: Stinger | None, band: float, armature: float = 0.02, gauge: float | None = None
) -> RigSetup:
    return rig(
        1,
        exciter=Exciter(armature_mass=armature),
        stinger=stinger,
        force_transducer=ForceTransducer(stiffness=gauge),
        analyser={"frequency_max": band},
    )


@pytest.mark.parametrize(
    ("band", "kept"), [(1200.0, [True, True]), (1600.0, [False, True]), (3200.0, [False, False])]
)
def test_a_stinger_should_resonate_above_the_band(band: float, kept: list[bool]) -> None:
    found = stinger_checks(shaken(StingerRod(**LONG), band))  # 1,528 Hz and 2,630 Hz
    assert [check.fulfilled for check in found] == kept


def test_a_soft_gauge_lowers_the_armature_s_resonance() -> None:
    alone = stinger_axial_check(shaken(StingerStiffness(4e6), 800.0))
    with_gauge = stinger_axial_check(shaken(StingerStiffness(4e6), 800.0, gauge=4e6))
    assert alone is not None
    assert with_gauge is not None
    assert with_gauge.axial_frequency / alone.axial_frequency == pytest.approx(np.sqrt(0.5))


def test_without_stinger_or_armature_there_is_nothing_to_check() -> None:
    assert stinger_checks(shaken(None, 800.0)) == ()
    assert stinger_checks(shaken(StingerStiffness(4e6), 800.0, armature=0.0)) == ()
