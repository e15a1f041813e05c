"""Channels with what the residuals of nonlinear forces hold against the motion."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.rig.channel_response import ChannelResponse


def with_equivalent_feedback(
    driven: ChannelResponse, distorted: ChannelResponse, line: ComplexArray
) -> tuple[ChannelResponse, ChannelResponse]:
    """Return what channels show per source and per residual with more lines at the nonlinear forces.

    A line may differ from frequency to frequency, as no spring or damper of a structure does: what moves
    at the forces is x = (I + beta Z)^-1 x_0, and every channel loses what -Z x does to it.

    Parameters
    ----------
    driven, distorted
        `chain.answers(freq)`.
    line
        (n_run, n_freq, r) N/m.
    """
    beta = distorted.moved
    closed = np.eye(beta.shape[-1]) + beta * line[..., None, :]
    return _less(driven, distorted, closed, line), _less(distorted, distorted, closed, line)


def _less(
    one: ChannelResponse, per_force: ChannelResponse, closed: ComplexArray, line: ComplexArray
) -> ChannelResponse:
    single = closed.shape[-1] == 1  # one division instead of a solver call for every line
    moved = one.moved / closed if single else np.linalg.solve(closed, one.moved)
    held = line[..., None] * moved
    return replace(
        one,
        force=one.force - per_force.force @ held,
        response=one.response - per_force.response @ held,
        moved=np.asarray(moved),
    )
