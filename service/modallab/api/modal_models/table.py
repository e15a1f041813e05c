"""Table of modes: one row a mode, frequencies in Hz."""

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

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


def mode_rows(model: ModalModel) -> Iterator[dict[str, Any]]:
    """Yield the columns of each mode; statistics that an extraction does not give are left out."""
    for number, mode in enumerate(model.modes, start=1):
        row: dict[str, Any] = {"mode": number, "frequency": mode.frequency, "loss_factor": mode.loss_factor}
        for name in _SPREADS:
            spread = getattr(mode, name)
            if spread is not None:
                row |= {f"{name}_{key}": value for key, value in asdict(spread).items()}
        row |= {f"{name}_standard_error": value for name, value in mode.standard_errors.items()}
        yield row | {"flags": "; ".join(mode.flags)}
