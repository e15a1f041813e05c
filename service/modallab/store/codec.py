"""Domain type <-> (JSON row, named arrays): one pair of functions a kind.

Arrays carry the names under which the API serves them, so that a stored file is the reply.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from modallab.core.assumption import Assumption
from modallab.core.dof import Dof
from modallab.core.frequency_inconsistency import FrequencyInconsistency
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import DoubtfulMode, ModalModel, Mode, StabilisationChart
from modallab.correlation.compare import Correlation
from modallab.diagnosis.result import Diagnosis
from modallab.fe.structure import Structure
from modallab.rig.estimates import Estimates
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.rig.time_records import TimeRecords
from modallab.store.npz import names, pack, unpack
from modallab.store.plain import Arrays, Json, from_plain, to_plain
from modallab.updating.direct.result import DirectResult
from modallab.updating.error_location.method import LocationResult
from modallab.updating.method import UpdateResult
from modallab.updating.studies.study import Study

T = TypeVar("T")
_ArrayMap = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Codec(Generic[T]):
    """Serialisation and deserialisation of things of one kind."""

    take_apart: Callable[[T], tuple[Json, Arrays]]
    put_together: Callable[[Json, _ArrayMap], T]


def _plain(cls: type[T]) -> Codec[T]:
    return Codec(to_plain, partial(from_plain, cls))


def _names(dofs: tuple[Dof, ...]) -> NDArray[np.str_]:
    return np.array([str(dof) for dof in dofs])


def _dofs(names: NDArray[np.str_]) -> tuple[Dof, ...]:
    return tuple(Dof.parse(name) for name in names.tolist())


def _present(arrays: Mapping[str, NDArray[Any] | None]) -> Arrays:
    return {name: array for name, array in arrays.items() if array is not None}


def arrays_of(thing: Measurement) -> Arrays:
    """Return a measurement's arrays by the names that the API serves them under."""
    return _present(
        {
            "freq": thing.frf.freq,
            "values": thing.frf.values,
            "coherence": thing.coherence,
            "outputs": _names(thing.frf.outputs),
            "inputs": _names(thing.frf.inputs),
            "kind": np.array(thing.frf.kind.value),
            "averages": np.array(thing.averages),
            "force_spectrum": thing.force_spectrum,
            "response_spectrum": thing.response_spectrum,
            "input_condition": thing.input_condition,
            "force_cross_spectra": thing.force_cross_spectra,
        }
    )


_RECORDS = "records_"  # before the names of the arrays of time records
_ESTIMATES = "estimates_"  # and of those of estimates after the first averages


def results_alone(payload: bytes) -> bytes:
    """Return the npz file of a measurement without its time records and its estimates on the way."""
    aside = (_RECORDS, _ESTIMATES)
    if not any(name.startswith(aside) for name in names(payload)):
        return payload
    return pack({name: a for name, a in unpack(payload).items() if not name.startswith(aside)})


def _prefixed(prefix: str, thing: TimeRecords | Estimates | None) -> Arrays:
    if thing is None:
        return {}
    return {f"{prefix}{f.name}": np.asarray(getattr(thing, f.name)) for f in fields(thing)}


def _records(arrays: _ArrayMap) -> TimeRecords | None:
    kept = _with_prefix(arrays, _RECORDS)
    return TimeRecords(kept["force"], kept["response"], float(kept["sample_rate"])) if kept else None


def _estimates(arrays: _ArrayMap) -> Estimates | None:
    kept = _with_prefix(arrays, _ESTIMATES)
    return Estimates(**kept) if kept else None


def _take_measurement(thing: Measurement) -> tuple[Json, Arrays]:
    arrays = arrays_of(thing) | _prefixed(_RECORDS, thing.records) | _prefixed(_ESTIMATES, thing.estimates)
    body = {"setup": to_plain(thing.setup)[0], "seed": thing.seed, "notes": list(thing.notes)}
    body |= {
        "assumed": [to_plain(assumption)[0] for assumption in thing.assumed],
        "averages_error": thing.averages_error,
    }
    return body | {"route": thing.route, "libraries": dict(thing.libraries)}, arrays


