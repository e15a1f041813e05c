"""Files of tests as the service takes them: what they do not say, and their form."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypedDict

_JSON = ("scale", "map", "columns", "variables")
UploadFiles = list[tuple[str, tuple[str, bytes]]]


class UploadOptions(TypedDict, total=False):
    """What the files of a test do not say, or say in their own words."""

    unit: str
    """Unit of the FRFs in the file: `g/N`, `(m/s^2)/lbf`, `mm/s/N`."""
    scale: float | Mapping[str, float]
    """Factor to `unit`, or else to SI; or a side: `{"response": 9.81, "force": 4.448}`."""
    kind: str
    """`receptance`, `mobility` or `inertance`, where neither the file nor `unit` tells it."""
    map: Mapping[str, str]
    """DoFs of named points: `{"wing_tip": "12:+Z"}`."""
    outputs: Sequence[str]
    """Response DoFs in the order of the file."""
    inputs: Sequence[str]
    """Force DoFs in the order of the file."""
    columns: Mapping[str, str | int | Sequence[str | int]]
    """Columns of text by role, by name or number from 1: `{"freq": 1, "real": "Re", "imag": "Im"}`."""
    variables: Mapping[str, str]
    """Variables of MATLAB, HDF5 or npz by role: `{"freq": "f", "values": "frf", "coherence": "coh"}`."""
    exciter: str
    """`shaker` or `hammer`, of a test without a rig."""
    window: str
    """Window of a test without a rig."""
    window_end: float
    """Height of an exponential `window` at the end of the record."""


def upload_form(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of the form: names and numbers as text, mappings as JSON, lists repeated."""
    stated = {name: value for name, value in given.items() if value is not None}
    form: dict[str, Any] = {}
    for name, value in stated.items():
        if name in _JSON:
            form[name] = json.dumps(value)
        else:
            form[name] = str(value) if isinstance(value, (str, float, int)) else [str(v) for v in value]
    return form


def upload_files(file: str | Path | bytes | Sequence[str | Path]) -> UploadFiles:
    """Return the files of the form with their names."""
    if isinstance(file, bytes):
        return [("file", ("measurement", file))]
    paths = [file] if isinstance(file, (str, Path)) else file
    return [("file", (Path(path).name, Path(path).read_bytes())) for path in paths]
