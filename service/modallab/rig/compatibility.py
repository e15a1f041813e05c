"""Compatibility of exciter, excitation and window."""

from modallab.core.errors import InvalidInputError
from modallab.estimation.windows import WINDOWS
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.hardware import Exciter
from modallab.rig.setup import RigSetup

_STRUCK = "impact"
# Records that repeat leak nothing, as those of blows that die out: the service's own log book of a file.
_OF_A_HAMMER = (_STRUCK, "periodic_random")


def check_compatible(setup: RigSetup) -> None:
    """Raise unless the exciter can play the signal, and the window suits it.

    Raises
    ------
    InvalidInputError
        If one of them asks for another.
    """
    analyser = setup.analyser
    kind = analyser.excitation.kind
    excitation = EXCITATIONS[kind]
    if WINDOWS[analyser.window].transient and excitation.transient is None:
        raise InvalidInputError(
            f"a window that cuts signals off spoils {kind}, which does not end within the record",
            field="analyser.window",
            value=analyser.window,
            allowed=[name for name, window in WINDOWS.items() if not window.transient],
        )
    if setup.exciter.kind == "hammer":
        _check_hammer(setup)
    elif len(setup.drives) > 1 and (excitation.phases is not None or kind == _STRUCK):
        raise InvalidInputError(
            f"several exciters with the same {kind} cannot be distinguished",
            field="excitation.kind",
            value=kind,
            allowed=["random", "periodic_random", "burst_random"],
        )


def _check_hammer(setup: RigSetup) -> None:
    """Raise if a rig with a hammer declares hardware of a shaker."""
    kind = setup.analyser.excitation.kind
    if kind not in _OF_A_HAMMER:
        raise InvalidInputError(
            f"a hammer cannot play {kind}", field="excitation.kind", value=kind, allowed=list(_OF_A_HAMMER)
        )
    if setup.stinger is not None:
        raise InvalidInputError("nothing joins a hammer to the structure", field="stinger", allowed="null")
    ideal = Exciter("hammer")
    for name in ("armature_mass", "suspension_stiffness", "suspension_damping", "coil"):
        value = getattr(setup.exciter, name)
        if value != getattr(ideal, name):
            raise InvalidInputError(
                f"{name} belongs to a shaker, not to a hammer",
                field=f"exciter.{name}",
                value=value,
                allowed=getattr(ideal, name),
            )
    gauge = setup.force_transducer
    if gauge.mass_below or gauge.stiffness:
        raise InvalidInputError(
            "the gauge sits in the hammer and leaves the structure with it",
            field="force_transducer",
            value="of a shaker",
            allowed="no mass_below, no stiffness",
        )
