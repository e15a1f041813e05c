from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Annotated

import numpy as np

from modallab.api.replies import attribute_docs, reply, reply_of, stored_reply
from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.place import Members, Place
from modallab.core.reply import Axes, Matrix, NanFloat, Vector
from modallab.store.base import Entry


class Sense(StrEnum):
    UP = "up"
    DOWN = "down"


@dataclass(frozen=True)
class Peak:
    """A peak of an FRF."""

    frequency: float
    """Hz, of the peak."""
    width: NanFloat
    """Hz, between the half-power points; null where one of them is not measured."""
    sense: Sense = Sense.UP
    """Direction of the peak."""


@dataclass(frozen=True, eq=False)
class Peaks:
    """Peaks of FRFs."""

    peaks: tuple[Peak, ...]
    """In order of frequency."""
    dof: Dof
    """Degree of freedom of the response."""
    at: Place
    """Where the structure was changed."""
    band: tuple[float, float]
    """Hz, low and high end."""
    level: Vector
    """(n,) m/N; null where the line is missing."""
    mac: Matrix | None
    """(n, n)."""
    constant: complex
    """1/kg."""
    gaps: Mapping[str, Mapping[str, NanFloat]]
    """By part."""
    shapes: ComplexArray
    """(n_dof, n) in `/arrays`."""
    curve: Annotated[ComplexArray, Axes(1)]
    """(n_freq,) m/N."""
    parts: Mapping[str, FloatArray | ComplexArray] = field(default_factory=dict)
    """In `/arrays`."""
    seed: int = 0
    """Seed of the noise."""
    label: str | None = None
    """Free text."""


PEAKS = Peaks(
    peaks=(Peak(20.0, float("nan"), Sense.DOWN),),
    dof=Dof.parse("5:+Y"),
    at=Members((3, 4)),
    band=(1.0, 2.0),
    level=np.array([1.0, np.nan]),
    mac=np.eye(2),
    constant=1 + 2j,
    gaps={"before": {"frf": float("inf")}},
    shapes=np.ones((3, 2), complex),
    curve=np.array([1j]),
)


def entry() -> Entry:
    return Entry("a1", "peaks", "me", "2026-01-01T00:00:00Z", "0.1.0", {"measurement_id": "b2"}, 7)


def test_attribute_docstrings_describe_the_fields() -> None:
    assert attribute_docs(Peak)["frequency"] == "Hz, of the peak."
    schema = reply_of(Peak).model_json_schema()
    assert schema["properties"]["width"]["description"].startswith("Hz, between")
    assert schema["description"] == "A peak of an FRF."
    assert schema["$defs"]["Sense"]["enum"] == ["up", "down"]


def test_values_stand_as_json_has_them() -> None:
    told = reply_of(Peaks).model_validate(PEAKS).model_dump(mode="json")
    assert told == {
        "peaks": [{"frequency": 20.0, "width": None, "sense": "down"}],
        "dof": "5:+Y",
        "at": {"members": [3, 4]},
        "band": [1.0, 2.0],
        "level": [1.0, None],
        "mac": [[1.0, 0.0], [0.0, 1.0]],
        "constant": [1.0, 2.0],
        "gaps": {"before": {"frf": None}},
        "curve": [[0.0, 1.0]],
        "seed": 0,
        "label": None,
    }


def test_a_matrix_that_is_not_there_is_null() -> None:
    assert reply_of(Peaks).model_validate(replace(PEAKS, mac=None, at=None)).model_dump()["mac"] is None


def test_a_stored_value_has_its_entry_and_what_was_added() -> None:
    model = stored_reply(Peaks, "PeaksReply", leave_out=("label", "seed"), n=(int, "Number of peaks."))
    told = model.of(PEAKS, entry(), n=1).model_dump(mode="json")
    assert (told["id"], told["n"], told["seed"], told["made_from"]) == ("a1", 1, 7, {"measurement_id": "b2"})
    assert "label" not in told
    assert model.model_json_schema()["properties"]["n"]["description"] == "Number of peaks."


def test_a_field_may_get_another_type() -> None:
    model = reply(Peak, "WidePeak", width=(str, "In words."))
    assert model.model_json_schema()["properties"]["width"]["type"] == "string"
