"""The kind of FRF that a reply carries: as measured, or another."""

from typing import Annotated

from fastapi import Query

from modallab.core.frf import FrfKind
from modallab.rig.measurement import Measurement

KindWanted = Annotated[
    FrfKind | None,
    Query(description="of the FRFs; as measured by default. Receptance and mobility leave 0 Hz out"),
]


def measured_as(kind: FrfKind | None, measurement: Measurement) -> Measurement:
    """Return a measurement as the kind that was asked for, or as it is."""
    return measurement if kind is None else measurement.to(kind)
