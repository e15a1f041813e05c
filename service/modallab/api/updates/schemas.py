"""Wire types of updates."""

from collections.abc import Set
from typing import Annotated, Any, Self, cast

from pydantic import Field

from modallab.api.deps import Id
from modallab.api.derived import OptionsByMethod, body_of, options_from, refuse_foreign
from modallab.api.reductions import Reduced, ReductionIn
from modallab.api.schema import OneOf
from modallab.api.updates.direct import DirectOut, direct_fields
from modallab.api.updates.identified import IdentifiabilityOut, QuantityOut
from modallab.api.updates.located import LocatedOut, located_fields, number
from modallab.api.updates.parameterisation import ParameterisationIn
from modallab.api.updates.posterior import PosteriorOut
from modallab.api.updates.responses import ResponsesOut
from modallab.api.wire import NoiseFloor, StoredEntry, Text, Wire
from modallab.core.errors import InvalidInputError
from modallab.fe.structure import Structure
from modallab.jobs.updating import UpdateInputs, UpdateRequest
from modallab.store.base import Entry
from modallab.updating.direct.method import DIRECT_METHODS, EXPANSION, DirectOptions
from modallab.updating.direct.result import DirectResult
from modallab.updating.error_location.method import LocationResult
from modallab.updating.iteration import Iteration
from modallab.updating.method import Stages, UpdateResult
from modallab.updating.method_options import METHODS, method_called
from modallab.updating.options import LocationOptions, OneStageOptions, UpdateOptions
from modallab.updating.responses.method import RESPONSE_UPDATERS
from modallab.updating.sampling import require_sampler

Completion = Annotated[
    Text | ReductionIn,
    Field(description="`expansion` of shapes to all DoFs, or a reduction of the model to measured ones"),
]
_TYPES = dict.fromkeys(method.options for method in METHODS.values())
UPDATE_BODIES = {
    cls: body_of(cls, completion=Completion, expansion=Reduced) if cls is DirectOptions else body_of(cls)
    for cls in _TYPES
}
UpdateOptionsBody = Annotated[
    Wire, OptionsByMethod({name: UPDATE_BODIES[method.options] for name, method in METHODS.items()})
]


def coefficient_options(method: str, body: Wire) -> UpdateOptions | LocationOptions:
    """Return the options of a method that moves coefficients, or locates errors by one step.

    Raises
    ------
    InvalidInputError
        If one is out of bounds, or draws are asked for where nothing can draw them.
    """
    options = options_from(method_called(method).options, body)
    if isinstance(options, OneStageOptions) and options.samples:
        require_sampler()  # known now: no job fails for it later
    return cast(UpdateOptions | LocationOptions, options)


def direct_options(body: Any) -> DirectOptions:
    """Return the options of a direct method; `InvalidInputError` where one is wrong."""
    refuse_foreign(body)
    completion, parameters = _kind_and_parameters(body.completion)
    if completion != EXPANSION:
        refuse(body.model_fields_set & {"expansion"}, "a method on a reduced model")
        return DirectOptions(completion, reduction_parameters=parameters, n_modes=body.n_modes)
    refuse(parameters.keys(), "an expansion without a reduction, which `expansion` takes")
    kind, parameters = _kind_and_parameters(body.expansion)
    return DirectOptions(EXPANSION, kind, body.n_modes, parameters)


def _kind_and_parameters(given: str | ReductionIn) -> tuple[str, dict[str, float]]:
    return (given, {}) if isinstance(given, str) else (given.kind, given.parameters)


def refuse(fields: Set[str], of: str) -> None:
    """Raise `InvalidInputError` if options were given that mean nothing to a method."""
    if fields:
        name = min(fields)
        raise InvalidInputError(f"{name} is no option of {of}", field=name, value=name, allowed="left out")


