"""What is drawn of an extraction: one fit, the stabilisation chart, FRFs made of modes."""

from collections.abc import Mapping
from typing import Annotated, Any, Self

import numpy as np
from fastapi import Query
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from modallab.api.limits import REPLY
from modallab.api.measurements.indicators import IndicatorsOut
from modallab.api.thinning import numbers
from modallab.api.wire import DofText
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, NotFoundError
from modallab.core.frf import FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.plot_data import FitPlotData
from modallab.rig.measurement import Measurement
from modallab.store.base import Store

MODE = Annotated[int, Query(ge=1, le=100_000, description="counted from 1")]
RESPONSE = Annotated[DofText, Query(description="one of the model's `dofs`")]
REFERENCE = Annotated[
    DofText | None, Query(description="one of the model's `references`; not needed where there is but one")
]
Pair = tuple[float | None, float | None]

_AXES = {"damping_surface": ("x_above", "x_below")}


def measured_for(model_id: str, model: ModalModel, store: Store) -> Measurement:
    """Return the measurement that a model was read from.

    Raises
    ------
    InvalidInputError
        If it was not read from one that is stored.
    """
    made_from = store.modal_models.entry(model_id).inputs.get("measurement_id")
    if made_from is None:
        raise InvalidInputError(
            "these modes were not read from a measurement",
            field="id",
            value=model.method,
            allowed="a modal model that POST /v1/modal-models made",
        )
    measurement: Measurement = store.measurements.get(made_from)
    return measurement


class FitOut(BaseModel):
    """One mode in one FRF: lines, what was fitted to them, and what the method drew.

    Complex numbers are [re, im]. What lies along an axis in `details` is named `x...`: `(2 pi f)^2`, or
    where damping is viscous `2 pi f`.
    """

    mode: int
    response: str
    reference: str | None = Field(description="as asked")
    method: str
    damping: str
    kind: str = Field(description="of all responses here: the one that the mode was fitted on")
    freq: list[float] = Field(description="Hz, of the lines")
    used: list[bool] = Field(description="false for a line that was left out")
    measured: list[Pair]
    cleaned: list[Pair] = Field(description="freed of leakage and of the other modes")
    curve_freq: list[float]
    curve: list[Pair] = Field(description="mode and residual")
    frequency: float
    loss_factor: float
    modal_constant: Pair = Field(description="1/kg, of receptance")
    residual: Pair
    quality: dict[str, float | None] = Field(description="what only this method can tell, in %")
    details: dict[str, Any] = Field(description="real arrays of the method's drawing, by name")
    complex_details: dict[str, Any] = Field(description="complex ones")

    @classmethod
    def of(cls, picture: FitPlotData, mode: int, response: Dof, reference: Dof | None = None) -> Self:
        """Return what the contract shows of a fit."""
        drawn = _few(picture.details)
        flat = {name: numbers(values) for name, values in drawn.items()}
        is_complex = {name for name, values in drawn.items() if np.iscomplexobj(values)}
        return cls(
            mode=mode,
            response=str(response),
            reference=None if reference is None else str(reference),
            method=picture.method,
            damping=picture.damping.value,
            kind=picture.kind.value,
            freq=picture.freq.tolist(),
            used=picture.used.tolist(),
            measured=numbers(picture.measured),
            cleaned=numbers(picture.cleaned),
            curve_freq=picture.curve_freq.tolist(),
            curve=numbers(picture.curve),
            frequency=picture.frequency,
            loss_factor=picture.loss_factor,
            modal_constant=numbers(np.array(picture.modal_constant)),
            residual=numbers(np.array(picture.residual)),
            quality={name: value if np.isfinite(value) else None for name, value in picture.quality.items()},
            details={name: flat[name] for name in flat if name not in is_complex},
            complex_details={name: flat[name] for name in flat if name in is_complex},
        )


def _few(details: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return arrays of at most `REPLY.plot_rows` rows; columns with an axis are thinned alike."""
    few = dict(details)
    for name, values in details.items():
        if values.ndim == 2:
            rows, columns = (_some(n) for n in values.shape)
            few[name] = values[rows]
            if name in _AXES:
                above, below = _AXES[name]
                few |= {name: few[name][:, columns], above: few[above][rows], below: few[below][columns]}
            elif f"x_{name}" in details:
                few[f"x_{name}"] = details[f"x_{name}"][rows]
    return few


def _some(n: int) -> NDArray[np.int64]:
    return np.unique(np.linspace(0, n - 1, min(n, REPLY.plot_rows)).round().astype(np.int64))


class ChartOut(BaseModel):
    """Poles at rising orders.

    `stability` since the order before: 0 new, 1 steady in frequency, 2 and in damping, 3 and in its vector.
    """

    order: list[int]
    frequency: list[float] = Field(description="Hz")
    loss_factor: list[float]
    stability: list[int]
    mode: list[int | None] = Field(description="which it speaks for, counted from 1")
    modes: list[float] = Field(description="Hz, of the model's modes")
    notes: list[str] = Field(description="why each mode is one, and what was left out")
    indicators: IndicatorsOut

    @classmethod
    def of(cls, model: ModalModel, measurement: Measurement, points: int) -> Self:
        """Return what the contract shows of a stabilisation chart.

        Raises
        ------
        NotFoundError
            If the model's method draws none.
        """
        chart = model.chart
        if chart is None:
            raise NotFoundError(
                f"{model.method or 'imported modes'}: no stabilisation chart",
                field="method",
                value=model.method,
                allowed=list(GLOBAL_METHODS),
            )
        return cls(
            order=chart.order.tolist(),
            frequency=chart.frequency.tolist(),
            loss_factor=chart.loss_factor.tolist(),
            stability=chart.stability.tolist(),
            mode=[m + 1 if m >= 0 else None for m in chart.mode.tolist()],
            modes=model.frequencies.tolist(),
            notes=list(model.notes),
            indicators=IndicatorsOut.of(measurement, points),
        )


def frf_arrays(frf: FrfSet) -> dict[str, NDArray[Any]]:
    """Return FRFs by the names of a measurement's arrays."""
    return {
        "freq": frf.freq,
        "values": frf.values,
        "outputs": np.array([str(dof) for dof in frf.outputs]),
        "inputs": np.array([str(dof) for dof in frf.inputs]),
        "kind": np.array(frf.kind.value),
    }
