"""A word of warning where modes rest on lines of low coherence."""

from collections.abc import Iterator

import numpy as np

from modallab.core.modal_model import ModalModel
from modallab.extraction.preprocessing.responses import Responses

LOW = 0.3  # of the response's power due to the force; below, H1 and H2 are a factor of three apart


def low_coherence_notes(model: ModalModel, responses: Responses) -> Iterator[str]:
    """Yield a note on every mode near which the middle one of the FRFs has a coherence below `LOW`.

    Parameters
    ----------
    model
        What was found; near a mode is half a bandwidth, or the line nearest to it.
    responses
        What it was found in.
    """
    for number, mode in enumerate(model.modes, 1):
        away = np.abs(responses.freq - mode.frequency)
        near = away <= max(mode.loss_factor * mode.frequency / 2, float(away.min()))
        coherence = float(np.median(responses.coherence[near]))
        if coherence < LOW:
            yield (
                f"mode {number}, {mode.frequency:.5g} Hz, rests on a coherence of {coherence:.2g}, less than"
                f" {LOW}: its standard errors hold if there were {responses.averages:g} averages"
            )
