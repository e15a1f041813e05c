"""Feedback of the residuals of nonlinear forces, as equivalent dynamic stiffness."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.rig.channel_response import ChannelResponse


def with_equivalent_feedback(
    driven: ChannelResponse, distorted: ChannelResponse, feedback: ComplexArray
) -> tuple[ChannelResponse, ChannelResponse]:
    """Return the responses to sources and residuals with the feedback loops closed.

    The feedback Z is a dynamic stiffness that may change from line to line in any way, unlike that of a
    spring or a damper. Without feedback the displacement at the nonlinear forces is x_0; with the receptance
    beta there it becomes x = (I + beta Z)^-1 x_0. The force -Z x then acts on every channel.

    Parameters
    ----------
    driven, distorted
        Responses of `chain.answers(freq)`: to the sources, and to unit forces at the nonlinear elements.
    feedback
        Z, (n_run, n_freq, r) N/m, one value for each nonlinear force.
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
