"""Imported modes as JSON and arrays, for another process."""

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel, Mode


def mode_parts(model: ModalModel) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a modal model of frequencies, loss factors and shapes as JSON, and arrays by name."""
    about = {
        "dofs": [str(dof) for dof in model.dofs],
        "normalisation": model.normalisation,
        "method": model.method,
        "notes": list(model.notes),
    }
    arrays = {
        "frequencies": model.frequencies,
        "loss_factors": model.loss_factors,
        "shapes": model.shapes,
    }
    return about, arrays


def modes_from(about: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> ModalModel:
    """Return the modal model from the results of `mode_parts`."""
    rows = zip(
        arrays["frequencies"].tolist(), arrays["loss_factors"].tolist(), arrays["shapes"].T, strict=True
    )
    return ModalModel(
        tuple(Mode(frequency, loss_factor, shape) for frequency, loss_factor, shape in rows),
        tuple(map(Dof.parse, about["dofs"])),
        about["normalisation"],
        method=about["method"],
        notes=tuple(about["notes"]),
    )
