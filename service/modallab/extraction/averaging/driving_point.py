"""What the drive point's own modal constant says of a mode, and of the scale of its shape."""

import math

from modallab.core.dof import Dof

CLEAR = 3.0  # standard errors, before a phase is held against a mode
TURNED = math.radians(20.0)  # closely spaced modes of light structures stay below
VAGUE = 0.2  # relative error of a shape's scale


def driving_point_flags(constant: complex, error: float, dof: Dof, sense: int) -> tuple[str, ...]:
    """Return what is wrong with a drive point's modal constant; nothing if it is as it should be.

    Where force and response are at one point, `A_11 = phi_1^2`: real and positive for a mode whose points
    move in phase, and turned by little if they hardly do not. All of a shape is scaled by its root.

    Parameters
    ----------
    constant, error
        1/kg, of receptance, and the standard error of either part.
    dof
        The drive point as the response has it.
    sense
        -1 where force and accelerometer point opposite ways, else 1.
    """
    own = sense * constant
    size = abs(own)
    flags = []
    if own.real < 0:
        flags.append(f"drive point {dof} has a modal constant of the wrong sign")
    elif abs(math.atan2(own.imag, own.real)) > TURNED and abs(own.imag) > CLEAR * error:
        turn = math.degrees(math.atan2(own.imag, own.real))
        flags.append(f"drive point {dof} has a modal constant turned by {turn:.0f} degrees")
    if size and error > 2 * VAGUE * size:  # the root has half the relative error
        flags.append(
            f"drive point {dof} hardly shows the mode: its scale is known to {50 * error / size:.0f} %"
        )
    return tuple(flags)
