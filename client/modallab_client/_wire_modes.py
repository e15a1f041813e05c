"""JSON and npz to modal models; pure."""

from modallab_client._wire import Arrays, Json, floats, number, texts
from modallab_client.modes import Complexity, ModalModel, Mode, Spread, Wander


def modal_model(data: Json, given: Arrays) -> ModalModel:
    """Return a modal model from its JSON and arrays."""
    return ModalModel(
        id=data["id"],
        modes=tuple(_mode(one) for one in data["modes"]),
        method=data.get("method") or "",
        measurement_id=data.get("measurement_id"),
        dofs=texts(data["dofs"]),
        shapes=given["shapes"],
        modal_constants=given.get("modal_constants"),
        fitted_frequencies=given.get("fitted_frequency"),
        fitted_loss_factors=given.get("fitted_loss_factor"),
        shape_errors=given.get("shape_errors"),
        modal_constant_errors=given.get("modal_constant_errors"),
        choices=dict(data.get("choices") or {}),
        resynthesis_error=data.get("resynthesis_error"),
        wander=_wander(data.get("wander"), given),
        notes=texts(data.get("notes") or ()),
        references=texts(data.get("references") or ()),
        frfs=texts(data.get("frfs") or ()),
    )


def _mode(data: Json) -> Mode:
    return Mode(
        frequency=data["frequency"],
        loss_factor=data["loss_factor"],
        frequency_spread=_spread(data.get("frequency_spread")),
        loss_factor_spread=_spread(data.get("loss_factor_spread")),
        standard_errors=dict(data.get("standard_errors") or {}),
        flags=texts(data.get("flags") or ()),
        complexity=_complexity(data.get("complexity")),
    )


def _spread(data: Json | None) -> Spread | None:
    if not data:
        return None
    low, high, mean, sd = (number(data[name]) for name in ("min", "max", "mean", "sd"))
    return Spread(low, high, mean, sd, int(data["n"]))


def _wander(data: Json | None, given: Arrays) -> Wander | None:
    """Return how frequencies wander, None where they do not; its table is among the arrays."""
    if not data:
        return None
    return Wander(
        cause=data["cause"],
        size=number(data["size"]),
        size_error=number(data["size_error"]),
        unit=data.get("unit") or "",
        explained=number(data["explained"]),
        shift=given["wander_shift"],
        shift_error=given["wander_shift_error"],
        still_frequency=floats(data["still_frequency"]),
    )


def _complexity(data: Json | None) -> Complexity | None:
    """Return how complex a shape is, None where nothing is said of it."""
    if not data:
        return None
    return Complexity(*(number(data[name]) for name in ("mpc", "mean_phase", "mean_phase_deviation")))
