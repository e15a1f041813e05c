"""Cases of `strange_files`: FRFs in the files of pyuff, scipy.io, h5py and plain text, whole and damaged."""

import io
import tempfile
import warnings
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyuff
import scipy.io
from numpy.typing import NDArray

GRAVITY, POUND_FORCE = 9.80665, 4.4482216152605
N_LINES = 401
LONG = 51_201
N_DAMAGED = 200
Files = tuple[tuple[str, bytes], ...]


@dataclass(frozen=True, eq=False)
class Case:
    """Files of one test, and what they hold in SI units."""

    name: str
    files: Files
    freq: NDArray[Any]
    values: NDArray[Any]
    outputs: tuple[str, ...] = ("1:+Z",)
    inputs: tuple[str, ...] = ("1:+Z",)
    coherence: NDArray[Any] | None = None
    options: dict[str, Any] = field(default_factory=dict)


@cache
def curves(n_out: int = 1, n_in: int = 1, start: float = 0.0, n_lines: int = N_LINES) -> tuple[Any, Any]:
    """Return frequencies and FRFs of six digits, (n_lines, n_out, n_in)."""
    rng = np.random.default_rng(19)
    freq = start + 0.5 * np.arange(n_lines)
    parts = np.round(rng.normal(size=(2, n_lines, n_out, n_in)), 4)
    return freq, parts[0] + 1j * parts[1]


def coherence_of(n_out: int) -> NDArray[Any]:
    """Return coherences of single precision."""
    return np.random.default_rng(5).uniform(0.5, 1.0, (N_LINES, n_out)).astype(np.float32)


def strange_cases() -> list[Case]:
    """Return all cases."""
    return [*_universal(), *_matlab(), *_hdf5_and_npz(), *_text()]


# --- universal files ---------------------------------------------------------------------------------


