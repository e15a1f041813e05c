"""Modal models as universal files: dataset 55, out and in.

Not by pyuff 2.5: it keeps six digits, has no complex shapes with rotations, and knows no other
number of values a node than three and six. What is written here it reads.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.core.dof import DIRECTIONS, TRANSLATIONS, Dof
from modallab.core.modal_model import ModalModel, Mode
from modallab.interchange.settings import UNIVERSAL
from modallab.interchange.uff_contents import contents
from modallab.interchange.uff_data_at_nodes import NodalShape, read_shape
from modallab.interchange.uff_records import HEADER, UNITS, factors, read_texts
from modallab.interchange.uff_split import refusal
from modallab.interchange.uff_text import NOWHERE, Origin, dataset, foreign, front, label, program_of, rows

MODE = 55


def write(model: ModalModel, origin: Origin = NOWHERE) -> bytes:
    """Return modes as a universal file.

    Header (151) and SI units (164) come first, then a dataset 55 a mode, in the positive sense of
    every direction: normal modes (analysis type 2) where all shapes are real, else complex modes
    (type 3) with eigenvalue and modal A of the viscous mode that is the same at resonance. A
    direction of a node that has no DoF gets zeros.
    """
    table = _table(model)
    is_complex = bool(np.any(table.imag))
    sets = [_mode(model, index, table[index], is_complex) for index in range(len(model.modes))]
    return front(origin) + b"".join(sets)


def _table(model: ModalModel) -> ComplexArray:
    """Return shapes in whole nodes, (n_modes, n_nodes, 3 or 6)."""
    wide = any(dof.direction not in TRANSLATIONS for dof in model.dofs)
    nodes = {node: i for i, node in enumerate(dict.fromkeys(dof.node for dof in model.dofs))}
    table = np.zeros((len(model.modes), len(nodes), 6 if wide else 3), complex)
    rows_, columns = zip(*((nodes[d.node], DIRECTIONS.index(d.direction)) for d in model.dofs), strict=True)
    signs = np.array([dof.sign for dof in model.dofs])
    table[:, rows_, columns] = model.shapes.T * signs
    return table


def _mode(model: ModalModel, index: int, table: ComplexArray, is_complex: bool) -> bytes:
    mode, width = model.modes[index], table.shape[1]
    mass = float(model.normalisation == "mass")
    nodes = list(dict.fromkeys(dof.node for dof in model.dofs))
    if is_complex:
        omega, ratio = 2 * np.pi * mode.frequency, mode.loss_factor / 2
        damped = omega * np.sqrt(max(1 - ratio**2, 0.0))
        kinds, specific = (1, 3, 2 if width == 3 else 3, 8, 5, width), (2, 6, 1, index + 1)
        values = [-ratio * omega, damped, 0.0, 2 * damped * mass, 0.0, 0.0]
        entries = np.stack([table.real, table.imag], axis=-1).reshape(len(nodes), -1)
    else:
        kinds, specific = (1, 2, 2 if width == 3 else 3, 8, 2, width), (2, 4, 1, index + 1)
        values = [mode.frequency, mass, 0.0, mode.loss_factor]
        entries = table.real
    lines = [
        label(f"mode {index + 1}: {mode.frequency:.6g} Hz, loss factor {mode.loss_factor:.6g}"),
        f"modallab, mode {index + 1} of {len(model.modes)}",
        label(model.method),
        "shapes mass-normalised, 1/sqrt(kg)" if mass else "shapes of any length",
        "NONE",
        "".join(f"{kind:10d}" for kind in kinds),
        "".join(f"{integer:10d}" for integer in specific),
        *rows(values),
    ]
    for node, entry in zip(nodes, entries.tolist(), strict=True):
        lines += [f"{node:10d}", *rows(entry)]
    return dataset(MODE, lines)


def read(payload: bytes, *, largest: int) -> ModalModel:
    """Return the modes of a universal file, in rising frequency.

    Normal modes (analysis type 2) and complex modes (3, 7) are taken, those at the same nodes;
    units (164) are converted to SI. Shapes are mass-normalised where every mode tells its modal
    mass or modal A. Directions in which no mode moves count as not measured.

    Parameters
    ----------
    payload
        The file.
    largest
        Bytes it may have.

    Raises
    ------
    InvalidInputError
        If it is no universal file, is cut off or damaged, or its datasets make no modal model.
    """
    shapes: list[NodalShape] = []
    notes: list[str] = []
    units = (1.0, 1.0)
    text_limits = {
        MODE: UNIVERSAL.max_bytes,
        UNITS: UNIVERSAL.max_small_bytes,
        HEADER: UNIVERSAL.max_small_bytes,
    }
    for number, text in read_texts(payload, largest, text_limits):
        if number == HEADER:
            notes += foreign(program_of(text))
        elif number == UNITS:
            units = factors(text)
        elif (shape := read_shape(text, len(shapes) + 1)) is not None:
            shapes.append(shape)
            if (
                len(shapes) > UNIVERSAL.max_modes
                or sum(entry.values.size for entry in shapes) > UNIVERSAL.max_shape_entries
            ):
                limits = f"{UNIVERSAL.max_modes} modes, {UNIVERSAL.max_shape_entries} entries of shapes"
                raise refusal("the file has too many modes", value=len(shapes), allowed=limits)
    _check(shapes)
    n_read = len(shapes)
    # The conjugate of a complex mode has no further information.
    shapes = [shape for shape in shapes if shape.frequency > 0]
    if len(shapes) < n_read:
        notes.append("left out: modes at 0 Hz, and conjugates")
    if not shapes:
        raise refusal(
            f"the file holds no mode; what it holds: {contents(payload)}",
            allowed="dataset 55 with analysis type 2, 3 or 7",
        )
    return _model(shapes, units, notes)


def _check(shapes: Sequence[NodalShape]) -> None:
    short = [shape.of for shape in shapes if shape.of is not None and shape.of != len(shapes)]
    if short:
        raise refusal(f"the file had {short[0]} modes and has {len(shapes)}: cut off", value=len(shapes))


def _model(shapes: Sequence[NodalShape], units: tuple[float, float], notes: Sequence[str]) -> ModalModel:
    nodes = shapes[0].nodes
    places = {node: i for i, node in enumerate(nodes)}
    if any(set(shape.nodes) != set(nodes) for shape in shapes):
        raise refusal("the modes are not all at the same nodes", field="nodes")
    table = np.zeros((len(shapes), len(nodes), 6), complex)
    for entry, shape in zip(table, shapes, strict=True):
        entry[[places[node] for node in shape.nodes], : shape.values.shape[1]] = shape.values
    length, force = units
    # Rotations scale with the unit of length, modal masses with those of force and length.
    table[:, :, 3:] *= length
    mass_normalised = all(shape.modal_mass for shape in shapes)
    if mass_normalised:
        masses = np.array([shape.modal_mass for shape in shapes]) * length / force
        with np.errstate(all="ignore"):  # what overflows is refused with the shape
            table /= np.sqrt(masses)[:, None, None]
    dofs = list(_moving(table, nodes))
    if not dofs:
        raise refusal("no mode moves", field="shape")
    if len(dofs) > UNIVERSAL.max_dofs:
        raise refusal("the shapes have too many entries", value=len(dofs), allowed=UNIVERSAL.max_dofs)
    index = tuple(np.array([(places[d.node], DIRECTIONS.index(d.direction)) for d in dofs]).T)
    modes = [Mode(s.frequency, s.loss_factor, entry[index]) for s, entry in zip(shapes, table, strict=True)]
    return ModalModel(
        tuple(sorted(modes, key=lambda mode: mode.frequency)),
        tuple(dofs),
        "mass" if mass_normalised else "none",
        method="imported",
        notes=tuple(notes),
    )


def _moving(table: ComplexArray, nodes: Sequence[int]) -> Iterator[Dof]:
    for row, column in np.argwhere(table.any(axis=0)):
        yield Dof(nodes[row], DIRECTIONS[column])
