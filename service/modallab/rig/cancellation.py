"""Mass cancellation: the analyser takes the inertia of a mass at the drive point out of the force."""

from modallab.core.arrays import ComplexArray
from modallab.rig.setup import AcquisitionRun


def with_mass_cancelled(
    force: ComplexArray, response: ComplexArray, acquisition_run: AcquisitionRun, mass: float
) -> ComplexArray:
    """Return F - m a, with a the acceleration at the drive point, if the same run measures it.

    Exact for a mass that moves along the gauge's axis with an accelerometer that reads right; what it
    does across the axis, or turning, stays in the FRF (1992 thesis, section 5.4.5). A run that does not
    hear its drive point keeps its force: a roving accelerometer is cancelled in its first run at most.

    Parameters
    ----------
    force, response
        (n_freq, n_in, n_sources) and (n_freq, n_out, n_sources) as the channels show them.
    mass
        kg.
    """
    if mass == 0:
        return force
    force = force.copy()
    channel_by_point = {dof.point: (j, dof.sign) for j, dof in enumerate(acquisition_run.outputs)}
    for i, drive in enumerate(acquisition_run.drives):
        if drive.point in channel_by_point:
            j, sign = channel_by_point[drive.point]
            force[:, i] -= mass * drive.sign * sign * response[:, j]
    return force
