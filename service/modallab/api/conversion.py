"""Conversion of files of FRFs without a service, for `modallab convert`."""

import io
import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from modallab.api.settings import ServiceSettings
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.interchange import frf_text, hdf5, uff
from modallab.interchange.confinement import NamedFile
from modallab.interchange.declared import DeclaredTest
from modallab.interchange.reading import read_measurement
from modallab.interchange.reading_options import ReadingOptions
from modallab.interchange.settings import FRF_TEXT_FILE
from modallab.rig.measurement import Measurement
from modallab.store.codec import arrays_of

_MAPPINGS = ("map", "columns", "variables")
_UNUSED = ("exciter", "window")  # assumptions that no file tells


def _npz(measurement: Measurement) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays_of(measurement))
    return buffer.getvalue()


_WRITERS: dict[str, Callable[[Measurement], bytes]] = {
    ".uff": uff.write,
    ".unv": uff.write,
    ".npz": _npz,
    ".h5": hdf5.write,
    ".hdf5": hdf5.write,
    ".frf": lambda measurement: frf_text.write(measurement, FRF_TEXT_FILE.all_decimals),
}


def convert_files(
    files: Sequence[Path], out: Path, options: ReadingOptions, averages: float | None
) -> list[str]:
    """Write the FRFs of files in another format; return a line on them, and one on each assumption.

    Raises
    ------
    InvalidInputError
        If a file cannot be read, or no format has the ending of the file to write.
    """
    writer = _WRITERS.get(out.suffix.lower())
    if writer is None:
        raise InvalidInputError(
            f"no format is written to files that end in {out.suffix!r}",
            field="out",
            value=out.name,
            allowed=list(_WRITERS),
        )
    with ExitStack() as stack:
        named = [NamedFile(path.name, stack.enter_context(path.open("rb"))) for path in files]
        largest = ServiceSettings.model_fields["upload_limit"].default
        measurement = read_measurement(
            named, None, largest=largest, options=options, declared=DeclaredTest(averages)
        )
    out.write_bytes(writer(measurement))
    frf = measurement.frf
    size = f"{len(frf.outputs)} responses x {len(frf.inputs)} forces, {len(frf.freq)} lines"
    lines = [f"{out}: {frf.kind.value}, {size} from {frf.freq[0]:g} to {frf.freq[-1]:g} Hz"]
    assumed = [a for a in measurement.assumed if a.quantity not in _UNUSED]
    return [*lines, *(f"assumed {a.quantity}: {a.value} ({a.reason})" for a in assumed)]


def options_of(flags: Mapping[str, Any]) -> ReadingOptions:
    """Return the options that flags state: mappings as lists of `name=value`, a scale as JSON.

    Raises
    ------
    InvalidInputError
        If a flag cannot be read.
    """
    stated = {name: value for name, value in flags.items() if value not in (None, [])}
    try:
        scale = json.loads(stated.pop("scale", "1"))
        kind = FrfKind(stated.pop("kind")) if "kind" in stated else None
    except ValueError:
        raise InvalidInputError(
            "a scale is a number or JSON, a kind one of those allowed",
            field="scale",
            allowed=["9.81", '{"response": 9.81}', *FrfKind],
        ) from None
    if not isinstance(scale, (int, float, dict)):
        raise InvalidInputError("a scale is a number, or JSON", field="scale", value=str(scale))
    given: dict[str, Any] = {
        name: _mapping(name, value) if name in _MAPPINGS else value for name, value in stated.items()
    }
    given |= {name: tuple(given[name]) for name in ("outputs", "inputs") if name in given}
    return ReadingOptions(scale=scale, kind=kind, **given)


def _mapping(name: str, texts: list[str]) -> dict[str, Any]:
    """Return flags `name=value` as a mapping; values that several flags give one name, as a tuple."""
    mapping: dict[str, Any] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not (key and equals and value):
            raise InvalidInputError("not of the form name=value", field=name, value=text)
        several = (*mapping.get(key, ()), value) if name == "columns" else value
        mapping[key] = several
    return mapping
