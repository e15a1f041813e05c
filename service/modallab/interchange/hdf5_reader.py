"""Separate program that writes the arrays of one HDF5 file as npz to standard output.

Exit code 1, with the reason in the last line of standard error: the file is refused. Any other code than 0:
the library failed.
"""

import io
import sys
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from modallab.interchange.settings import HDF5

NAMES = (
    "freq",
    "values",
    "outputs",
    "inputs",
    "kind",
    "coherence",
    "averages",
    "force_spectrum",
    "response_spectrum",
)
_TEXTS = ("outputs", "inputs", "kind")
_FILTERS = {1, 2, 3, 32000}  # deflate, shuffle, checksum, lzf: filters of the library itself


class RefusedError(Exception):
    """Refused file."""


def main(path: str, largest: int) -> None:
    """Write the arrays of a file to standard output."""
    _confine()
    try:
        arrays = arrays_of(path, largest)
    except (RefusedError, MemoryError) as error:
        _refuse(str(error) or "it is larger inside than outside")
    except Exception as error:  # whatever the library raises at damaged bytes
        _refuse(f"damaged ({type(error).__name__})")
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    sys.stdout.buffer.write(buffer.getbuffer())
    sys.stdout.buffer.flush()


def _refuse(why: str) -> None:
    sys.stderr.write(" ".join(why.split()) + "\n")
    raise SystemExit(1)


def _confine() -> None:
    """Limit memory and time, where the system supports it."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    resource.setrlimit(resource.RLIMIT_CPU, (HDF5.processor_seconds, HDF5.processor_seconds + 1))
    resource.setrlimit(resource.RLIMIT_DATA, (HDF5.memory_bytes, HDF5.memory_bytes))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def arrays_of(path: str, largest: int) -> dict[str, NDArray[Any]]:
    """Return the arrays of a measurement by name.

    Parameters
    ----------
    path
        The file.
    largest
        Bytes that the arrays may take, each number counted as a complex one.

    Raises
    ------
    RefusedError
        If a name stands for something else than numbers or strings of this very file.
    Exception
        Whatever h5py raises at damaged bytes.
    """
    with h5py.File(path, "r") as file:
        # Not by `name in file`, which follows links.
        datasets = {name: _dataset(file, name) for name in NAMES if file.id.links.exists(name.encode())}
        total = sum(dataset.size * max(dataset.dtype.itemsize, 16) for dataset in datasets.values())
        if total > largest:
            raise RefusedError(f"its arrays take {total} bytes, {largest} may be")
        return {name: _array(dataset, name) for name, dataset in datasets.items()}


def _dataset(file: Any, name: str) -> Any:
    # A link could open a file of the service that the sender may not read.
    if file.id.links.get_info(name.encode()).type != h5py.h5l.TYPE_HARD:
        raise RefusedError(f"{name} is a link")
    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset) or dataset.shape is None:
        raise RefusedError(f"{name} is no dataset")
    if dataset.is_virtual or dataset.external:
        raise RefusedError(f"{name} lies in another file")
    properties = dataset.id.get_create_plist()
    filters = {properties.get_filter(i)[0] for i in range(properties.get_nfilters())}
    if not filters <= _FILTERS:
        raise RefusedError(f"{name} is packed by a filter other than gzip, lzf, shuffle and fletcher32")
    if dataset.chunks is not None:
        piece = int(np.prod(dataset.chunks, dtype=object))
        along = [-(-n // c) for n, c in zip(dataset.shape, dataset.chunks, strict=True)]
        pieces = int(np.prod(along, dtype=object))
        if pieces > HDF5.max_chunks or piece * dataset.dtype.itemsize > 2 * dataset.nbytes + 1_000_000:
            raise RefusedError(f"{name} is laid down in too many pieces, or too large ones")
    return dataset


def _array(dataset: Any, name: str) -> NDArray[Any]:
    if name not in _TEXTS:
        if dataset.dtype.kind not in "iufc":
            raise RefusedError(f"{name} holds {dataset.dtype}, not numbers")
        return np.asarray(dataset[()])
    about = h5py.check_string_dtype(dataset.dtype)
    if about is None or dataset.size > HDF5.max_texts:
        raise RefusedError(f"{name} holds no strings, or too many")
    if about.length is not None and about.length > HDF5.max_text_length:
        raise RefusedError(f"{name} holds strings that are too long")
    texts = np.asarray(dataset.asstr("utf-8", "replace")[()], dtype=object)
    if any(len(text) > HDF5.max_text_length for text in texts.ravel()):
        raise RefusedError(f"{name} holds strings that are too long")
    return texts.astype(str)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
