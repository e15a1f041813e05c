"""Choice of the held-out FRFs: excluded from every fit, they test its prediction."""

from collections.abc import Collection, Sequence

import numpy as np

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.diagnosis.predicting.settings import HOLD_OUT
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observed import Observed, observe
from modallab.diagnosis.residuals.residual import Residual
from modallab.fe.structure import Structure
from modallab.rig.measurement import Measurement


def select_held_out(
    structure: Structure,
    measurement: Measurement,
    fraction: float,
    requested: Sequence[Dof],
    seed: int,
    *,
    spared: Collection[Dof] = (),
) -> tuple[list[Dof], tuple[Dof, ...]]:
    """Return the measured responses to hold out, and the unmeasured ones to predict.

    Parameters
    ----------
    fraction
        Share of the FRFs, 0 to 0.5.
    requested
        Responses that are held out in any case, or predicted if they were not measured.
    seed
        Seed of the random choice of the others. The drive point is never chosen, it alone relates the FRFs
        to the force; nor is an outlying channel: only its own FRF shows an error of one channel.
    spared
        Further channels that are not chosen.

    Raises
    ------
    InvalidInputError
        If the fraction is out of bounds.
    UnknownDofError
        If the model lacks a named response.
    """
    if not 0 <= fraction <= HOLD_OUT.max_fraction:
        raise InvalidInputError(
            "at most half of the FRFs can be held out",
            field="hold_out.fraction",
            value=fraction,
            allowed=bounds(0, HOLD_OUT.max_fraction),
        )
    outputs = {dof.point: dof for dof in measurement.frf.outputs}
    for dof in requested:
        structure.index(dof)
    held_out = [outputs[dof.point] for dof in requested if dof.point in outputs]
    unmeasured = tuple(dof for dof in requested if dof.point not in outputs)
    n_random = int(fraction * len(outputs)) - len(held_out)
    if len(outputs) >= HOLD_OUT.min_responses and n_random > 0:
        observed = observe(measurement, (), fraction=0.0)
        residual = SingleTestPredictor.of(structure, measurement.setup, observed).residual(())
        excluded = {dof.point for dof in (*outlying_responses(observed, residual), *spared)}
        drive = measurement.setup.drive.point
        free = [dof for dof in outputs.values() if dof not in held_out and dof.point != drive]
        free = [dof for dof in free if dof.point not in excluded] or free
        size = min(n_random, len(free))
        indices = np.random.default_rng(seed).choice(len(free), size=size, replace=False)
        held_out += [free[i] for i in sorted(indices)]
    return held_out, unmeasured


def outlying_responses(observed: Observed, residual: Residual) -> tuple[Dof, ...]:
    """Return the responses whose gap is far above the median gap of all responses."""
    parts = [part for name, part in residual.rescaled.items() if name != "force"]
    squares = [(np.abs(part) ** 2 * observed.usable).sum(axis=0) for part in parts]
    gaps = np.mean(squares, axis=0) / np.maximum(observed.usable.sum(axis=0), 1)
    outlying = gaps > HOLD_OUT.outlier_gap * max(float(np.median(gaps)), 1.0)
    return tuple(dof for dof, outlier in zip(observed.outputs, outlying, strict=True) if outlier)
