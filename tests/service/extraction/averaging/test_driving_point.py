import numpy as np

from modallab.core.dof import Dof
from modallab.extraction.averaging.driving_point import driving_point_flags

DRIVE = Dof(1, "Y")


def test_a_constant_that_is_real_and_positive_is_as_it_should_be() -> None:
    assert driving_point_flags(0.7 + 0.01j, 0.01, DRIVE, 1) == ()


def test_a_constant_of_the_wrong_sign_is_flagged_unless_the_sensor_looks_the_other_way() -> None:
    flags = driving_point_flags(-0.7 + 0.01j, 0.01, DRIVE, 1)
    assert flags == ("drive point 1:+Y has a modal constant of the wrong sign",)
    assert driving_point_flags(-0.7 + 0.01j, 0.01, Dof(1, "Y", -1), -1) == ()


def test_a_turn_beyond_its_error_is_flagged_in_degrees() -> None:
    turned = 0.5 * np.exp(1j * np.deg2rad(30))
    assert driving_point_flags(turned, 0.01, DRIVE, 1) == (
        "drive point 1:+Y has a modal constant with a phase of 30 degrees",
    )
    assert driving_point_flags(turned, 0.1, DRIVE, 1) == ()  # 0.25 beside an error of 0.1 is chance


def test_a_drive_point_at_a_node_gives_no_scale() -> None:
    (flag,) = driving_point_flags(0.01 + 0j, 0.005, DRIVE, 1)
    assert flag == "drive point 1:+Y hardly shows the mode: its scale is known to 25 %"
    assert driving_point_flags(0j, 0.0, DRIVE, 1) == ()
