import sys
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from modallab_client._read import read_as
from tests.architecture.test_names import ROOT

sys.path.insert(0, str(ROOT / "client"))
import generate_models


def test_result_types_are_those_of_the_document() -> None:
    for path, text in generate_models.generated().items():
        assert path.read_text() == text, "run `make openapi sync-client`"


def test_a_schema_becomes_a_documented_dataclass() -> None:
    schema = {
        "type": "object",
        "description": "A peak.",
        "required": ["frequency", "pairs"],
        "properties": {
            "frequency": {"type": "number", "description": "Hz, of the peak."},
            "pairs": {"type": "array", "items": {"type": "array", "prefixItems": [{"type": "integer"}] * 2}},
            "level": {"anyOf": [{"type": "number"}, {"type": "null"}]},
            "verdict": {"enum": ["good", "bad"], "default": "good"},
            "values": {"type": "array", "format": "array", "items": {"type": "number"}},
        },
    }
    text = generate_models.dataclass_of("Peak", schema, {}, {})
    assert '    frequency: float\n    """Hz, of the peak."""' in text
    assert "    pairs: tuple[tuple[int, int], ...]" in text
    assert "    level: float | None = None" in text
    assert "    verdict: Literal['good', 'bad'] = 'good'" in text
    assert "    values: FloatArray | None = None" in text


@dataclass(frozen=True, kw_only=True)
class First:
    kind: Literal["first"]
    value: float


@dataclass(frozen=True, kw_only=True)
class Second:
    kind: Literal["second"]
    values: NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Reply:
    part: First | Second
    constant: complex
    by_member: dict[str, float] = field(default_factory=dict)
    poles: NDArray[np.complex128] | None = None


def test_a_union_is_told_by_its_kind() -> None:
    reply = {"part": {"kind": "second", "values": [1.0, None]}, "constant": [1.0, -2.0]}
    read = read_as(Reply, reply)
    assert isinstance(read.part, Second)
    np.testing.assert_array_equal(read.part.values, [1.0, np.nan])
    assert not read.part.values.flags.writeable
    assert read.constant == 1 - 2j
    assert isinstance(read_as(Reply, reply | {"part": {"kind": "first", "value": 1}}).part, First)


def test_member_numbers_are_numbers_and_pairs_are_complex() -> None:
    reply: dict[str, Any] = {"part": {"kind": "first", "value": 1}, "constant": [0, 0]}
    read = read_as(Reply, reply | {"by_member": {"12": 1.5}, "poles": [[1.0, 2.0]]})
    members: dict[Any, float] = read.by_member
    assert members == {12: 1.5}
    assert read.poles is not None
    np.testing.assert_array_equal(read.poles, [1 + 2j])


@pytest.mark.parametrize("missing", ["part", "constant"])
def test_a_part_that_is_missing_is_refused_by_name(missing: str) -> None:
    reply = {"part": {"kind": "first", "value": 1}, "constant": [0, 0]}
    del reply[missing]
    with pytest.raises(KeyError, match=missing):
        read_as(Reply, reply)