def universal(*sets: dict[str, Any]) -> bytes:
    """Return datasets as pyuff writes them."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # pyuff leaves files of binary data open
        path = Path(folder) / "x.uff"
        for one in sets:
            pyuff.UFF(str(path)).write_sets([one], "add")
        return path.read_bytes()


def function(freq: Any, data: Any, node: int = 1, source: int = 1, **changed: Any) -> dict[str, Any]:
    """Return an FRF as pyuff has it."""
    fields: dict[str, Any] = {"binary": 0, "func_type": 4, "rsp_node": node, "rsp_dir": 3, "ref_node": source}
    fields |= {"ref_dir": 3, "data": data, "x": freq, "abscissa_spacing": 1, "abscissa_spec_data_type": 18}
    fields |= {"ordinate_spec_data_type": 12, "orddenom_spec_data_type": 13}
    return dict(pyuff.prepare_58(**(fields | changed)))


def _universal() -> Iterator[Case]:
    f, h = curves()
    one = h[:, 0, 0]
    for kind, number in (("receptance", 8), ("mobility", 11), ("inertance", 12)):
        for binary in (0, 1):
            payload = universal(function(f, one, binary=binary, ordinate_spec_data_type=number))
            yield Case(f"uff, {kind}, {'binary' if binary else 'text'}", (("a.uff", payload),), f, h)
    uneven = universal(function(f, one, abscissa_spacing=0))
    yield Case("uff, frequencies listed", (("a.uff", uneven),), f, h)
    yield Case("uff, line ends of Windows", (("a.unv", uneven.replace(b"\n", b"\r\n")),), f, h)
    for unit, number, factor in (
        ("g/N", 12, GRAVITY),
        ("(m/s^2)/lbf", 12, 1 / POUND_FORCE),
        ("mm/s/N", 11, 1e-3),
        ("in/lbf", 8, 0.0254 / POUND_FORCE),
    ):
        payload = universal(function(f, one, ordinate_spec_data_type=number, ordinate_axis_units_lab="g"))
        yield Case(f"uff, {unit}", (("a.uff", payload),), f, h * factor, options={"unit": unit})
    unknown = universal(function(f, one, ordinate_spec_data_type=0, orddenom_spec_data_type=0))
    yield Case("uff, unknown data types", (("a.uff", unknown),), f, h * GRAVITY, options={"unit": "g/N"})
    named = universal(function(f, one, 0, rsp_dir=0, rsp_ent_name="wing_tip"))
    names = {"map": {"wing_tip": "12:+Z"}}
    yield Case("uff, a named point", (("a.uff", named),), f, h, ("12:+Z",), options=names)
    f, h = curves(start=50.0)
    yield Case("uff, cut band", (("a.uff", universal(function(f, h[:, 0, 0]))),), f, h)
    f, h = curves(n_lines=LONG)
    yield Case("uff, 51,201 lines", (("a.uff", universal(function(f, h[:, 0, 0], binary=1))),), f, h)
    yield from _several_universal()


def _several_universal() -> Iterator[Case]:
    f, h = curves(n_out=3)
    outputs = ("1:+Z", "2:+Z", "3:+Z")
    sets = [function(f, h[:, j, 0], j + 1) for j in range(3)]
    files = tuple((f"{j}.uff", universal(one)) for j, one in enumerate(sets))
    yield Case("uff, one FRF a file, in one request", files, f, h, outputs)
    yield Case("uff, one FRF a file, in a zip", (("a.zip", zipped(files)),), f, h, outputs)
    coherence = coherence_of(3)
    beside = [function(f, real, j + 1, **_COHERENCE) for j, real in enumerate(coherence.T.astype(float))]
    payload = universal(*sets, *beside)
    yield Case(
        "uff, coherence of single precision", (("a.uff", payload),), f, h, outputs, coherence=coherence
    )
    zeros = [function(f, np.zeros(N_LINES), j + 1, **_COHERENCE) for j in range(3)]
    yield Case("uff, coherence of zeros", (("a.uff", universal(*sets, *zeros)),), f, h, outputs)
    f, h = curves(n_in=3)
    roved = universal(*[function(f, h[:, 0, i], 1, i + 1) for i in range(3)])
    yield Case("uff, roving hammer", (("a.uff", roved),), f, h, ("1:+Z",), outputs)


_COHERENCE = {"func_type": 6, "ord_data_type": 4, "ordinate_spec_data_type": 0, "orddenom_spec_data_type": 0}


def zipped(files: Files) -> bytes:
    """Return files as an archive."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files:
            archive.writestr(name, content)
    return buffer.getvalue()


# --- MATLAB ------------------------------------------------------------------------------------------


def matlab(*, compressed: bool = False, **variables: Any) -> Files:
    """Return variables as scipy writes them."""
    buffer = io.BytesIO()
    scipy.io.savemat(buffer, variables, do_compression=compressed)
    return (("test.mat", buffer.getvalue()),)