def _put_measurement(body: Json, arrays: _ArrayMap) -> Measurement:
    kind, outputs, inputs = FrfKind(str(arrays["kind"])), _dofs(arrays["outputs"]), _dofs(arrays["inputs"])
    return Measurement(
        frf=FrfSet(arrays["freq"], arrays["values"], outputs, inputs, kind),
        coherence=arrays.get("coherence"),
        averages=float(arrays["averages"]),
        setup=from_plain(RigSetup, body["setup"], {}),
        force_spectrum=arrays.get("force_spectrum"),
        response_spectrum=arrays.get("response_spectrum"),
        input_condition=arrays.get("input_condition"),
        force_cross_spectra=arrays.get("force_cross_spectra"),
        seed=body["seed"],
        route=body.get("route"),
        libraries=body.get("libraries", {}),
        notes=tuple(body["notes"]),
        assumed=tuple(from_plain(Assumption, tree, {}) for tree in body.get("assumed", ())),
        averages_error=body.get("averages_error"),
        records=_records(arrays),
        estimates=_estimates(arrays),
    )


_CHART = "chart_"  # before the names of a stabilisation chart's arrays
_INCONSISTENCY = "frequency_inconsistency_"  # and of those of frequency differences


def _take_modal_model(thing: ModalModel) -> tuple[Json, Arrays]:
    modes = [to_plain(mode)[0] for mode in thing.modes]
    shape_errors = [mode.shape_errors for mode in thing.modes if mode.shape_errors is not None]
    arrays = _present(
        {
            "frequencies": thing.frequencies,
            "loss_factors": thing.loss_factors,
            "shapes": thing.shapes,
            "shape_errors": np.stack(shape_errors, axis=1) if len(shape_errors) == len(thing.modes) else None,
            "dofs": _names(thing.dofs),
            "fitted_frequency": thing.fitted_frequency,
            "fitted_loss_factor": thing.fitted_loss_factor,
            "modal_constants": thing.modal_constant,
            "modal_constant_errors": thing.modal_constant_error,
            "fitted_lines": thing.fitted_lines,
            "residuals": thing.residuals,
            "out_of_band_eigenvalues": thing.out_of_band_eigenvalue,
            "out_of_band_constants": thing.out_of_band_constant,
            "resynthesis_error": thing.resynthesis_error,
        }
    )
    if thing.chart is not None:
        arrays |= {f"{_CHART}{f.name}": getattr(thing.chart, f.name) for f in fields(StabilisationChart)}
    body: Json = {"normalisation": thing.normalisation, "method": thing.method, "notes": list(thing.notes)}
    if thing.options:
        body["options"] = dict(thing.options)
    if thing.exclude:
        body["exclude"] = [list(band) for band in thing.exclude]
    if thing.ranges:
        body["ranges"] = [list(limits) for limits in thing.ranges]
    if thing.doubtful:
        body["doubtful"] = [to_plain(pole)[0] for pole in thing.doubtful]
    if thing.references:
        body["references"] = [str(dof) for dof in thing.references]
    if thing.frequency_inconsistency is not None:
        body["frequency_inconsistency"], inconsistency_arrays = to_plain(thing.frequency_inconsistency)
        arrays |= {f"{_INCONSISTENCY}{name}": array for name, array in inconsistency_arrays.items()}
    return body | {"modes": modes, "choices": dict(thing.choices)}, arrays


