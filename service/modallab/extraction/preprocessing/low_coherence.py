"""Note on modes whose lines have a low coherence."""

from collections.abc import Iterator

import numpy as np

from modallab.core.modal_model import ModalModel
from modallab.extraction.preprocessing.responses import Responses
from modallab.extraction.preprocessing.settings import LOW_COHERENCE


def low_coherence_notes(model: ModalModel, responses: Responses) -> Iterator[str]:
    """Yield a note on every mode near which the median coherence over the FRFs is low.

    Parameters
    ----------
    model
        Identified modes; the lines near a mode are those within half a bandwidth, or the nearest one.
    responses
        FRFs that the modes were identified from.
    """
    for number, mode in enumerate(model.modes, 1):
        distance = np.abs(responses.freq - mode.frequency)
        near = distance <= max(mode.loss_factor * mode.frequency / 2, float(distance.min()))
        coherence = float(np.median(responses.coherence[near]))
        if coherence < LOW_COHERENCE.threshold:
            yield (
                f"mode {number}, {mode.frequency:.5g} Hz, has lines with a coherence of {coherence:.2g}, "
                f"less than {LOW_COHERENCE.threshold}: its standard errors are valid only for"
                f" {responses.averages:g} averages"
            )
