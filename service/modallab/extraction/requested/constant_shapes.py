"""Shapes of some modes from their modal constants."""

from collections.abc import Sequence
from dataclasses import replace

from modallab.core.modal_model import ModalModel
from modallab.extraction.averaging.reference_shapes import reference_shapes
from modallab.extraction.summary import FlagKind, flag_kind

SHAPE_KINDS = (FlagKind.DRIVE_POINT, FlagKind.REFERENCES_DIFFER, FlagKind.COMPLEX_SHAPE)


def with_shapes_of_constants(model: ModalModel, rows: Sequence[int]) -> ModalModel:
    """Return the model with shapes of some modes by their modal constants, and the flags on these shapes.

    Parameters
    ----------
    model
        With modal constants and their errors.
    rows
        Indices of the modes.
    """
    assert model.modal_constant is not None
    assert model.modal_constant_error is not None
    shapes = reference_shapes(model.modal_constant, model.modal_constant_error, model.dofs, model.references)
    modes = list(model.modes)
    for row in rows:
        others = [flag for flag in modes[row].flags if flag_kind(flag) not in SHAPE_KINDS]
        modes[row] = replace(
            modes[row],
            shape=shapes.shape[row],
            shape_errors=shapes.error[row],
            flags=(*others, *shapes.flags(row)),
        )
    return replace(model, modes=tuple(modes))
