"""Calibration: what is stated as it is keeps its score, what is not is recalibrated."""

from typing import Any

import numpy as np

from benchmarks.trial.calibration import calibration, recalibrated, stated


def lines(probability: Any, true: Any) -> list[dict[str, Any]]:
    steps = [{"probability": float(p), "true": bool(t)} for p, t in zip(probability, true, strict=True)]
    return [{"steps": steps}]


def test_probabilities_that_are_twice_too_high_are_halved_by_the_other_folds() -> None:
    rng = np.random.default_rng(0)
    probability = rng.uniform(0, 1, 2000)
    true = (rng.uniform(0, 1, 2000) < probability / 2).astype(float)
    corrected = recalibrated(probability, true)
    # 1,600 draws in each fit: monotonic means are off by 0.1 at most, and by 0.04 on average.
    assert np.abs(corrected - probability / 2).mean() < 0.04
    assert ((corrected - true) ** 2).mean() < ((probability - true) ** 2).mean()


def test_report_counts_what_is_named_and_true() -> None:
    given = lines([0.99] * 9 + [0.5] * 4, [1] * 8 + [0] + [1, 0, 1, 0])
    assert stated(given)[0].shape == (13,)
    told = "\n".join(calibration(given))
    assert "13 named effects" in told
    assert "0.95 or more: 9, 88.9% true" in told
    assert calibration([]) == []
