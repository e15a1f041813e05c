"""JSON to fits, charts, indicators and reciprocity; pure."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab_client import extraction
from modallab_client._wire import Json, floats, number, texts


def fit(data: Json) -> extraction.FitPicture:
    """Return one fit."""
    details = {name: floats(values) for name, values in data["details"].items()}
    turning = {name: _complex(values) for name, values in data["complex_details"].items()}
    return extraction.FitPicture(
        mode=int(data["mode"]),
        response=data["response"],
        method=data["method"],
        damping=data["damping"],
        kind=data["kind"],
        freq=floats(data["freq"]),
        used=_switches(data["used"]),
        measured=_complex(data["measured"]),
        cleaned=_complex(data["cleaned"]),
        curve_freq=floats(data["curve_freq"]),
        curve=_complex(data["curve"]),
        frequency=float(data["frequency"]),
        loss_factor=float(data["loss_factor"]),
        modal_constant=complex(_complex(data["modal_constant"])),
        residual=complex(_complex(data["residual"])),
        quality={name: number(value) for name, value in (data.get("quality") or {}).items()},
        details=details | turning,
    )


def chart(data: Json) -> extraction.StabilisationChart:
    """Return a stabilisation chart."""
    shown = data.get("indicators")
    return extraction.StabilisationChart(
        order=_counts(data["order"]),
        frequency=floats(data["frequency"]),
        loss_factor=floats(data["loss_factor"]),
        stability=_counts(data["stability"]),
        mode=_counts([0 if m is None else m for m in data["mode"]]),
        modes=floats(data["modes"]),
        notes=texts(data.get("notes") or ()),
        indicators=None if shown is None else indicators(shown),
    )


def indicators(data: Json) -> extraction.Indicators:
    """Return mode indicator functions."""
    return extraction.Indicators(
        floats(data["freq"]), texts(data["inputs"]), floats(data["mif"]), floats(data["cmif"])
    )


def reciprocity(data: Json) -> extraction.Reciprocity:
    """Return how far FRFs are reciprocal."""
    pairs = tuple(
        extraction.ReciprocalPair(
            response=one["response"],
            force=one["force"],
            scale=complex(_complex(one["scale"])),
            difference=float(one["difference"]),
            misfit=number(one["misfit"]),
            differs=bool(one["differs"]),
        )
        for one in data["pairs"]
    )
    return extraction.Reciprocity(pairs, data["note"])


def modal_pairs(data: Json) -> tuple[extraction.ModalPair, ...]:
    """Return how modal constants of two tests agree."""
    return tuple(
        extraction.ModalPair(
            modes=(int(one["modes"][0]), int(one["modes"][1])),
            ratio=complex(_complex(one["ratio"])),
            ratio_error=number(one["ratio_error"]),
            differs=bool(one["differs"]),
        )
        for one in data["pairs"]
    )


def _complex(pairs: Any) -> NDArray[np.complex128]:
    values = floats(pairs)
    together = np.asarray(values[..., 0] + 1j * values[..., 1])
    together.flags.writeable = False
    return together


def _counts(values: Any) -> NDArray[np.int64]:
    counted = np.array(values, dtype=np.int64)
    counted.flags.writeable = False
    return counted


def _switches(values: Any) -> NDArray[np.bool_]:
    switched = np.array(values, dtype=bool)
    switched.flags.writeable = False
    return switched
