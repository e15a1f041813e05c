"""Modes out of measurements: the extraction of all, and of one fit once more to look at it."""

from typing import Any

from modallab.core.progress import Progress
from modallab.estimation.windows import WINDOWS, added_loss_factor
from modallab.extraction.extract import extract
from modallab.extraction.leakage import Leakage
from modallab.extraction.options import ExtractionOptions
from modallab.extraction.window_damping import without_added
from modallab.jobs.destination import Destination
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.setup import RigSetup
from modallab.store.base import Store
from modallab.store.plain import from_plain, to_plain

Json = Any

_PERIODIC = 0.0  # share of the power that leaks, of an excitation that repeats with the record
_WINDOW_SAMPLES = 1024
_CHOSEN = to_plain(ExtractionOptions())[0]


def leakage_of(setup: RigSetup) -> Leakage | None:
    """Return what the declared analyser does to lines, None if its records repeat or die out."""
    analyser = setup.analyser
    if EXCITATIONS[analyser.excitation.kind].continuous == _PERIODIC:
        return None
    window = WINDOWS[analyser.window].samples(_WINDOW_SAMPLES)
    return Leakage.of(window, analyser.estimator, source_mass=setup.exciter.armature_mass)


def extract_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    *,
    measurement_id: str,
    method: str,
    bands: list[tuple[float, float]] | None,
    n_modes: int | None,
    options: Json = _CHOSEN,
    correct_window_damping: bool = False,
) -> None:
    """Read the modes from a measurement and keep them."""
    measurement = store.measurements.get(measurement_id)
    model = extract(
        measurement.frf,
        coherence=measurement.coherence,
        averages=measurement.averages,
        method=method,
        options=from_plain(ExtractionOptions, options, {}),
        bands=bands,
        n_modes=n_modes,
        leakage=leakage_of(measurement.setup),
        progress=progress,
    )
    analyser = measurement.setup.analyser
    if correct_window_damping and analyser.line_window.end < 1:
        end = analyser.line_window.end
        model = without_added(model, added_loss_factor(end, analyser.record_length, model.frequencies))
    store.modal_models.add(model, owner=into.owner, inputs={"measurement_id": measurement_id}, id=into.id)
