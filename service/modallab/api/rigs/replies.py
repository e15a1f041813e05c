"""Replies of rigs."""

from dataclasses import dataclass
from typing import Any

from modallab.api.replies import replies_of, reply, reply_of, stored_reply
from modallab.core.physics_warning import PhysicsWarning
from modallab.rig.checks import CheckResult
from modallab.rig.plausibility import rig_warnings
from modallab.rig.setup import RigSetup
from modallab.store.base import Entry

_DRIVE: tuple[Any, str] = (str, "First drive point.")
SetupReply: Any = reply(RigSetup, "RigSetup", drive=_DRIVE)
RigReply = stored_reply(
    RigSetup,
    "Rig",
    drive=_DRIVE,
    warnings=(replies_of(PhysicsWarning), "What is surely a slip of a unit or a setting."),
)


@dataclass(frozen=True)
class RigChecks:
    """Rules of good practice, evaluated for a rig on a structure."""

    rig_id: str
    """Rig that was checked."""
    structure_id: str
    """Structure that the rig tests."""
    checks: tuple[CheckResult, ...]
    """One result a rule."""


ChecksReply: Any = reply_of(RigChecks)


def rig_reply(setup: RigSetup, entry: Entry) -> Any:
    """Return the reply of a stored rig."""
    return RigReply.of(setup, entry, drive=str(setup.drive), warnings=rig_warnings(setup))


def setup_reply(setup: RigSetup) -> Any:
    """Return the reply of a rig that is part of a measurement."""
    names = SetupReply.model_fields.keys() - {"drive"}
    read = {name: getattr(setup, name) for name in names}
    return SetupReply.model_validate({**read, "drive": str(setup.drive)})


def rig_request(setup: RigSetup) -> dict[str, Any]:
    """Return the body of `POST /v1/rigs` that declares a rig, every part and default in it."""
    body: dict[str, Any] = setup_reply(setup).model_dump(mode="json")
    del body["drive"]  # the first of the drives
    if not setup.suspension.at:
        body["suspension"] = None
    return body