def _put_modal_model(body: Json, arrays: _ArrayMap) -> ModalModel:
    shapes, errors = arrays["shapes"], arrays.get("shape_errors")
    modes = []
    for r, tree in enumerate(body["modes"]):
        mode_arrays = {"shape": shapes[:, r]} | ({} if errors is None else {"shape_errors": errors[:, r]})
        modes.append(from_plain(Mode, tree, mode_arrays))
    return ModalModel(
        modes=tuple(modes),
        dofs=_dofs(arrays["dofs"]),
        normalisation=body["normalisation"],
        method=body["method"],
        fitted_frequency=arrays.get("fitted_frequency"),
        fitted_loss_factor=arrays.get("fitted_loss_factor"),
        modal_constant=arrays.get("modal_constants"),
        modal_constant_error=arrays.get("modal_constant_errors"),
        fitted_lines=arrays.get("fitted_lines"),
        residuals=arrays.get("residuals"),
        out_of_band_eigenvalue=arrays.get("out_of_band_eigenvalues"),
        out_of_band_constant=arrays.get("out_of_band_constants"),
        resynthesis_error=arrays.get("resynthesis_error"),
        references=_references(body),
        frequency_inconsistency=_inconsistency(body, arrays),
        chart=None if f"{_CHART}order" not in arrays else _chart(arrays),
        doubtful=tuple(from_plain(DoubtfulMode, tree, {}) for tree in body.get("doubtful", ())),
        choices=body.get("choices", {}),
        options=body.get("options", {}),
        exclude=tuple((lower, upper) for lower, upper in body.get("exclude", ())),
        ranges=tuple((lower, upper) for lower, upper in body.get("ranges", ())),
        notes=tuple(body["notes"]),
    )


def _inconsistency(body: Json, arrays: _ArrayMap) -> FrequencyInconsistency | None:
    tree = body.get("frequency_inconsistency")
    fields_by_name = _with_prefix(arrays, _INCONSISTENCY)
    return None if tree is None else from_plain(FrequencyInconsistency, tree, fields_by_name)


def _references(body: Json) -> tuple[Dof, ...]:
    """Return the references of FRFs; models stored by earlier versions have one `drive`."""
    names = body.get("references", [body["drive"]] if "drive" in body else [])
    return tuple(Dof.parse(name) for name in names)


def _with_prefix(arrays: _ArrayMap, prefix: str) -> _ArrayMap:
    return {name.removeprefix(prefix): a for name, a in arrays.items() if name.startswith(prefix)}


def _chart(arrays: _ArrayMap) -> StabilisationChart:
    return StabilisationChart(**{f.name: arrays[f"{_CHART}{f.name}"] for f in fields(StabilisationChart)})


_CURVES = "curves."  # under which `to_plain` names the arrays of a diagnosis


def _take_diagnosis(thing: Diagnosis) -> tuple[Json, Arrays]:
    body, arrays = to_plain(thing)
    curves = thing.curves
    names = {"outputs": curves.outputs, "inputs": curves.inputs}
    if curves.predicted is not None:
        names["predicted_outputs"] = curves.predicted_outputs
    served = {name.removeprefix(_CURVES): array for name, array in arrays.items()}
    return body, served | {name: _names(dofs) for name, dofs in names.items()}


def _put_diagnosis(body: Json, arrays: _ArrayMap) -> Diagnosis:
    of_curves = {f"{_CURVES}{name}": array for name, array in arrays.items()}
    return from_plain(Diagnosis, body, of_curves | dict(arrays))  # a structure may have arrays of its own


def _put_update(body: Json, arrays: _ArrayMap) -> UpdateResult | DirectResult | LocationResult:
    # Each has a field that the others lack.
    if "dof_errors" in body:
        return from_plain(DirectResult, body, arrays)
    if "changes" in body:
        return from_plain(LocationResult, body, arrays)
    return from_plain(UpdateResult, body, arrays)


CODECS: Mapping[str, Codec[Any]] = {
    "structure": _plain(Structure),
    "rig": _plain(RigSetup),
    "measurement": Codec(_take_measurement, _put_measurement),
    "modal_model": Codec(_take_modal_model, _put_modal_model),
    "correlation": _plain(Correlation),
    "update": Codec(to_plain, _put_update),
    "study": _plain(Study),
    "diagnosis": Codec(_take_diagnosis, _put_diagnosis),
}
