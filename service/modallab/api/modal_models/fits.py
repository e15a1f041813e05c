"""Data for plots of an extraction: one fit, the stabilisation chart, resynthesised FRFs."""

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from fastapi import Query
from numpy.typing import NDArray

from modallab.api.limits import REPLY
from modallab.api.measurements.indicators import IndicatorsReply, indicators_of
from modallab.api.replies import replies_of, reply
from modallab.api.thinning import numbers
from modallab.api.wire import DofText
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, NotFoundError
from modallab.core.frf import FrfSet
from modallab.core.modal_model import DoubtfulMode, ModalModel, StabilisationChart
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS
from modallab.extraction.plot_data import FitPlotData
from modallab.rig.measurement import Measurement
from modallab.store.base import Store

MODE = Annotated[int, Query(ge=1, le=100_000, description="counted from 1")]
RESPONSE = Annotated[DofText, Query(description="one of the model's `dofs`")]
REFERENCE = Annotated[
    DofText | None, Query(description="one of the model's `references`; not needed where there is but one")
]

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


FitReply: Any = reply(
    FitPlotData,
    "FitPlotData",
    mode=(int, "Number of the mode, from 1."),
    response=(str, "DoF of the response, as asked for."),
    reference=(str | None, "Common DoF of the FRFs, as asked for."),
    details=(
        dict[str, Any],
        "Real arrays of the method's plot, thinned; an axis is named `x...`: (2 pi f)^2, or 2 pi f with "
        "viscous damping.",
    ),
    complex_details=(dict[str, Any], "Complex arrays of the method's plot, thinned, innermost [re, im]."),
)


def fit_reply(fit: FitPlotData, mode: int, response: Dof, reference: Dof | None = None) -> Any:
    """Return the reply of one fit."""
    arrays = _few(fit.details)
    names = {name for name, array in arrays.items() if np.iscomplexobj(array)}
    return FitReply.model_validate(
        {
            **vars(fit),
            "mode": mode,
            "response": str(response),
            "reference": None if reference is None else str(reference),
            "details": {name: numbers(array) for name, array in arrays.items() if name not in names},
            "complex_details": {name: numbers(array) for name, array in arrays.items() if name in names},
        }
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


ChartReply: Any = reply(
    StabilisationChart,
    "StabilisationChart",
    mode=(list[int | None], "(n_poles,) number of the mode that the pole belongs to, from 1; null for none."),
    modes=(list[float], "Hz, (n_modes,) natural frequencies of the model."),
    doubtful=(
        replies_of(DoubtfulMode),
        "Poles within the range that are not among the modes, each with the reason, in ascending frequency.",
    ),
    notes=(list[str], "Reasons for each mode, and poles that were left out."),
    indicators=(IndicatorsReply, "Mode indicator functions of the measurement."),
)


def chart_reply(model: ModalModel, measurement: Measurement, points: int) -> Any:
    """Return the reply of a stabilisation chart, with mode indicator functions at about `points` lines.

    Raises
    ------
    NotFoundError
        If the method of the model has no stabilisation chart.
    """
    chart = model.chart
    if chart is None:
        raise NotFoundError(
            f"{model.method or 'imported modes'}: no stabilisation chart",
            field="method",
            value=model.method,
            allowed=list(GLOBAL_METHODS),
        )
    return ChartReply.model_validate(
        {
            **vars(chart),
            "mode": [mode + 1 if mode >= 0 else None for mode in chart.mode.tolist()],
            "modes": model.frequencies.tolist(),
            "doubtful": [vars(pole) for pole in model.doubtful],
            "notes": list(model.notes),
            "indicators": indicators_of(measurement, points),
        }
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
