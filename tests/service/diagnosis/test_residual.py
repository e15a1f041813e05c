"""Residuals of leaking records: judged by how they scatter in truth."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.diagnosis.residual import Residual, scatters
from modallab.diagnosis.search import only_noise_left
from modallab.rig.measure import Route, measure
from tests.diagnosing import drawn, model, predicting, rig

SEEDS = 24


@pytest.mark.parametrize("window", ["rectangular", "hann"])
def test_with_nothing_missing_the_gap_of_leaking_records_is_one_within_its_scatter(window: str) -> None:
    setup = rig(kind="random", window=window)
    gaps, stated, plain = [], [], []
    for seed in range(SEEDS):
        measurement = measure(model(), setup, route=Route.SAMPLED, rng=np.random.default_rng(seed))
        predictor, observed = predicting(measurement)
        left = predictor.residual(())
        gaps.append(left.gaps(observed.usable)["response"])
        stated.append(scatters(observed, left, observed.usable)["response"])
        plain.append(replace(left, excess=None).gaps(observed.usable)["response"])
        assert only_noise_left(predictor, left)
    allowed = 4 * np.mean(stated) / np.sqrt(SEEDS)  # four standard errors of the mean
    assert abs(np.mean(gaps) - 1) < allowed
    # a standard deviation of 24 is known to 1/sqrt(48) = 14 %: three of these
    assert np.std(gaps) == pytest.approx(np.mean(stated), rel=0.43)
    if window == "rectangular":  # records that end where the next begin: without the factor it fails
        assert np.mean(plain) - 1 > 2 * allowed


def test_signals_that_repeat_with_the_record_need_no_factor() -> None:
    predictor, _ = predicting(drawn(rig()))
    left: Residual = predictor.residual(())
    assert left.excess is None
    assert left.judged["response"] is left.response
