"""The lab log of a measurement: what was declared and what was asked, and nothing of the truth."""

from collections.abc import Mapping
from typing import Any, Self

from modallab.api.rigs.schemas import setup_out
from modallab.api.wire import StoredEntry
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.store.base import Entry


class LogOut(StoredEntry):
    """What was declared and asked. With the truth, which its owner has, it makes the same bytes again.

    `rig` is what declares that rig again; `route` and `seed` are null where FRFs were brought from elsewhere.
    To the byte a measurement is one of its `version` and of the `libraries` that computed it.
    """

    route: str | None
    """route of a simulated measurement; null where FRFs were imported"""
    libraries: Mapping[str, str]
    """versions of the libraries that computed it"""
    rig_id: str
    """id of the rig"""
    rig: dict[str, Any]
    """body of `POST /v1/rigs` that declares the same rig"""
    averages: float
    """1, effective number of averages"""
    notes: list[str]
    """remarks of the measurement"""

    @classmethod
    def of(cls, measurement: Measurement, entry: Entry) -> Self:
        """Return what the contract shows of a measurement's log."""
        return cls(
            **cls.fields(entry),
            route=measurement.route,
            libraries=measurement.libraries,
            rig_id=entry.inputs["rig_id"],
            rig=declared(measurement.setup),
            averages=measurement.averages,
            notes=list(measurement.notes),
        )


def declared(setup: RigSetup) -> dict[str, Any]:
    """Return a rig as a request that declares it, every part and default in it."""
    body = setup_out(setup)
    del body["drive"]  # the first of the drives
    if not setup.suspension.at:
        body["suspension"] = None
    return body
