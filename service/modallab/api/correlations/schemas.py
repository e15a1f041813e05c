"""Wire types of correlations."""

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from modallab.api.deps import Id
from modallab.api.reductions import Reduced
from modallab.api.wire import EntryOut, ModeCount, Wire
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfSet
from modallab.correlation.compare import Correlation
from modallab.correlation.orthogonality import Orthogonality
from modallab.correlation.responses import ResponseCorrelation
from modallab.store.base import Entry

MOST_VALUES = 2_000_000  # measured lines times FRFs that are held against a model while one waits


class CorrelationIn(Wire):
    """Measured modes against the first `count` elastic modes of a structure, as many by default.

    `reduction` adds orthogonality in the structure's mass, reduced to the common DoFs; `measurement_id`
    the measured FRFs against the structure's.
    """

    modal_model_id: Id
    """id of the measured modes"""
    structure_id: Id
    """id of the structure"""
    count: ModeCount | None = None
    """elastic modes of the structure; left out: as many as were measured"""
    reduction: Reduced | None = None
    """reduction of the mass matrix to the measured degrees of freedom; null: no orthogonality"""
    measurement_id: Id | None = None
    """id of a measurement whose FRFs are compared too"""

    @property
    def inputs(self) -> dict[str, str]:
        """What the correlation is made from."""
        ids = {"modal_model_id": self.modal_model_id, "structure_id": self.structure_id}
        return ids if self.measurement_id is None else ids | {"measurement_id": self.measurement_id}


def small(frf: FrfSet) -> FrfSet:
    """Return FRFs as they are; `InvalidInputError` if they are too many to wait for."""
    if frf.values.size > MOST_VALUES:
        raise InvalidInputError(
            "too many lines and FRFs to wait for",
            field="measurement_id",
            value=frf.values.size,
            allowed=f"lines x FRFs <= {MOST_VALUES}",
        )
    return frf


class ReductionUsed(BaseModel):
    """The reduction of the mass: motions its model has, and errors of its frequencies, relative, each of
    the mode most like that of the full model."""

    kind: str
    parameters: dict[str, float]
    n_motions: int
    frequency_errors: list[float]


class CorrelationOut(EntryOut):
    """MAC (measured, model); pairs (measured, model) counted from 1; differences in Hz by pair.

    `cross_orthogonality` (measured, model) and `auto_orthogonality` (measured, measured) come with a
    reduction; `frac` (output, input) and the scale of the FDAC's ridge with a measurement.
    """

    mac: list[list[float]]
    pairs: list[tuple[int, int]]
    frequency_differences: list[float]
    comac: list[float]
    dofs: list[str]
    ecomac: list[float] | None
    pole_weighted_mac: list[list[float]] | None
    reduction: ReductionUsed | None
    cross_orthogonality: list[list[float]] | None
    auto_orthogonality: list[list[float]] | None
    frac: list[list[float]] | None
    outputs: list[str] | None
    inputs: list[str] | None
    frequency_scale: float | None
    fdac_on_ridge: float | None
    fdac_unscaled: float | None
    notes: list[str]

    @classmethod
    def of(cls, correlation: Correlation, entry: Entry) -> Self:
        """Return what the contract shows of a correlation."""
        return cls(
            **cls.fields(entry),
            mac=correlation.mac.tolist(),
            pairs=[(measured + 1, model + 1) for measured, model in correlation.pairs],
            frequency_differences=correlation.frequency_differences.tolist(),
            comac=correlation.comac.tolist(),
            dofs=_names(correlation.dofs),
            ecomac=_listed(correlation.ecomac),
            pole_weighted_mac=_listed(correlation.pole_weighted_mac),
            **_mass_out(correlation.orthogonality),
            **_responses_out(correlation.responses),
        )


def _mass_out(found: Orthogonality | None) -> dict[str, Any]:
    if found is None:
        return dict.fromkeys(("reduction", "cross_orthogonality", "auto_orthogonality"))
    errors = found.frequency_errors.tolist()
    used = ReductionUsed(
        kind=found.reduction,
        n_motions=found.n_motions,
        parameters=dict(found.parameters),
        frequency_errors=errors,
    )
    matrices = {"cross_orthogonality": found.cross.tolist(), "auto_orthogonality": found.auto.tolist()}
    return {"reduction": used, **matrices}


def _responses_out(found: ResponseCorrelation | None) -> dict[str, Any]:
    names = ("frequency_scale", "fdac_on_ridge", "fdac_unscaled")
    if found is None:
        return dict.fromkeys((*names, "frac", "outputs", "inputs")) | {"notes": []}
    points = {"outputs": _names(found.outputs), "inputs": _names(found.inputs)}
    out = points | {"frac": found.frac.tolist(), "notes": list(found.notes)}
    return out | {name: getattr(found, name) for name in names}


def _names(dofs: tuple[Dof, ...]) -> list[str]:
    return [str(dof) for dof in dofs]


def _listed(values: NDArray[Any] | None) -> Any:
    return None if values is None else values.tolist()


def arrays_out(correlation: Correlation) -> Mapping[str, NDArray[Any]]:
    """Return a correlation's arrays by the names of the reply, the FDAC and its lines with them."""
    mass, responses = correlation.orthogonality, correlation.responses
    arrays: dict[str, NDArray[Any] | None] = {
        "mac": correlation.mac,
        "pairs": np.array(correlation.pairs, dtype=int).reshape(-1, 2) + 1,
        "frequency_differences": correlation.frequency_differences,
        "comac": correlation.comac,
        "dofs": np.array(_names(correlation.dofs)),
        "ecomac": correlation.ecomac,
        "pole_weighted_mac": correlation.pole_weighted_mac,
    }
    if mass is not None:
        arrays |= {"cross_orthogonality": mass.cross, "auto_orthogonality": mass.auto}
    if responses is not None:
        points = {"outputs": responses.outputs, "inputs": responses.inputs}
        arrays |= {name: np.array(_names(dofs)) for name, dofs in points.items()}
        arrays |= {"frac": responses.frac, "fdac_freq": responses.freq, "fdac": responses.fdac}
    return {name: array for name, array in arrays.items() if array is not None}
