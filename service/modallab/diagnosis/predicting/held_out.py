"""Choice of the held-out FRFs: excluded from every fit, they test its prediction."""

from collections.abc import Collection, Sequence

import numpy as np

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.diagnosis.predicting.settings import HOLD_OUT
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.frf_selection import FrfSelection, frfs_at, single_frfs
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.residual import Residual
from modallab.fe.structure import Structure
from modallab.rig.frf_channel import frf_channels
from modallab.rig.measurement import Measurement


def select_held_out(
    structure: Structure,
    measurement: Measurement,
    fraction: float,
    requested: Sequence[Dof],
    seed: int,
    *,
    spared: Collection[FrfSelection] = (),
) -> tuple[list[FrfSelection], tuple[Dof, ...]]:
    """Return the measured FRFs to hold out, and the unmeasured responses to predict.

    Parameters
    ----------
    fraction
        Share of the FRFs, 0 to 0.5.
    requested
        Responses, or points that a roving hammer struck, whose FRFs are held out in any case; responses
        that were not measured are predicted.
    seed
        Seed of the random choice of the others. An FRF at a drive point is never chosen, it alone relates
        the FRFs to the force; nor is an outlying one: only its own FRF shows an error of one channel.
    spared
        Further FRFs that are not chosen.

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
    setup, channels = measurement.setup, frf_channels(measurement.setup)
    named = {dof: frfs_at(dof, setup) for dof in requested}
    for dof in requested:
        structure.index(dof)
    held_out = list(dict.fromkeys(frfs for frfs in named.values() if frfs is not None))
    unmeasured = tuple(dof for dof, frfs in named.items() if frfs is None)
    singles = list(dict.fromkeys(single_frfs(channels, roving_hammer=setup.roving_hammer)))
    selected = [[channel for channel in channels if single.selects(channel)] for single in singles]
    taken = [any(frfs.selects(frf) for frfs in held_out for frf in group) for group in selected]
    n_random = int(fraction * len(singles)) - sum(taken)
    if len(singles) >= HOLD_OUT.min_responses and n_random > 0:
        observed = observe(measurement, (), fraction=0.0)
        residual = SingleTestPredictor.of(structure, setup, observed).residual(())
        excluded = {*outlying_frfs(observed, residual, roving_hammer=setup.roving_hammer), *spared}
        free = [
            single
            for single, group, is_taken in zip(singles, selected, taken, strict=True)
            if not is_taken and not any(channel.at_drive_point for channel in group)
        ]
        free = [single for single in free if single not in excluded] or free
        size = min(n_random, len(free))
        indices = np.random.default_rng(seed).choice(len(free), size=size, replace=False)
        held_out += [free[i] for i in sorted(indices)]
    return held_out, unmeasured


def outlying_frfs(observed: Observed, residual: Residual, *, roving_hammer: bool) -> tuple[FrfSelection, ...]:
    """Return the FRFs whose gap is far above the median gap of all."""
    parts = [part for name, part in residual.rescaled.items() if name != "force"]
    squares = [(np.abs(part) ** 2 * observed.usable).sum(axis=0) for part in parts]
    gaps = np.mean(squares, axis=0) / np.maximum(observed.usable.sum(axis=0), 1)
    outlying = gaps > HOLD_OUT.outlier_gap * max(float(np.median(gaps)), 1.0)
    singles = single_frfs(observed.channels, roving_hammer=roving_hammer)
    return tuple(frf for frf, outlier in zip(singles, outlying, strict=True) if outlier)
