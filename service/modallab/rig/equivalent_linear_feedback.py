"""Feedback of the residuals of nonlinear forces, as equivalent dynamic stiffness."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.rig.channel_response import ChannelResponse


def with_equivalent_feedback(
    driven: ChannelResponse, distorted: ChannelResponse, feedback: ComplexArray
) -> tuple[ChannelResponse, ChannelResponse]:
    """Return the responses to sources and residuals with the feedback loops closed.

    A line may differ from frequency to frequency, as no spring or damper of a structure does: what moves
    at the forces is x = (I + beta Z)^-1 x_0, and every channel loses what -Z x does to it.

    Parameters
    ----------
    driven, distorted
        `chain.answers(freq)`.
    feedback
        (n_run, n_freq, r) N/m.
    """
    beta = distorted.local_displacement
    loop_matrix = np.eye(beta.shape[-1]) + beta * feedback[..., None, :]
    return _closed_loop(driven, distorted, loop_matrix, feedback), _closed_loop(
        distorted, distorted, loop_matrix, feedback
    )


def _closed_loop(
    open_response: ChannelResponse,
    per_force: ChannelResponse,
    loop_matrix: ComplexArray,
    feedback: ComplexArray,
) -> ChannelResponse:
    single = loop_matrix.shape[-1] == 1  # one division instead of a solver call for every line
    displacement = (
        open_response.local_displacement / loop_matrix
        if single
        else np.linalg.solve(loop_matrix, open_response.local_displacement)
    )
    feedback_force = feedback[..., None] * displacement
    return replace(
        open_response,
        force=open_response.force - per_force.force @ feedback_force,
        response=open_response.response - per_force.response @ feedback_force,
        local_displacement=np.asarray(displacement),
    )
