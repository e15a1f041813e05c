"""Which FRFs no fit may see, so that a prediction of them can judge it."""

from collections.abc import Collection, Sequence

import numpy as np

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.predicting.predictor import Predictor
from modallab.diagnosis.residuals.observed import Observed, observe
from modallab.diagnosis.residuals.residual import Residual
from modallab.fe.structure import Structure
from modallab.rig.measurement import Measurement

FEW = 4  # FRFs below which lines are held out instead of FRFs
STANDS_OUT = 3.0  # times the median gap of a test's channels: something is wrong with this one alone


def select_held_out(
    structure: Structure,
    measurement: Measurement,
    fraction: float,
    named: Sequence[Dof],
    seed: int,
    *,
    spared: Collection[Dof] = (),
) -> tuple[list[Dof], tuple[Dof, ...]]:
    """Return the measured responses to hold out, and the unmeasured ones to predict.

    Parameters
    ----------
    fraction
        Share of the FRFs, 0 to 0.5.
    named
        Responses that are held out in any case, or predicted if they were not measured.
    seed
        Draws the others. The drive point is not drawn, it alone ties the FRFs to the force; nor is a
        channel that disagrees far more than the rest: what is wrong with one channel only that one can tell.
    spared
        Channels that are not drawn either.

    Raises
    ------
    InvalidInputError
        If the fraction is out of bounds.
    UnknownDofError
        If the model lacks a response that is named.
    """
    if not 0 <= fraction <= 0.5:
        raise InvalidInputError(
            "at most half of the FRFs can be held out",
            field="hold_out.fraction",
            value=fraction,
            allowed="0 to 0.5",
        )
    outputs = {dof.point: dof for dof in measurement.frf.outputs}
    for dof in named:
        structure.index(dof)
    held = [outputs[dof.point] for dof in named if dof.point in outputs]
    unmeasured = tuple(dof for dof in named if dof.point not in outputs)
    wanted = int(fraction * len(outputs)) - len(held)
    if len(outputs) >= FEW and wanted > 0:
        observed = observe(measurement, (), fraction=0.0)
        left = Predictor(structure, measurement.setup, observed).residual(())
        alone = {dof.point for dof in (*outlying_responses(observed, left), *spared)}
        free = [d for d in outputs.values() if d not in held and d.point != measurement.setup.drive.point]
        free = [d for d in free if d.point not in alone] or free
        drawn = np.random.default_rng(seed).choice(len(free), size=min(wanted, len(free)), replace=False)
        held += [free[i] for i in sorted(drawn)]
    return held, unmeasured


def outlying_responses(observed: Observed, left: Residual) -> tuple[Dof, ...]:
    """Return the responses that disagree with a prediction far more than the others do."""
    parts = [part for name, part in left.rescaled.items() if name != "force"]
    squares = [(np.abs(part) ** 2 * observed.usable).sum(axis=0) for part in parts]
    gaps = np.mean(squares, axis=0) / np.maximum(observed.usable.sum(axis=0), 1)
    alone = gaps > STANDS_OUT * max(float(np.median(gaps)), 1.0)
    return tuple(dof for dof, far in zip(observed.outputs, alone, strict=True) if far)
