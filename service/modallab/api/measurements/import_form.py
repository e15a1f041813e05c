"""Form of an import: the files of a test, and the facts that they do not contain."""

from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

from fastapi import Depends, File, Form, UploadFile
from pydantic import TypeAdapter, ValidationError

from modallab.api.deps import Id
from modallab.api.names import WindowName
from modallab.api.wire import Translation
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.interchange.declared import DeclaredTest, ExciterKind
from modallab.interchange.reading_options import ColumnName, ReadingOptions
from modallab.interchange.settings import READING
from modallab.rig.settings import ACQUISITION

_T = TypeVar("_T")
_JSON = {"contentMediaType": "application/json"}
_SCALE: TypeAdapter[float | dict[str, float]] = TypeAdapter(float | dict[str, float])
_NAMES: TypeAdapter[dict[str, str]] = TypeAdapter(dict[str, str])
_COLUMNS: TypeAdapter[dict[str, ColumnName | list[ColumnName]]] = TypeAdapter(
    dict[str, ColumnName | list[ColumnName]]
)

UploadedFiles = Annotated[
    list[UploadFile],
    File(
        description="universal file (58), npz, HDF5, MATLAB, delimited text, FRF text, or a zip; several "
        "files of one test, each with some of its FRFs",
        min_length=1,
        max_length=READING.max_files,
    ),
]


_RigIdField = Annotated[
    Id | None, Form(description="the log book of the test; by default as the file states it")
]
_UnitField = Annotated[
    str | None, Form(max_length=40, description="of the FRFs in the file: `g/N`, `(m/s^2)/lbf`, `mm/s/N`")
]
_ScaleField = Annotated[
    str | None,
    Form(
        description='factor to `unit`, or else to SI, JSON: `9.81`, or `{"response": 9.81, "force": 4.448}`',
        json_schema_extra=_JSON,
    ),
]
_KindField = Annotated[
    FrfKind | None, Form(description="of the FRFs, if neither the file nor `unit` states it")
]
_NamesField = Annotated[
    str | None,
    Form(
        alias="map",
        description='DoFs of named points, JSON: `{"wing_tip": "12:+Z"}`',
        json_schema_extra=_JSON,
    ),
]
_OutputsField = Annotated[
    list[Translation] | None, Form(description="response DoFs in the order of the file, `1:+Z`; repeated")
]
_InputsField = Annotated[
    list[Translation] | None, Form(description="force DoFs in the order of the file, `1:+Z`; repeated")
]
_ColumnsField = Annotated[
    str | None,
    Form(
        description='columns of text by role, JSON: `{"freq": 1, "real": "Re", "imag": "Im"}`',
        json_schema_extra=_JSON,
    ),
]
_VariablesField = Annotated[
    str | None,
    Form(
        description='variables of MATLAB, HDF5 or npz by role, JSON: `{"freq": "f", "values": "frf"}`',
        json_schema_extra=_JSON,
    ),
]
_AveragesField = Annotated[
    float | None,
    Form(
        ge=1,
        le=READING.max_stated_averages,
        description="effective averages; by default the file's, or else the rig's",
    ),
]
_ExciterField = Annotated[
    ExciterKind | None, Form(description="`shaker` or `hammer`, of a test without a rig")
]
_WindowField = Annotated[WindowName | None, Form(description="window of a test without a rig")]
_WindowEndField = Annotated[
    float | None,
    Form(
        ge=ACQUISITION.window_end_bounds[0],
        le=ACQUISITION.window_end_bounds[1],
        description="height of an exponential `window` at the end of the record",
    ),
]


@dataclass(frozen=True)
class ImportForm:
    """Fields of an import beside its files."""

    rig_id: str | None
    """Rig of the test; None: it follows from the files and the declared facts."""
    options: ReadingOptions
    """Facts that the files do not contain."""
    declared: DeclaredTest
    """Facts of the test that are declared beside its files."""


def import_form(
    rig_id: _RigIdField = None,
    unit: _UnitField = None,
    scale: _ScaleField = None,
    kind: _KindField = None,
    names: _NamesField = None,
    outputs: _OutputsField = None,
    inputs: _InputsField = None,
    columns: _ColumnsField = None,
    variables: _VariablesField = None,
    averages: _AveragesField = None,
    exciter: _ExciterField = None,
    window: _WindowField = None,
    window_end: _WindowEndField = None,
) -> ImportForm:
    """Return the fields of an import beside its files."""
    stated = {
        "unit": unit,
        "scale": _parsed(scale, "scale", _SCALE),
        "kind": kind,
        "map": _parsed(names, "map", _NAMES),
        "outputs": tuple(outputs or ()),
        "inputs": tuple(inputs or ()),
        "columns": _parsed(columns, "columns", _COLUMNS),
        "variables": _parsed(variables, "variables", _NAMES),
    }
    given: dict[str, Any] = {name: value for name, value in stated.items() if value is not None}
    return ImportForm(rig_id, ReadingOptions(**given), DeclaredTest(averages, exciter, window, window_end))


def _parsed(text: str | None, field: str, expected: TypeAdapter[_T]) -> _T | None:
    """Return a field that is JSON in a form.

    Raises
    ------
    InvalidInputError
        If it is no JSON of the form expected.
    """
    try:
        return None if text is None else expected.validate_json(text)
    except ValidationError as error:
        message = error.errors()[0]["msg"]
        raise InvalidInputError(
            f"{field} is not as expected: {message}", field=field, value=text, allowed=_ALLOWED[field]
        ) from None


_ALLOWED = {
    "scale": '9.81, or {"response": 9.81, "force": 4.448}',
    "map": '{"wing_tip": "12:+Z"}',
    "columns": '{"freq": 1, "real": "Re", "imag": "Im"}',
    "variables": '{"freq": "f", "values": "frf"}',
}
ImportFormDep = Annotated[ImportForm, Depends(import_form)]
