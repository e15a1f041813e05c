"""Do stated probabilities hold? Reliability, Brier score, and the same after recalibration."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import isotonic_regression

from modallab.core.arrays import FloatArray

BINS = 0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.99, 1.0
FOLDS = 5
SURE = 0.95
WITHIN = 1.96  # standard errors: 95 %


def stated(lines: Sequence[dict[str, Any]]) -> tuple[FloatArray, FloatArray]:
    """Return the probabilities (n,) of named effects, and 1 for each that is true."""
    steps = [step for line in lines for step in line["steps"]]
    return (
        np.array([step["probability"] for step in steps], float),
        np.array([float(step["true"]) for step in steps], float),
    )


def recalibrated(probability: FloatArray, true: FloatArray) -> FloatArray:
    """Return the probabilities (n,) by an isotonic fit to the other folds."""
    result = np.empty_like(probability)
    fold = np.random.default_rng(0).permutation(len(true)) % FOLDS
    for i in range(FOLDS):
        others = np.argsort(np.where(fold != i, probability, np.inf), kind="stable")[: (fold != i).sum()]
        shares = isotonic_regression(true[others]).x
        result[fold == i] = np.interp(probability[fold == i], probability[others], shares)
    return result


def calibration(lines: Sequence[dict[str, Any]]) -> list[str]:
    """Return the reliability table and scores as lines of text; none without named effects."""
    probability, true = stated(lines)
    if len(true) <= FOLDS:
        return []
    told = [f"{len(true)} named effects; stated probability, number, share that is true"]
    for low, high in pairwise(BINS):
        chosen = (probability >= low) & ((probability < high) | (high == 1.0))
        if chosen.any():
            told.append(f"  {low:.2f} to {high:.2f}: {chosen.sum():4d}, {true[chosen].mean():.0%}")
    sure = probability >= SURE
    if sure.any():
        told.append(f"  {SURE} or more: {sure.sum()}, {true[sure].mean():.1%} true")
    brier = float(((probability - true) ** 2).mean())
    best = float(((recalibrated(probability, true) - true) ** 2).mean())
    told.append(f"Brier score {brier:.3f}, recalibrated with {FOLDS} folds {best:.3f}")
    errors = [
        abs(error[2])
        for line in lines
        for step in line["steps"]
        for error in step.get("errors", {}).values()
        if step["true"]
    ]
    if errors:
        held = np.mean([error < WITHIN for error in errors])
        told.append(f"95 % intervals hold {held:.1%} of {len(errors)} parameters")
    return told