def _matlab() -> Iterator[Case]:
    f, h = curves(n_out=3)
    outputs, flat = ("1:+Z", "2:+Z", "3:+Z"), h[:, :, 0]
    yield Case("mat, f and H", matlab(f=f, H=flat), f, h, outputs)
    yield Case("mat, compressed", matlab(compressed=True, freq=f, frf=flat), f, h, outputs)
    yield Case("mat, lines last", matlab(f=f, H=flat.T), f, h, outputs)
    yield Case("mat, lines last, 3-D", matlab(f=f, H=np.moveaxis(h, 0, 2)), f, h, outputs)
    yield Case("mat, a structure", matlab(test={"f": f, "H": flat, "note": "free"}), f, h, outputs)
    yield Case("mat, names of its own", matlab(ax=f, q=flat, temperature=20.0), f, h, outputs)
    stated = {"variables": {"freq": "f1", "H": "H1", "coherence": "C1"}}
    two: dict[str, Any] = {"f1": f, "f2": 2 * f, "H1": flat, "H2": 2 * flat, "C1": coherence_of(3)}
    yield Case(
        "mat, two tests, stated", matlab(**two), f, h, outputs, coherence=coherence_of(3), options=stated
    )
    yield Case("mat, g/N", matlab(f=f, H=flat), f, h * GRAVITY, outputs, options={"unit": "g/N"})
    yield Case("mat, accelerance", matlab(f=f, accelerance=flat), f, h, outputs)
    cells = np.array(["1 Z", "12 Z", "tail"], object)
    mapped = {"map": {"tail": "99:-Y"}}
    names = ("1:+Z", "12:+Z", "99:-Y")
    yield Case("mat, cells with names", matlab(f=f, H=flat, outputs=cells), f, h, names, options=mapped)
    directions: dict[str, Any] = {
        "outputs": np.array([4, 5, 6]),
        "output_directions": np.array(["X", "Y", "Z"]),
    }
    yield Case("mat, nodes and directions", matlab(f=f, H=flat, **directions), f, h, ("4:+X", "5:+Y", "6:+Z"))
    parts: dict[str, Any] = {"H_real": flat.real, "H_imag": flat.imag}
    yield Case("mat, real and imaginary parts", matlab(f=f, **parts), f, h, outputs)
    f, h = curves(n_out=2, n_in=3)
    yield Case(
        "mat, two responses, three forces", matlab(f=f, H=h), f, h, ("1:+Z", "2:+Z"), ("1:+Z", "2:+Z", "3:+Z")
    )
    f, h = curves(n_lines=LONG)
    yield Case("mat, 51,201 lines", matlab(f=f, H=h[:, 0, 0]), f, h)


# --- HDF5 and npz ------------------------------------------------------------------------------------


def hdf5(name: str = "a.h5", userblock: bool = False, **arrays: Any) -> Files:
    """Return arrays as h5py writes them; with a user block as MATLAB 7.3."""
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", userblock_size=512 if userblock else 0) as file:
        for path, array in arrays.items():
            dataset = file.create_dataset(
                path.replace("__", "/"), data=_of_matlab(array) if userblock else array
            )
            if userblock:
                dataset.attrs["MATLAB_class"] = np.bytes_("double")
    content = buffer.getvalue()
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    return ((name, head + content[len(head) :] if userblock else content),)


def _of_matlab(array: Any) -> Any:
    array = np.atleast_2d(np.asarray(array)).T
    if not np.iscomplexobj(array):
        return array
    pairs = np.empty(array.shape, [("real", float), ("imag", float)])
    pairs["real"], pairs["imag"] = array.real, array.imag
    return pairs


def npz(**arrays: Any) -> Files:
    """Return arrays as numpy writes them."""
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return (("a.npz", buffer.getvalue()),)


def _hdf5_and_npz() -> Iterator[Case]:
    f, h = curves(n_out=3)
    outputs, flat = ("1:+Z", "2:+Z", "3:+Z"), h[:, :, 0]
    points = {"outputs": list(outputs), "inputs": ["1:+Z"]}
    whole = {"freq": f, "values": h, "kind": "inertance", **points}
    yield Case("hdf5, its own names", hdf5(**whole), f, h, outputs)
    yield Case(
        "hdf5, accelerance, 2-D", hdf5(**whole | {"kind": "accelerance", "values": flat}), f, h, outputs
    )
    yield Case("hdf5, a group", hdf5(test__f=f, test__frf=flat), f, h, outputs)
    yield Case("mat 7.3, f and H", hdf5("a.mat", True, f=f, H=flat), f, h, outputs)
    stated = {"variables": {"freq": "x", "H": "y"}, "unit": "mm/s/N"}
    yield Case("mat 7.3, stated", hdf5("a.mat", True, x=f, y=flat), f, h * 1e-3, outputs, options=stated)
    yield Case("npz, 2-D", npz(**whole | {"values": flat}), f, h, outputs)
    yield Case("npz, accelerance", npz(**whole | {"kind": "accelerance"}), f, h, outputs)
    above = np.minimum(coherence_of(3) + 1e-7, 1 + 1e-7)
    above[::7] = 1 + 1e-7
    told = np.minimum(above, 1.0)
    yield Case("npz, coherence above 1", npz(**whole, coherence=above), f, h, outputs, coherence=told)
    yield Case("npz, coherence of zeros", npz(**whole, coherence=np.zeros((N_LINES, 3))), f, h, outputs)
    yield Case("npz, scale", npz(f=f, H=flat), f, h * 2.5, outputs, options={"scale": 2.5})
    sides = {"scale": {"response": GRAVITY, "force": POUND_FORCE}}
    yield Case("npz, scale a side", npz(f=f, H=flat), f, h * GRAVITY / POUND_FORCE, outputs, options=sides)


