"""Arrays of HDF5 files of unknown origin, MATLAB files from 7.3 on among them: every dataset is checked.

The library is not safe against hostile files: only the confined process of `confinement` may call this.
"""

import io
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import InvalidInputError, bounds
from modallab.interchange.settings import HDF5

_FILTERS = {1, 2, 3, 32000}  # deflate, shuffle, checksum, lzf: filters of the library itself
_MATLAB_CLASS = "MATLAB_class"


def arrays_of(content: bytes, largest: int) -> dict[str, NDArray[Any]]:
    """Return the arrays of numbers and text by name; of one within a group `group.name`.

    Arrays of MATLAB have their axes in MATLAB's order; a cell array of text is an array of text.

    Parameters
    ----------
    content
        The file.
    largest
        Bytes that the arrays may take, each number counted as a complex one.

    Raises
    ------
    InvalidInputError
        If it is damaged, or a name stands for something else than numbers or strings of this very file.
    """
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            datasets = dict(_datasets(file, "", 0))
            total = sum(dataset.size * max(dataset.dtype.itemsize, 16) for dataset in datasets.values())
            if total > largest:
                raise _refusal(f"its arrays take {total} bytes", value=total, allowed=bounds(maximum=largest))
            return {name: _array(file, dataset, name) for name, dataset in datasets.items()}
    except (InvalidInputError, MemoryError):
        raise
    except Exception as error:  # whatever the library raises at damaged bytes
        raise _refusal(f"the HDF5 file is damaged ({type(error).__name__})") from None


def _datasets(group: Any, path: str, depth: int) -> Any:
    """Yield the datasets of a group and of the groups within, by name."""
    for index, name in enumerate(group):
        if index >= HDF5.max_datasets or depth > HDF5.max_depth:
            raise _refusal("the HDF5 file has too many datasets")
        full = f"{path}{name}"
        if name.startswith("#") and depth == 0:  # MATLAB's own: contents of cells, subsystem
            continue
        # A link could open a file of the service that the sender may not read.
        if group.id.links.get_info(name.encode()).type != h5py.h5l.TYPE_HARD:
            raise _refusal(f"{full} is a link", field=full)
        member = group[name]
        if isinstance(member, h5py.Group):
            yield from _datasets(member, f"{full}.", depth + 1)
        else:
            yield full, _checked(member, full)


def _checked(dataset: Any, name: str) -> Any:
    """Return a dataset of this very file, of a size that its bytes may have."""
    if not isinstance(dataset, h5py.Dataset) or dataset.shape is None:
        raise _refusal(f"{name} is no dataset", field=name)
    if dataset.is_virtual or dataset.external:
        raise _refusal(f"{name} lies in another file", field=name)
    properties = dataset.id.get_create_plist()
    filters = {properties.get_filter(i)[0] for i in range(properties.get_nfilters())}
    if not filters <= _FILTERS:
        raise _refusal(
            f"{name} is packed by a filter other than gzip, lzf, shuffle and fletcher32", field=name
        )
    if dataset.chunks is not None:
        piece = int(np.prod(dataset.chunks, dtype=object))
        along = [-(-n // c) for n, c in zip(dataset.shape, dataset.chunks, strict=True)]
        pieces = int(np.prod(along, dtype=object))
        if pieces > HDF5.max_chunks or piece * dataset.dtype.itemsize > 2 * dataset.nbytes + 1_000_000:
            raise _refusal(f"{name} is laid down in too many pieces, or too large ones", field=name)
    return dataset


def _array(file: Any, dataset: Any, name: str) -> NDArray[Any]:
    matlab = dataset.attrs.get(_MATLAB_CLASS, b"")
    if h5py.check_ref_dtype(dataset.dtype) is not None and matlab == b"cell":
        cells = [_array(file, _checked(file[reference], name), name) for reference in _few(dataset, name)]
        return np.array(["".join(cell.astype(str).ravel()) for cell in cells])
    if matlab == b"char":
        letters = np.atleast_2d(np.asarray(_few(dataset, name)).T)
        return np.array(["".join(map(chr, row)).strip() for row in letters.astype(int)])
    if h5py.check_string_dtype(dataset.dtype) is not None:
        return _texts(dataset, name)
    array: NDArray[Any] = np.asarray(dataset[()])
    if array.dtype.names == ("real", "imag"):
        array = array["real"] + 1j * array["imag"]
    if array.dtype.kind not in "iufc":
        raise _refusal(f"{name} holds {array.dtype}, not numbers", field=name)
    return array.T if matlab else array


def _few(dataset: Any, name: str) -> Any:
    """Return the entries of a dataset that stands for text."""
    if dataset.size > HDF5.max_texts:
        raise _refusal(f"{name} holds too many strings", field=name)
    return dataset[()].ravel() if dataset.dtype.kind == "O" else dataset[()]


def _texts(dataset: Any, name: str) -> NDArray[Any]:
    about = h5py.check_string_dtype(dataset.dtype)
    if dataset.size > HDF5.max_texts:
        raise _refusal(f"{name} holds too many strings", field=name)
    if about.length is not None and about.length > HDF5.max_text_length:
        raise _refusal(f"{name} holds strings that are too long", field=name)
    texts = np.asarray(dataset.asstr("utf-8", "replace")[()], dtype=object)
    if any(len(text) > HDF5.max_text_length for text in texts.ravel()):
        raise _refusal(f"{name} holds strings that are too long", field=name)
    return texts.astype(str)


def _refusal(message: str, **context: Any) -> InvalidInputError:
    return InvalidInputError(message, **({"field": "file", "allowed": "HDF5 with arrays"} | context))
