"""Noise of the force told from what a window smears over neighbouring lines."""

import numpy as np
import pytest

from modallab.estimation.windows import WINDOWS
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.extraction.preprocessing.noise_bias import leaked_force_noise
from modallab.extraction.preprocessing.responses import responses_of
from tests.service.extraction.leaked_beam import taken

NOISE = 1e-2  # of the force's power, in `taken`


def told(window: str, **loaded: float) -> float:
    levels = []
    for measurement in taken("h1"):
        responses = responses_of(measurement.frf, measurement.coherence, measurement.averages)
        leakage = WindowLeakage.from_window(WINDOWS[window].samples(1024), "h1", **loaded)
        shares = leaked_force_noise(responses, leakage)
        assert np.ptp(shares.force) == 0
        assert not shares.response.any()
        levels.append(shares.force[0])
    return float(np.mean(levels))


def test_noise_of_a_white_force_is_told_on_the_flanks() -> None:
    # curvature of the flanks, which is left, is 2 to 6 % of it
    assert told("hann") == pytest.approx(NOISE, rel=0.1)


def test_no_noise_is_told_of_a_force_that_an_armature_loads() -> None:
    assert told("hann", source_mass=0.1) == 0


def test_a_window_that_jumps_smears_too_far_to_tell() -> None:
    assert told("rectangular") == 0
