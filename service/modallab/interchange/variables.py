"""FRFs from named arrays, as MATLAB, HDF5 and npz files hold them."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.assumption import Assumption
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.interchange.file_content import FileContent
from modallab.interchange.npz_arrays import Arrays, numbers, reals, texts
from modallab.interchange.points import named_dofs, numbered
from modallab.interchange.reading_options import ReadingOptions
from modallab.interchange.units import SI
from modallab.interchange.variable_roles import roles_of

_RANKS = (1, 2, 3)


def content_of(variables: Mapping[str, NDArray[Any]], options: ReadingOptions) -> FileContent:
    """Return the FRFs of named arrays.

    Parameters
    ----------
    variables
        Arrays of numbers or text by name.
    options
        Roles of the variables, and what they do not say.

    Raises
    ------
    InvalidInputError
        If the roles are not clear, an array holds NaN, or the arrays do not fit together.
    """
    roles, assumed = roles_of(variables, options)
    arrays: Arrays = {role: variables[name] for role, name in roles.items()}
    freq = reals(arrays, "freq", *_RANKS).ravel()
    values = _values(arrays, len(freq))
    kind, kind_assumed = kind_of(arrays, roles, options)
    outputs, inputs, points_assumed = _points(arrays, values, options)
    if (values.shape[1], values.shape[2]) == (len(inputs), len(outputs)) != (len(outputs), len(inputs)):
        values = values.swapaxes(1, 2)
    frf = FrfSet(freq=freq, values=values, outputs=outputs, inputs=inputs, kind=kind)
    return FileContent(
        frf=frf,
        coherence=_shaped(arrays, "coherence", frf),
        averages=_single(arrays, "averages") if "averages" in arrays else None,
        force_spectrum=_shaped(arrays, "force_spectrum", frf),
        response_spectrum=_shaped(arrays, "response_spectrum", frf),
        force_cross_spectra=_cross_spectra(arrays, frf),
        assumed=(*assumed, *kind_assumed, *points_assumed),
    )


def _single(arrays: Arrays, name: str) -> float:
    """Return a number that a program may have written as an array of one."""
    array = reals(arrays, name, 0, 1, 2)
    if array.size != 1:
        raise InvalidInputError(f"{name} is no single number", field=name, value=array.shape, allowed=1)
    return float(array.ravel()[0])


def kind_of(
    arrays: Mapping[str, NDArray[Any]], names: Mapping[str, str], options: ReadingOptions
) -> tuple[FrfKind, tuple[Assumption, ...]]:
    """Return the kind of the FRFs, with the assumptions on kind and unit.

    The file's `kind` comes first, then the stated unit or kind, then the name of the variable.
    """
    if "kind" in arrays:
        text = ", ".join(texts(arrays["kind"], "kind"))
        try:
            return FrfKind(text), ()
        except ValueError:
            raise InvalidInputError(
                f"no kind {text!r}", field="kind", value=text, allowed=[*FrfKind, "accelerance"]
            ) from None
    return stated_kind(options, names.get("values", ""))


def stated_kind(options: ReadingOptions, label: str) -> tuple[FrfKind, tuple[Assumption, ...]]:
    """Return the kind that options or a label state, with the assumptions on kind and unit."""
    if options.frf_unit is not None:
        return options.frf_unit.kind, ()
    words = label.lower()
    told = next((kind for kind in (*FrfKind, "accelerance") if kind in words), None)
    kind = options.kind or (FrfKind.INERTANCE if told is None else FrfKind(told))
    reason = "neither the file nor `unit` tells it"
    return kind, (Assumption("unit", SI[kind], reason),)


def _values(arrays: Arrays, n_lines: int) -> ComplexArray:
    """Return the FRFs (n_lines, n_a, n_b)."""
    if "values" in arrays:
        values = numbers(arrays, "values", *_RANKS)
    elif "real" in arrays:
        real, imag = reals(arrays, "real", *_RANKS), reals(arrays, "imag", *_RANKS)
        values = _same_shape(real, imag, "imag") + 1j * imag
    else:
        magnitude, phase = reals(arrays, "magnitude", *_RANKS), reals(arrays, "phase", *_RANKS)
        values = _same_shape(magnitude, phase, "phase") * np.exp(1j * np.radians(phase))
    return _lines_first(values, n_lines, "values")


def _same_shape(array: FloatArray, other: FloatArray, name: str) -> FloatArray:
    if array.shape != other.shape:
        raise InvalidInputError(
            f"{name} has another shape than the array that it belongs to",
            field=name,
            value=list(other.shape),
            allowed=list(array.shape),
        )
    return array


def _lines_first(array: NDArray[Any], n_lines: int, name: str) -> NDArray[Any]:
    """Return an array in three dimensions, lines first."""
    if n_lines not in array.shape:
        raise InvalidInputError(
            f"no axis of {name} has the length of the frequency axis",
            field=name,
            value=list(array.shape),
            allowed=f"{n_lines} lines",
        )
    moved = np.moveaxis(array, array.shape.index(n_lines), 0)
    return moved.reshape(*moved.shape, *[1] * (3 - moved.ndim))


def _shaped(arrays: Arrays, name: str, frf: FrfSet) -> FloatArray | None:
    """Return an array a response, or an FRF where there are several forces; None where the file has none."""
    if name not in arrays:
        return None
    n_lines, n_out, n_in = frf.values.shape
    array = _lines_first(reals(arrays, name, *_RANKS), n_lines, name)
    if array.shape[1:] == (n_in, n_out) != (n_out, n_in):
        array = array.swapaxes(1, 2)
    if array.shape == frf.values.shape and (n_in > 1 or name == "force_spectrum"):
        return array
    if array.shape[1] * array.shape[2] != n_out:
        raise InvalidInputError(
            f"{name} has another shape than the FRFs",
            field=name,
            value=list(array.shape),
            allowed=list(frf.values.shape),
        )
    return array.reshape(n_lines, n_out)


def _cross_spectra(arrays: Arrays, frf: FrfSet) -> ComplexArray | None:
    """Return the forces' cross spectra (n_lines, n_out, n_in, n_in); the file may have them without n_out."""
    if "force_cross_spectra" not in arrays:
        return None
    n_lines, n_out, n_in = frf.values.shape
    array = numbers(arrays, "force_cross_spectra", 3, 4)
    if array.shape not in ((n_lines, n_in, n_in), (n_lines, n_out, n_in, n_in)):
        raise InvalidInputError(
            "force_cross_spectra has another shape than the FRFs",
            field="force_cross_spectra",
            value=list(array.shape),
            allowed=[n_lines, n_out, n_in, n_in],
        )
    return array if array.ndim == 4 else np.repeat(array[:, None], n_out, axis=1)


