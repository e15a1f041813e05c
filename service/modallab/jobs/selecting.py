"""Modes of a modal model dropped or merged, with their misfit to the measurement that they are from."""

from dataclasses import replace

import numpy as np

from modallab.core.line_options import line_mask
from modallab.core.modal_model import ModalModel
from modallab.extraction.averaging.resynthesis import MISFIT_NOTE, with_resynthesis
from modallab.extraction.extract import responses_read
from modallab.extraction.preprocessing.bands import Band
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.requested.selected_modes import select_modes
from modallab.extraction.requested.selection import ModeSelection
from modallab.extraction.settings import NOTES
from modallab.jobs.extracting import as_measured, leakage_of
from modallab.jobs.settings import JOB
from modallab.rig.measurement import Measurement

NOT_REFITTED = (
    "residuals and resynthesis errors are those before the selection: there are too many FRFs and lines"
)


def selected_model(
    model: ModalModel, selection: ModeSelection, measurement: Measurement | None
) -> ModalModel:
    """Return the modal model without dropped modes, and with one mode in place of those that are merged.

    With the measurement, residuals and misfit are those of the remaining modes. A measurement of more values
    than `JOB.refitted_values` takes too long to answer a request with: both stay, and a note says so.

    Parameters
    ----------
    model
        Modal model.
    selection
        What is dropped and merged.
    measurement
        Measurement that the modes were extracted from; None if there is none.

    Raises
    ------
    InvalidInputError
        If the model lacks a mode, or no mode is left.
    """
    selected = select_modes(model, selection)
    if measurement is None or model.modal_constant is None or not model.ranges:
        return selected
    if measurement.frf.values.size > JOB.refitted_values:
        return replace(selected, notes=(*selected.notes, NOT_REFITTED))
    leakage, setup = leakage_of(measurement.setup), measurement.setup
    measurement = measurement.at(line_mask(measurement.frf.freq, exclude=model.exclude))
    responses, _ = responses_read(
        measurement.frf,
        measurement.coherence,
        measurement.averages,
        leakage=leakage,
        estimator=setup.analyser.estimator,
    )
    notes = tuple(note for note in selected.notes if not note.startswith(MISFIT_NOTE))
    compared = with_resynthesis(
        as_measured(replace(selected, notes=()), setup),
        responses,
        _bands(model, responses),
        smeared=0 if leakage is None else NOTES.smeared_lines,
        out_of_band_poles=model.out_of_band_eigenvalue,
    )
    return replace(
        selected,
        residuals=compared.residuals,
        out_of_band_constant=compared.out_of_band_constant,
        resynthesis_error=compared.resynthesis_error,
        notes=(*notes, *(note for note in compared.notes if note.startswith(MISFIT_NOTE))),
    )


def _bands(model: ModalModel, responses: Responses) -> list[Band]:
    """Return the lines of the extracted ranges."""
    ends = [np.searchsorted(responses.freq, limits, side="right").tolist() for limits in model.ranges]
    starts = [int(np.searchsorted(responses.freq, lower)) for lower, _ in model.ranges]
    return [Band(start, end - 1, start) for start, (_, end) in zip(starts, ends, strict=True)]
