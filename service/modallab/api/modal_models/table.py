"""Table of modes: one row a mode, frequencies in Hz."""

from collections.abc import Collection, Iterator
from dataclasses import asdict
from typing import Any

from modallab.api.modal_models.replies import Detail, flags_of
from modallab.core.modal_model import ModalModel

_SPREADS = ("frequency_spread", "loss_factor_spread")
_STATISTICS = ("min", "max", "mean", "sd", "n")
COLUMNS = (
    "mode",
    "frequency",
    "loss_factor",
    *(f"{spread}_{name}" for spread in _SPREADS for name in _STATISTICS),
    "frequency_standard_error",
    "loss_factor_standard_error",
    "flags",
)


def mode_rows(model: ModalModel, details: Collection[Detail] = ()) -> Iterator[dict[str, Any]]:
    """Yield the columns of each mode; statistics that an extraction does not give are left out.

    Parameters
    ----------
    details
        `flags`: every flag is listed.
    """
    for number, mode in enumerate(model.modes, start=1):
        row: dict[str, Any] = {"mode": number, "frequency": mode.frequency, "loss_factor": mode.loss_factor}
        for name in _SPREADS:
            spread = getattr(mode, name)
            if spread is not None:
                row |= {f"{name}_{key}": value for key, value in asdict(spread).items()}
        row |= {f"{name}_standard_error": value for name, value in mode.standard_errors.items()}
        yield row | {"flags": "; ".join(flags_of(mode, details))}