def _points(
    arrays: Arrays, values: ComplexArray, options: ReadingOptions
) -> tuple[tuple[Dof, ...], tuple[Dof, ...], tuple[Assumption, ...]]:
    """Return response and force DoFs: as stated, or as in the file, or else numbered."""
    outputs, outputs_assumed = _dofs(arrays, "outputs", options)
    inputs, inputs_assumed = _dofs(arrays, "inputs", options)
    _, n_out, n_in = values.shape
    if n_in == 1 and inputs and outputs and (len(outputs), len(inputs)) == (1, n_out):
        n_out, n_in = 1, n_out
    if not outputs:
        outputs, outputs_assumed = numbered(n_in if len(inputs) == n_out != n_in else n_out, "outputs")
    if not inputs:
        inputs, inputs_assumed = numbered(n_out if len(outputs) == n_in != n_out else n_in, "inputs")
    return outputs, inputs, (*outputs_assumed, *inputs_assumed)


def _dofs(
    arrays: Arrays, name: str, options: ReadingOptions
) -> tuple[tuple[Dof, ...], tuple[Assumption, ...]]:
    stated = getattr(options, name)
    if stated:
        return tuple(Dof.parse(text, field=name) for text in stated), ()
    if name not in arrays:
        return (), ()
    names = _point_names(arrays, name)
    directions = f"{name.removesuffix('s')}_directions"
    if directions in arrays:
        axes = _point_names(arrays, directions)
        if len(axes) != len(names):
            raise InvalidInputError(
                f"{directions} has another length than {name}",
                field=directions,
                value=len(axes),
                allowed=len(names),
            )
        names = [f"{point}:{axis}" for point, axis in zip(names, axes, strict=True)]
    return named_dofs(names, name, options)


def _point_names(arrays: Arrays, name: str) -> list[str]:
    array = arrays[name]
    if array.dtype.kind in "iuf":
        return [f"{number:.0f}" for number in reals(arrays, name, 0, 1, 2).ravel()]
    return texts(array, name)
