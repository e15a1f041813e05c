"""Writes the keywords of jobs, `modallab_client/options.py`, from the options of the service.

Run it with `make sync-client`; a test compares what it would write with what is there.
"""

import subprocess
import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import StrEnum
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from modallab.core.options import Options, OptionSpec
from modallab.diagnosis.options import DiagnosisOptions
from modallab.extraction import method_options as extraction
from modallab.jobs.measuring import MeasurementOptions
from modallab.updating import method_options as updating

TARGET = Path(__file__).parent / "modallab_client" / "options.py"
# Options whose JSON may also be a name with numbers.
NAMED_WITH_NUMBERS = ("completion", "expansion")
HEAD = '''"""Keywords of jobs, by kind of work; written by `client/generate_options.py`."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, TypedDict

'''


def annotation(name: str, hint: Any) -> str:
    """Return the type of a keyword as text."""
    if name in NAMED_WITH_NUMBERS:
        return "str | Mapping[str, Any]"
    if get_origin(hint) in (Union, UnionType):
        return " | ".join(annotation(name, one) for one in get_args(hint))
    if hint is NoneType:
        return "None"
    if get_origin(hint) is tuple:
        return f"Sequence[{annotation(name, get_args(hint)[0])}]"
    if is_dataclass(hint):
        return "Mapping[str, Any]"
    return "str" if issubclass(hint, StrEnum) else str(hint.__name__)


def null_named(options: type[Options], name: str, hint: Any) -> Any:
    """Return the type of an option, a text in place of null where a name stands for that."""
    (metadata,) = [f.metadata for f in fields(options) if f.name == name]  # type: ignore[arg-type]
    if not metadata["null_name"]:
        return hint
    return Union[tuple(str if member is NoneType else member for member in get_args(hint))]  # noqa: UP007


def described(spec: OptionSpec, methods: list[str]) -> str:
    """Return the text of a keyword: meaning, unit, bounds or choices, and the methods that take it."""
    unit = f", {spec.unit}" if spec.unit not in ("", "1", "-") else ""
    choices = f": {', '.join(spec.choices)}" if spec.choices else ""
    takers = f"; of {', '.join(sorted(methods))}" if methods != [""] else ""
    return f"{spec.doc}{unit}{choices}{takers}"


def typed_dict(name: str, doc: str, methods: Mapping[str, type[Options]]) -> str:
    """Return the text of a TypedDict with the options of all methods."""
    found: dict[str, tuple[str, OptionSpec, list[str]]] = {}
    for method, options in methods.items():
        hints = get_type_hints(options)
        for option, spec in options.specs().items():
            kind = annotation(option, null_named(options, option, hints[option]))
            _, _, takers = found.setdefault(option, (kind, spec, []))
            takers.append(method)
    lines = [f"class {name}(TypedDict, total=False):", f'    """{doc}"""', ""]
    for option, (kind, spec, takers) in found.items():
        text = " ".join(f'"{line} "' for line in wrapped(described(spec, takers))).removesuffix(' "') + '"'
        lines += [f"    {option}: Annotated[{kind}, {text}]"]
    return "\n".join(lines) + "\n"


def wrapped(text: str, width: int = 95) -> list[str]:
    """Return the lines of a text."""
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


def generated() -> str:
    """Return what belongs into the file."""
    updates = {name: method.options for name, method in updating.METHODS.items()}
    parts = [
        HEAD,
        typed_dict("MeasurementOptions", "Options of a virtual test.", {"": MeasurementOptions}),
        typed_dict("ExtractionOptions", "Options of the extraction methods.", extraction.OPTIONS),
        typed_dict("UpdateOptions", "Options of the updating methods.", updates),
        typed_dict("DiagnosisOptions", "Options of a diagnosis.", {"": DiagnosisOptions}),
    ]
    tool = [sys.executable, "-m", "ruff", "format", "--quiet", "--stdin-filename", str(TARGET), "-"]
    return subprocess.run(tool, input="\n\n".join(parts), capture_output=True, text=True, check=True).stdout


if __name__ == "__main__":
    TARGET.write_text(generated(), encoding="utf-8")
