"""Modes 0.1 to 1.9 lines wide, driven by random noise and seen through a Hann window."""

import numpy as np
import pytest

from modallab.extraction.singly.method import EXTRACTION_METHODS, TRAITS
from tests.service.extraction.conftest import Beam
from tests.service.extraction.leaked_beam import DRAWN, NARROW, WIDE, judged, of, read, taken

EXACT = [kind for kind in sorted(EXTRACTION_METHODS) if TRAITS[kind].exact]


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


def test_drawn_lines_of_many_frfs_leave_narrow_modes_biased_and_it_is_said(plain_beam: Beam) -> None:
    # independent errors of eleven FRFs average out, and what the non-linear correction makes of them does not
    for estimator in ("h1", "h2"):
        off, flagged = judged(estimator, "dobson", of(plain_beam))
        seen = np.isfinite(off[:DRAWN, NARROW])
        assert (flagged[:DRAWN, NARROW] & seen).sum() > 0.6 * seen.sum()


def test_lines_that_hardly_tell_a_mode_make_its_errors_wide(plain_beam: Beam) -> None:
    # 0.1 line wide, errors of all responses in common as they were recorded together
    model = read(taken("h2")[-1], "h2", "dobson")
    mode = min(model.modes, key=lambda mode: abs(mode.frequency - plain_beam.frequencies[0, 0]))
    assert mode.standard_errors["loss_factor"] > 0.2 * mode.loss_factor
