"""Models corrected, or searched for errors, by measured modes or frequency responses."""

from dataclasses import dataclass

from modallab.core.errors import InvalidInputError
from modallab.core.line_options import ALL_LINES, LineOptions, line_mask
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress
from modallab.fe.structure import Structure
from modallab.jobs.destination import Destination
from modallab.rig.exact import as_modelled, with_effects
from modallab.rig.measurement import Measurement
from modallab.rig.noise_bias import without_noise_bias
from modallab.store.base import Store
from modallab.updating.direct.method import DirectOptions
from modallab.updating.direct.result import DirectResult
from modallab.updating.direct.run import update_directly
from modallab.updating.error_location.method import LocationResult
from modallab.updating.error_location.run import locate
from modallab.updating.method import UPDATERS, UpdateResult
from modallab.updating.options import LocationOptions, UpdateOptions
from modallab.updating.parameterisation import Parameterisation
from modallab.updating.responses.method import RESPONSE_UPDATERS
from modallab.updating.responses.target import TargetResponses, target_responses


@dataclass(frozen=True)
class UpdateInputs:
    """Stored things that an update is made from: a model, and modes or a measurement."""

    structure_id: str
    modal_model_id: str | None = None
    measurement_id: str | None = None

    @property
    def sources(self) -> dict[str, str]:
        """The ids by name, without those that are not given."""
        return {name: id for name, id in vars(self).items() if id is not None}


@dataclass(frozen=True)
class UpdateRequest:
    """Update by a method of any family, with its options."""

    method: str
    options: UpdateOptions | LocationOptions | DirectOptions
    parameterisation: Parameterisation | None = None
    """Coefficients that may move; None of a direct method."""
    noise_floor: float | None = None
    """Relative random error of every measured FRF, beside what coherence and averages tell."""
    lines: LineOptions = ALL_LINES
    """Lines of measured FRFs that count."""


def update_and_store(
    store: Store, progress: Progress, into: Destination, inputs: UpdateInputs, request: UpdateRequest
) -> None:
    """Run an updating method of any family; store its result, and the updated model if there is one.

    Matrices of a direct method are no structure, and what only locates errors leaves the model as it is.
    """
    structure = store.structures.get(inputs.structure_id)
    target: ModalModel | TargetResponses
    if inputs.measurement_id is not None:
        measurement = store.measurements.get(inputs.measurement_id)
        target = measured_responses(measurement, request.noise_floor, request.lines)
    else:
        target = store.modal_models.get(str(inputs.modal_model_id))
    result = _run_method(structure, target, request, progress)
    sources = inputs.sources
    with store.together() as batch:
        if isinstance(result, UpdateResult):
            updated_id = into.derived_id("structure")
            batch.structures.add(result.structure, owner=into.owner, inputs=sources, id=updated_id)
            sources = sources | {"updated_structure_id": updated_id}
        batch.updates.add(result, owner=into.owner, inputs=sources, id=into.id)


def measured_responses(
    measurement: Measurement, noise_floor: float | None, lines: LineOptions = ALL_LINES
) -> TargetResponses:
    """Return measured FRFs at the lines that count, with their random errors.

    Raises
    ------
    InvalidInputError
        If the random errors are not known, or a band has no lines.
    """
    measurement = measurement.at(line_mask(measurement.frf.freq, lines.bands, lines.exclude))
    frf, common = without_noise_bias(measurement)
    return target_responses(frf, measurement.coherence, measurement.averages, noise_floor, common)


def _run_method(
    structure: Structure, target: ModalModel | TargetResponses, request: UpdateRequest, progress: Progress
) -> UpdateResult | DirectResult | LocationResult:
    method, options, parameterisation = request.method, request.options, request.parameterisation
    if isinstance(target, ModalModel) and isinstance(options, DirectOptions):
        return update_directly(as_modelled(structure), method, target, options=options, progress=progress)
    structure = with_effects(structure)
    if parameterisation is None:
        raise InvalidInputError(
            f"{method} moves coefficients", field="parameterisation", value="none", allowed=["coefficients"]
        )
    if isinstance(options, UpdateOptions) and isinstance(target, TargetResponses):
        responses_updater = RESPONSE_UPDATERS[method]
        return responses_updater(structure, parameterisation, target, options=options, progress=progress)
    if isinstance(options, UpdateOptions) and isinstance(target, ModalModel):
        return UPDATERS[method](structure, parameterisation, target, options=options, progress=progress)
    if isinstance(options, LocationOptions) and isinstance(target, ModalModel):
        return locate(structure, parameterisation, method, target, options=options, progress=progress)
    raise InvalidInputError(
        f"{method} does not take these options or data", field="method", value=method, allowed="others"
    )
