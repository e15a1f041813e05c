"""Responses to blows beside the drive point or off its axis."""

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import TRANSLATIONS, Dof
from modallab.fe.interpolation import point_motion
from modallab.fe.receptance import receptance
from modallab.fe.system import DynamicSystem
from modallab.rig.chain import Chain
from modallab.rig.run import filtered
from modallab.rig.settings import CHAIN, HAMMER


def lateral(system: DynamicSystem, drive: Dof) -> tuple[Dof, ...]:
    """Return the translations of a drive point's node across its axis."""
    directions = (Dof(drive.node, direction) for direction in TRANSLATIONS if direction != drive.direction)
    return tuple(dof for dof in directions if dof in system.dofs)


def misalignment_responses(single_run: Chain, freq: FloatArray) -> ComplexArray:
    """Return the channels' response to misaligned forces, (n_freq, 1 + n_out, 1 + n_lateral).

    First per newton and metre of place along the member, to first order, then per newton in each
    direction across the axis. The gauge sits in the hammer and shows the whole blow, wherever it goes.
    """
    run = single_run.runs[0]
    drive, spacing = run.acquisition_run.drive, single_run.setup.analyser.spacing
    columns = np.column_stack([_lever(run.system, drive), run.system.selection(lateral(run.system, drive))])
    omega = 2 * np.pi * np.maximum(freq, CHAIN.dc_line_fraction * spacing)
    alpha = receptance(run.system, omega / (2 * np.pi), run.system.selection(run.motions), columns)
    responses = filtered(run.channel_motions(-(omega**2)[:, None, None] * alpha), run.responses, omega)
    return np.concatenate([np.zeros((len(freq), 1, columns.shape[1])), responses], axis=1)


def _lever(system: DynamicSystem, drive: Dof) -> FloatArray:
    """Return the derivative (n_dof,) of the force vector by the blow's place along the member, 1/m."""
    column = np.zeros(len(system.dofs))
    table = system.members
    if table is None or drive.direction not in ("X", "Y") or not table.has_bar(drive.node):
        return column
    for sign in (1, -1):
        for row, weight in point_motion(table, drive.node, sign * HAMMER.slope_step, drive.direction):
            column[row] += sign * drive.sign * weight / (2 * HAMMER.slope_step)
    return column
