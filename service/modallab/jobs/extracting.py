"""Modal extraction from measurements, and the plot data of a fit or of synthesised FRFs."""

from dataclasses import dataclass, replace

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.line_options import Band, line_mask
from modallab.core.modal_model import ModalModel
from modallab.core.progress import Progress
from modallab.estimation.error_correlation import ErrorCorrelation
from modallab.estimation.windows import WINDOWS, added_loss_factor
from modallab.extraction.averaging.resynthesis import resynthesise
from modallab.extraction.averaging.window_damping import without_window_damping
from modallab.extraction.extract import extract, responses_read
from modallab.extraction.options import ExtractionOptions
from modallab.extraction.plot_data import FitPlotData, fit_plot_data
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.jobs.destination import Destination
from modallab.jobs.settings import JOB
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.measure import Route
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.store.base import Store

_CORRECTED = "window_damping"  # among the choices of a model whose loss factors are without it


def leakage_of(setup: RigSetup) -> WindowLeakage | None:
    """Return the leakage of the declared analyser; None if its records are periodic or decay."""
    analyser = setup.analyser
    if EXCITATIONS[analyser.excitation.kind].continuous == 0.0:  # periodic in the record: no leakage
        return None
    window = WINDOWS[analyser.window].samples(JOB.window_samples)
    return WindowLeakage.from_window(window, analyser.estimator, source_mass=setup.exciter.armature_mass)


def correlation_of(measurement: Measurement) -> ErrorCorrelation | None:
    """Return the correlation of the errors of lines by an exponential window; None: lines are independent.

    That of imported lines is the one of the declared window, and of a blow at the start of the record unless
    the log book declares an impact. Lines that are drawn one by one are independent.
    """
    analyser = measurement.setup.analyser
    if analyser.line_window.end == 1 or measurement.route == Route.DRAWN:
        return None
    setting, kind = analyser.excitation, EXCITATIONS[analyser.excitation.kind]
    return ErrorCorrelation(
        analyser.line_window,
        random_force=kind.transient is not None and not kind.deterministic,
        delay=setting.pre_trigger if kind.deterministic_transient else 0.0,
    )


@dataclass(frozen=True)
class ExtractionInputs:
    """Stored things that modes are extracted from."""

    measurement_id: str


@dataclass(frozen=True)
class ExtractionRequest:
    """Extraction of modes by a method with its options."""

    method: str | None
    """Name of the method; None: by the number of references."""
    options: ExtractionOptions
    bands: tuple[tuple[float, float], ...] | None = None
    """Hz, lower and upper end, one mode each, of a global method one or more; None: from the FRFs."""
    n_modes: int | None = None
    """Number of modes to keep, the most prominent ones; None: all."""
    exclude: tuple[Band, ...] = ()
    """Hz, lower and upper end of bands whose lines are left out."""
    correct_window_damping: bool = False
    """Whether the damping that an exponential window adds is taken out of the loss factors."""


def extract_and_store(
    store: Store, progress: Progress, into: Destination, inputs: ExtractionInputs, request: ExtractionRequest
) -> None:
    """Extract the modes of a measurement and keep them."""
    measurement = store.measurements.get(inputs.measurement_id)
    model = extract(
        measurement.frf,
        coherence=measurement.coherence,
        averages=measurement.averages,
        method=request.method,
        options=request.options,
        bands=request.bands,
        n_modes=request.n_modes,
        exclude=request.exclude,
        leakage=leakage_of(measurement.setup),
        estimator=measurement.setup.analyser.estimator,
        correlation=correlation_of(measurement),
        progress=progress,
    )
    if request.correct_window_damping and measurement.setup.analyser.line_window.end < 1:
        model = without_window_damping(model, _added(measurement.setup, model))
        model = replace(model, choices={**model.choices, _CORRECTED: "subtracted: as requested"})
    store.modal_models.add(
        model, owner=into.owner, inputs={"measurement_id": inputs.measurement_id}, id=into.id
    )


def picture_of(
    measurement: Measurement, model: ModalModel, mode: int, response: Dof, reference: Dof | None = None
) -> FitPlotData:
    """Return the fit of one mode, counted from 1, in one FRF of the measurement it was read from.

    The reference selects the FRF of a response; it may be omitted where there is one reference.

    Raises
    ------
    InvalidInputError
        If there is no such fit.
    """
    if response not in model.dofs:
        raise InvalidInputError(
            f"no FRF at {response}",
            field="response",
            value=str(response),
            allowed=[str(dof) for dof in model.dofs[: JOB.listed_dofs]],
        )
    if not 1 <= mode <= len(model.modes):
        raise InvalidInputError("no such mode", field="mode", value=mode, allowed=bounds(1, len(model.modes)))
    if reference is None and len(model.references) == 1:
        reference = model.references[0]
    if reference not in model.references:
        raise InvalidInputError(
            "which reference is not told" if reference is None else f"no FRFs of reference {reference}",
            field="reference",
            value=None if reference is None else str(reference),
            allowed=[str(dof) for dof in model.references],
        )
    leakage = leakage_of(measurement.setup)
    measurement = measurement.at(line_mask(measurement.frf.freq, exclude=model.exclude))
    responses, _ = responses_read(
        measurement.frf,
        measurement.coherence,
        measurement.averages,
        leakage=leakage,
        estimator=measurement.setup.analyser.estimator,
    )
    as_fitted = as_measured(model, measurement.setup)
    row = model.dofs.index(response) * len(model.references) + model.references.index(reference)
    return fit_plot_data(responses, as_fitted, mode - 1, row, leakage=leakage)


def resynthesised(measurement: Measurement, model: ModalModel) -> FrfSet:
    """Return the FRFs synthesised from the modes: lines, points and kind of the measured ones.

    Only inertance includes 0 Hz: the receptance of a rigid body is infinite there.

    Raises
    ------
    InvalidInputError
        If the model tells nothing of FRFs.
    """
    frf = measurement.frf
    freq = frf.freq if frf.kind is FrfKind.INERTANCE else frf.freq[frf.freq > 0]
    synthesised = resynthesise(as_measured(model, measurement.setup), freq, frf.kind)
    if synthesised.inputs == frf.inputs:
        return synthesised
    return FrfSet(
        synthesised.freq,
        synthesised.values.transpose(0, 2, 1),
        synthesised.inputs,
        synthesised.outputs,
        synthesised.kind,
    )


def _added(setup: RigSetup, model: ModalModel) -> FloatArray:
    """Return the loss factors that an exponential window adds, (n_modes,)."""
    analyser = setup.analyser
    return added_loss_factor(analyser.line_window.end, analyser.record_length, model.frequencies)


def as_measured(model: ModalModel, setup: RigSetup) -> ModalModel:
    """Return the modes with the damping that the window added, as the measured lines have it."""
    return without_window_damping(model, -_added(setup, model)) if _CORRECTED in model.choices else model
