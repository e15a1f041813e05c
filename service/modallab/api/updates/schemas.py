"""Request of an update."""

from collections.abc import Set
from typing import Annotated, Any, cast

from pydantic import ConfigDict, Field

from modallab.api.deps import Id
from modallab.api.derived import OptionsByMethod, body_of, options_from, refuse_foreign
from modallab.api.reductions import Reduced, ReductionIn
from modallab.api.schema import OneOf
from modallab.api.updates.parameterisation import ParameterisationIn
from modallab.api.wire import NoiseFloor, Text, Wire
from modallab.core.errors import InvalidInputError
from modallab.core.line_options import LineOptions
from modallab.fe.structure import Structure
from modallab.jobs.updating import UpdateInputs, UpdateRequest
from modallab.updating.direct.method import DIRECT_METHODS, EXPANSION, DirectOptions
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


def _kind_and_parameters(reduction: str | ReductionIn) -> tuple[str, dict[str, float]]:
    return (reduction, {}) if isinstance(reduction, str) else (reduction.kind, reduction.parameters)


def refuse(fields: Set[str], of: str) -> None:
    """Raise `InvalidInputError` if options were given that mean nothing to a method."""
    if fields:
        name = min(fields)
        raise InvalidInputError(f"{name} is no option of {of}", field=name, value=name, allowed="left out")


class UpdateStart(body_of(LineOptions)):  # type: ignore[misc]
    """A model to be corrected until its modes, or its frequency responses, are the measured ones."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    structure_id: Id
    """model that is corrected"""
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
    """coefficients that may change; not for direct methods"""
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
        return inputs, UpdateRequest(self.method, options, parameterisation, self.noise_floor, self.lines)

    @property
    def lines(self) -> LineOptions:
        """The lines of measured FRFs that count."""
        return options_from(LineOptions, self)

    def _inputs(self) -> UpdateInputs:
        """Return the ids of the model and of what was measured."""
        modes = {"modal_model_id": self.modal_model_id}
        lines = {"bands": self.lines.bands, "exclude": self.lines.exclude or None}
        responses = {"measurement_id": self.measurement_id, "noise_floor": self.noise_floor, **lines}
        on_responses = self.method in RESPONSE_UPDATERS
        required, unused = (responses, modes) if on_responses else (modes, responses)
        refuse({name for name, value in unused.items() if value is not None}, self.method)
        name = next(iter(required))
        if required[name] is None:
            raise InvalidInputError(f"{self.method} needs a {name}", field=name, value=None, allowed="an id")
        return UpdateInputs(self.structure_id, self.modal_model_id, self.measurement_id)
