"""Conversion of files of FRFs without a service, for `modallab convert`."""

import io
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from modallab.api.settings import ServiceSettings
from modallab.core.errors import InvalidInputError
from modallab.interchange import frf_text, hdf5, uff
from modallab.interchange.confinement import NamedFile
from modallab.interchange.declared import DeclaredTest
from modallab.interchange.reading import read_measurement
from modallab.interchange.reading_options import ReadingOptions
from modallab.interchange.settings import FRF_TEXT_FILE
from modallab.rig.measurement import Measurement
from modallab.store.codec import arrays_of

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
) -> Measurement:
    """Write the FRFs of files in another format; return them.

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
    return measurement


def lines_about(measurement: Measurement, out: Path) -> list[str]:
    """Return a line on the FRFs of a file, and one on each assumption."""
    frf = measurement.frf
    size = f"{len(frf.outputs)} responses x {len(frf.inputs)} forces, {len(frf.freq)} lines"
    lines = [f"{out}: {frf.kind.value}, {size} from {frf.freq[0]:g} to {frf.freq[-1]:g} Hz"]
    assumed = [a for a in measurement.assumed if a.quantity not in _UNUSED]
    return [*lines, *(f"assumed {a.quantity}: {a.value} ({a.reason})" for a in assumed)]