class UpdateStart(Wire):
    """A model to be corrected until its modes, or its frequency responses, are the measured ones."""

    structure_id: Id
    modal_model_id: Id | None = Field(default=None, description="of every method but those that take FRFs")
    measurement_id: Id | None = Field(default=None, description="of a method that takes FRFs: frf_residual")
    noise_floor: NoiseFloor | None = Field(
        default=None,
        description="relative random error of every measured FRF, beside what coherence and averages tell",
    )
    method: Annotated[Text, OneOf(lambda: METHODS)] = Field(
        default="inverse_eigensensitivity",
        description="updating method, as `/catalog/updating-methods` lists them",
    )
    parameterisation: ParameterisationIn = ParameterisationIn()
    options: UpdateOptionsBody = Field(
        default_factory=dict, validate_default=True, description="options of the method"
    )

    def to_task(self, structure: Structure) -> tuple[UpdateInputs, UpdateRequest]:
        """Return the task's inputs and options, checked as far as can be before the work.

        Raises
        ------
        InvalidInputError
            If the method, a part, a member or an option is unknown or out of bounds.
        """
        method_called(self.method)
        inputs = self._inputs()
        if self.method in DIRECT_METHODS:
            refuse(self.model_fields_set & {"parameterisation"}, "a direct method")
            return inputs, UpdateRequest(self.method, direct_options(self.options))
        options = coefficient_options(self.method, self.options)
        parameterisation = self.parameterisation.to_domain(structure, self.method)
        return inputs, UpdateRequest(self.method, options, parameterisation, self.noise_floor)

    def _inputs(self) -> UpdateInputs:
        """Return the ids of the model and of what was measured."""
        modes = {"modal_model_id": self.modal_model_id}
        responses = {"measurement_id": self.measurement_id, "noise_floor": self.noise_floor}
        on_responses = self.method in RESPONSE_UPDATERS
        wanted, other = (responses, modes) if on_responses else (modes, responses)
        refuse({name for name, value in other.items() if value is not None}, self.method)
        name = next(iter(wanted))
        if wanted[name] is None:
            raise InvalidInputError(f"{self.method} needs a {name}", field=name, value=None, allowed="an id")
        return UpdateInputs(self.structure_id, self.modal_model_id, self.measurement_id)


class UpdateOut(StoredEntry):
    """How an update went; coefficients and errors by part and member, 1 = no change, 0 of damping.

    A direct method has none of these but `direct`, one that only locates none but `suspected` and `located`;
    neither makes a structure. A method that takes FRFs has `responses` and no measured frequencies or MAC.
    """

    converged: bool
    stopped_because: str
    iterations: dict[str, int]
    coefficients: dict[str, dict[int, float | None]]
    standard_errors: dict[str, dict[int, float | None]]
    suspected: dict[str, list[int]]
    frequencies: dict[str, list[float] | None]
    mac: dict[str, list[float] | None]
    rank: int | None
    condition_number: float | None
    history: list[dict[str, Any]]
    structure_id: str | None
    intervals: dict[str, dict[int, tuple[float, float]]] = Field(
        default={}, description="low and high end of what holds a coefficient with 95 %, by the data alone"
    )
    identifiability: IdentifiabilityOut | None = None
    quantities: list[QuantityOut] = Field(
        default=[], description="properties that were free to move, in their units; before, after"
    )
    posterior: PosteriorOut | None = Field(default=None, description="if draws were asked for")
    responses: ResponsesOut | None = None
    direct: DirectOut | None = None
    located: LocatedOut | None = None

    @classmethod
    def of(cls, result: UpdateResult | DirectResult | LocationResult, entry: Entry) -> Self:
        """Return what the contract shows of an update."""
        if isinstance(result, DirectResult):
            return cls(**cls.fields(entry), **direct_fields(result))
        if isinstance(result, LocationResult):
            return cls(**cls.fields(entry), **located_fields(result))
        told = result.identifiability
        return cls(
            **cls.fields(entry),
            converged=result.converged,
            stopped_because=result.stopped_because,
            iterations=dict(result.iterations),
            coefficients={part: _finite(found) for part, found in result.coefficients.items()},
            standard_errors={part: _finite(found) for part, found in result.standard_errors.items()},
            suspected={part: list(found) for part, found in result.suspected.items()},
            frequencies=_stages(result.frequencies),
            mac=_stages(result.mac),
            rank=result.rank,
            condition_number=number(result.condition_number),
            history=[_iteration(one) for one in result.history],
            structure_id=entry.inputs["updated_structure_id"],
            intervals={part: dict(table) for part, table in result.intervals.items()},
            identifiability=None if told is None else IdentifiabilityOut.of(told),
            quantities=[QuantityOut.of(one) for one in result.quantities],
            posterior=None if result.posterior is None else PosteriorOut.of(result.posterior),
            responses=None if result.responses is None else ResponsesOut.of(result.responses),
        )


def _finite(values: Any) -> dict[int, float | None]:
    return {member: number(value) for member, value in values.items()}


def _stages(stages: Stages) -> dict[str, list[float] | None]:
    values = {name: getattr(stages, name) for name in ("measured", "before", "location", "after")}
    return {name: None if value is None else value.tolist() for name, value in values.items()}


def _iteration(one: Iteration) -> dict[str, Any]:
    coefficients = [
        {"part": macro.part, "members": macro.members, "value": float(value)}
        for macro, value in zip(one.macros, one.coefficients, strict=True)
    ]
    return {
        "stage": one.stage,
        "max_change": one.max_change,
        "rank": one.rank,
        "condition_number": number(one.condition_number),
        "coefficients": coefficients,
        "frequencies": one.frequencies.tolist(),
        "mac": one.mac.tolist(),
    }
