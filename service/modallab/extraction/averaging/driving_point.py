"""Checks of the modal constant of a drive point."""

import math

from modallab.core.dof import Dof
from modallab.extraction.averaging.settings import DRIVE_POINT


def driving_point_flags(constant: complex, error: float, dof: Dof, sense: int) -> tuple[str, ...]:
    """Return flags on a drive point's modal constant; none if it is plausible.

    At a drive point `A_11 = phi_1^2`: real and positive for a real mode, with a small phase for a nearly real
    one. The whole shape is scaled by its root.

    Parameters
    ----------
    constant, error
        1/kg, of receptance, and the standard error of real and imaginary part.
    dof
        Degree of freedom of the response at the drive point.
    sense
        -1 where force and accelerometer have opposite directions, else 1.
    """
    signed_constant = sense * constant
    size = abs(signed_constant)
    flags = []
    if signed_constant.real < 0:
        flags.append(f"drive point {dof} has a modal constant of the wrong sign")
    elif (
        abs(math.atan2(signed_constant.imag, signed_constant.real)) > math.radians(DRIVE_POINT.largest_phase)
        and abs(signed_constant.imag) > DRIVE_POINT.phase_errors * error
    ):
        turn = math.degrees(math.atan2(signed_constant.imag, signed_constant.real))
        flags.append(f"drive point {dof} has a modal constant with a phase of {turn:.0f} degrees")
    if size and error > 2 * DRIVE_POINT.largest_scale_error * size:  # the root has half the relative error
        flags.append(
            f"drive point {dof} hardly shows the mode: its scale is known to {50 * error / size:.0f} %"
        )
    return tuple(flags)
