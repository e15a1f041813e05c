"""Modes 0.1 to 1.9 lines wide, driven by random noise and seen through a Hann window."""

import numpy as np
import pytest

from modallab.extraction.single_mode.method import EXTRACTION_METHODS
from tests.service.extraction.conftest import Beam
from tests.service.extraction.leaked_beam import DRAWN, FAR, NARROW, WIDE, judged, of, read, taken

EXACT = [kind for kind in sorted(EXTRACTION_METHODS) if EXTRACTION_METHODS[kind].exact]


@pytest.mark.parametrize("method", EXACT)
@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_modes_beyond_their_stated_errors_are_flagged(estimator: str, method: str, plain_beam: Beam) -> None:
    off, flagged = judged(estimator, method, of(plain_beam))
    # 48 modes and two numbers each: chance alone puts one beyond 3 in four lots, beyond 3.5 in 22
    assert not ((off > 3.5) & ~flagged).any()


@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_modes_that_the_lines_tell_are_not_flagged(estimator: str, plain_beam: Beam) -> None:
    off, flagged = judged(estimator, "dobson", of(plain_beam))
    assert not flagged[:, WIDE].any()
    assert np.isfinite(off[:, WIDE]).all()


@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_narrow_modes_may_be_biased_as_far_as_by_chance_and_are_flagged_where_further(
    estimator: str, plain_beam: Beam
) -> None:
    # what the non-linear correction makes of random errors is no smaller in the mean over eleven FRFs
    shares = []
    for measurement in taken(estimator)[:DRAWN]:
        model = read(measurement, estimator, "dobson")
        for frequency in plain_beam.frequencies[NARROW, 0]:
            mode = min(model.modes, key=lambda mode: abs(mode.frequency - frequency))
            if abs(mode.frequency - frequency) < FAR:
                share = max(mode.leakage_bias[name] / error for name, error in mode.standard_errors.items())
                flagged = any(flag.startswith("leakage_bias: ") for flag in mode.flags)
                assert flagged == (share > 1)
                shares.append(share)
    assert len(shares) > DRAWN
    assert np.median(shares) > 0.7


def test_lines_that_hardly_tell_a_mode_make_its_errors_wide(plain_beam: Beam) -> None:
    # 0.1 line wide, errors of all responses in common as they were recorded together
    model = read(taken("h2")[-1], "h2", "dobson")
    mode = min(model.modes, key=lambda mode: abs(mode.frequency - plain_beam.frequencies[0, 0]))
    assert mode.standard_errors["loss_factor"] > 0.2 * mode.loss_factor