# --- text --------------------------------------------------------------------------------------------


def table(columns: Sequence[Any], header: str = "", separator: str = ",", decimal: str = ".") -> bytes:
    """Return columns as text."""
    rows = [separator.join(f"{x:.9g}".replace(".", decimal) for x in row) for row in np.column_stack(columns)]
    return (header + "\n".join(rows) + "\n").encode()


def _text() -> Iterator[Case]:
    f, h = curves()
    re, im, degrees = h[:, 0, 0].real, h[:, 0, 0].imag, np.degrees(np.angle(h[:, 0, 0]))
    size = np.abs(h[:, 0, 0])
    head = "Frequency (Hz),Real,Imag\n"
    yield Case("csv", (("a.csv", table([f, re, im], head)),), f, h)
    yield Case("tsv", (("a.tsv", table([f, re, im], head.replace(",", "\t"), "\t")),), f, h)
    semicolons = table([f, re, im], "Frequenz [Hz];Re;Im\n", ";", ",")
    yield Case("semicolons and decimal commas", (("a.csv", semicolons),), f, h)
    yield Case("blanks, no header", (("a.txt", table([f, re, im], "", "   ")),), f, h)
    yield Case("utf-16", (("a.txt", table([f, re, im], head).decode().encode("utf-16")),), f, h)
    long = "".join(f"Setting {k}: {k / 3:.3f}\n" for k in range(30)) + "***End of header***\n\n"
    yield Case("analyser export, 30 lines of header", (("a.txt", table([f, re, im], long + head)),), f, h)
    polar = table([f, size, degrees], "Hz,Magnitude (g/N),Phase (deg)\n")
    yield Case("magnitude and phase, g/N", (("a.csv", polar),), f, h * GRAVITY, options={"unit": "g/N"})
    decibels = table([f, 20 * np.log10(size), np.radians(degrees)], "Hz,Magnitude dB,Phase (rad)\n")
    yield Case("decibels and radians", (("a.csv", decibels),), f, h)
    by_number = {"columns": {"freq": 2, "real": 3, "imag": 4}}
    numbered = table([np.arange(N_LINES), f, re, im])
    yield Case("columns by number", (("a.csv", numbered),), f, h, options=by_number)
    by_name = {"columns": {"freq": "x", "real": "p", "imag": "q"}}
    yield Case("columns by name", (("a.csv", table([f, re, im], "x,p,q\n")),), f, h, options=by_name)
    coherence = coherence_of(1)
    with_coherence = table([f, re, im, coherence[:, 0]], "Hz,Re,Im,Coherence\n")
    yield Case("coherence column", (("a.csv", with_coherence),), f, h, coherence=coherence)
    text = "\n".join(f"{x:.9g},{y.real:+.9g}{y.imag:+.9g}i" for x, y in zip(f, h[:, 0, 0], strict=True))
    yield Case("complex column", (("a.csv", text.encode()),), f, h)
    yield from _several_texts()


