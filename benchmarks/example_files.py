"""Universal files that others made: the examples of the package pyuff, read, and the FRFs among them fitted.

Not part of `make bench`: the source distribution, 26 MB, is fetched from the package index once, and kept in
the folder for temporary files.

    python -m benchmarks.example_files              # what each file is, and the modes of the one with FRFs
    python -m benchmarks.example_files plot.png     # draws the FRFs, measured and made of the modes
"""

import hashlib
import io
import tarfile
import tempfile
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.bench import parser
from modallab.core.errors import InvalidInputError
from modallab.interchange.reading import read_measurement, read_modal_model
from modallab_client import ModalLab, ModalModel

ADDRESS = (
    "https://files.pythonhosted.org/packages/07/f9/a9783d5af58513539f2d0cc5b32570d8e1cd2d7534f84811031a635a06bf/"
    "pyuff-2.4.2.tar.gz"
)
SHA256 = "7fc801385e60704fc77a04b8662fa2a5b06bce8df1b410e3d489dd5daab44146"
FRFS = "beam.uff"  # three inertances of a beam, 64,000 lines up to 6.4 kHz, no coherence
METHODS = ("dobson", "line_fit", "linear_fit", "circle_fit", "lscf")
LARGEST = 2**31
SAME_FREQUENCY = 1e-3  # relative, of frequencies of one mode
WIDTH = 36  # of a file's name


def examples() -> dict[str, bytes]:
    """Return the content of every example file by its name.

    Raises
    ------
    RuntimeError
        If what was fetched is not what it was when this was written.
    """
    archive_path = Path(tempfile.gettempdir()) / "modallab-examples" / Path(ADDRESS).name
    if not archive_path.exists():
        archive_path.parent.mkdir(exist_ok=True)
        with urllib.request.urlopen(ADDRESS, timeout=60) as reply:
            archive_path.write_bytes(reply.read())
    payload = archive_path.read_bytes()
    if hashlib.sha256(payload).hexdigest() != SHA256:
        archive_path.unlink()
        raise RuntimeError("the source distribution has another checksum; it has been thrown away")
    models = {}
    with tarfile.open(fileobj=io.BytesIO(payload)) as archive:
        for member in archive.getmembers():
            member_file = archive.extractfile(member) if Path(member.name).parent.name == "data" else None
            if member_file is not None:
                models[Path(member.name).name] = member_file.read()
    return dict(sorted(models.items()))


def said_of(content: bytes) -> str:
    """Return in words what a file was read as, or why it was not."""
    refused = ""
    for read in (_as_measurement, _as_modes):
        try:
            return read(content)
        except InvalidInputError as error:
            refused = refused or f"refused: {error}"
    return refused


def _as_measurement(content: bytes) -> str:
    frf = read_measurement(io.BytesIO(content), None, largest=LARGEST).frf
    lines = f"{len(frf.freq)} lines to {frf.freq[-1]:g} Hz"
    return f"{frf.kind}, {len(frf.outputs)} responses x {len(frf.inputs)} references, {lines}"


def _as_modes(content: bytes) -> str:
    modes = read_modal_model(io.BytesIO(content), largest=LARGEST)
    return f"{len(modes.modes)} modes at {len(modes.dofs)} DoFs, {modes.frequencies[0]:.5g} Hz first"


def report(files: dict[str, bytes], plot: Path | None) -> None:
    """Print a row for every file, and the modes of the FRFs by every method."""
    for name, content in files.items():
        begun = time.perf_counter()
        stated = said_of(content)
        print(f"{name[:WIDTH]:<{WIDTH}} {time.perf_counter() - begun:5.2f} s  {stated}", flush=True)
    with ModalLab.embedded() as lab:
        begun = time.perf_counter()
        test = lab.measurements.upload(files[FRFS])
        print(f"\n{FRFS}, uploaded in {time.perf_counter() - begun:.1f} s: {'; '.join(test.notes)}")
        models = {}
        for method in METHODS:
            begun = time.perf_counter()
            models[method] = lab.modal_models.start(test.id, method=method).result()
            left = models[method].resynthesis_error or {}
            errors = ", ".join(f"{100 * error:.2g}" for error in left.values())
            print(
                f"{method:<10} {time.perf_counter() - begun:5.1f} s, {errors} % of the FRFs left", flush=True
            )
        print(*models[METHODS[0]].notes[:1])
        _table("natural frequency, Hz", models, lambda modes, n: f"{modes.frequencies[n]:10.3f}")
        _table("loss factor, 1e-3", models, lambda modes, n: f"{1e3 * modes.loss_factors[n]:10.4f}")
        if plot is not None:
            magnitude, _ = lab.modal_models.frf(models[METHODS[0]].id).plot(test)
            figure = magnitude.get_figure(root=True)
            assert figure is not None
            figure.savefig(plot)


def _table(head: str, models: dict[str, ModalModel], cell: Callable[[ModalModel, int], str]) -> None:
    """Print a row for every mode of the first method, with what others have nearest to it."""
    print(f"\n{head:<24}" + "".join(f"{method:>11}" for method in models))
    first = next(iter(models.values()))
    for number, frequency in enumerate(first.frequencies):
        cells = []
        for modes in models.values():
            deviation = np.abs(modes.frequencies / frequency - 1)
            cells.append(cell(modes, int(deviation.argmin())) if deviation.min() < SAME_FREQUENCY else "-")
        print(f"mode {number + 1:<19}" + "".join(f"{text:>11}" for text in cells))


def main() -> None:
    """Print the table."""
    arguments = parser(__doc__)
    arguments.add_argument(
        "plot", type=Path, nargs="?", help="picture of the FRFs, measured and resynthesised"
    )
    plot = arguments.parse_args().plot
    report(examples(), plot)


if __name__ == "__main__":
    main()