def _several_texts() -> Iterator[Case]:
    f, h = curves(n_out=2)
    header = "Hz,Re 5:+Y/1:+Y,Im 5:+Y/1:+Y,Re 7X/1:+Y,Im 7X/1:+Y\n"
    parts = [part for j in range(2) for part in (h[:, j, 0].real, h[:, j, 0].imag)]
    several = (("a.csv", table([f, *parts], header)),)
    yield Case("two FRFs in a table, points in the header", several, f, h, ("5:+Y", "7:+X"), ("1:+Y",))
    names = ("wing_tip", "tail")
    files = tuple((f"{name}.txt", table([f, *parts[2 * j : 2 * j + 2]])) for j, name in enumerate(names))
    mapped = {"map": {"wing_tip": "12:+Z", "tail": "3:-Z"}}
    yield Case("a text an FRF, named by its file", files, f, h, ("12:+Z", "3:-Z"), options=mapped)
    whole = zipped(tuple(reversed(files)))
    order = ("3:-Z", "12:+Z")
    yield Case("the same in a zip", (("a.zip", whole),), f, h[:, ::-1], order, options=mapped)
    f, h = curves(start=50.0, n_lines=LONG)
    long = table([f, h[:, 0, 0].real, h[:, 0, 0].imag], "Hz,Re,Im\n")
    yield Case("csv, 51,201 lines, cut band", (("a.csv", long),), f, h)


# --- damaged files -----------------------------------------------------------------------------------

SEED = 2026
MOST_FLIPPED = 64  # bits


def damaged_cases(cases: Sequence[Case]) -> list[Case]:
    """Return damaged variants of the cases of which nothing may be taken: a part is missing or spoilt."""
    rng = np.random.default_rng(SEED)
    variants = [variant for case in cases for variant in _damaged(case, rng)]
    chosen = np.sort(rng.permutation(len(variants))[:N_DAMAGED])
    return [variants[k] for k in chosen]


def flipped_cases(cases: Sequence[Case]) -> list[Case]:
    """Return variants with random bits flipped, which may hit a number and leave a sound file."""
    rng = np.random.default_rng(SEED + 1)
    chosen = rng.permutation(np.resize(np.arange(len(cases)), N_DAMAGED))
    return [_flipped(cases[k], rng) for k in chosen]


def _damaged(case: Case, rng: np.random.Generator) -> Iterator[Case]:
    *others, (name, content) = case.files
    for _ in range(2):
        share = rng.uniform(0.05, 0.95)
        yield _with(case, f"truncated to {share:.1%}", (*others, (name, _cut(content, share))))
    width = max(len(content) // 10, 16)
    begin = int(rng.uniform(0.0, 0.9) * (len(content) - width))
    spoilt = content[:begin] + b"\xff" * width + content[begin + width :]
    yield _with(case, f"a tenth overwritten at {begin / len(content):.1%}", (*others, (name, spoilt)))
    yield _with(case, "empty", (*others, (name, b"")))


def _flipped(case: Case, rng: np.random.Generator) -> Case:
    *others, (name, content) = case.files
    count = int(2 ** rng.uniform(0.0, np.log2(MOST_FLIPPED)))
    data = np.frombuffer(content, np.uint8).copy()
    np.bitwise_xor.at(
        data, rng.integers(len(data), size=count), 1 << rng.integers(8, size=count, dtype=np.uint8)
    )
    return _with(case, f"{count} bits flipped", (*others, (name, data.tobytes())))


def _with(case: Case, damage: str, files: Files) -> Case:
    return replace(case, name=f"{case.name}: {damage}", files=files)


def _cut(content: bytes, share: float) -> bytes:
    """Return the beginning of a file; of a text in columns up to the first number of a row."""
    part = content[: int(share * len(content))]
    text = content.isascii() and b"    -1" not in content[:20]
    if not text:
        return part
    row = part[: part.rfind(b"\n") + 1]
    return row + content[len(row) :].split(b"\n")[0][:3]
