"""Local nonlinear forces as springs and dampers of the size that the motion itself gives them."""

from collections.abc import Sequence

import numpy as np
import scipy.fft

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.rig.local_force import Linearised, LocalForce

SETTLED = 1e-9  # relative change of every root mean square at which the equivalents are found
ROUNDS = 200
FINER = 4  # samples of an autocorrelation per one of a signal over the band: room for third harmonics


def equivalents(
    forces: Sequence[LocalForce],
    driven: ComplexArray,
    fed_back: ComplexArray,
    omega: FloatArray,
    power: FloatArray,
) -> tuple[Linearised, ...]:
    """Return the forces under the motion that they themselves allow.

    Fixed point of rms -> equivalent spring or damper -> rms, halfway from step to step: stiffening and
    damping laws then settle without overshoot.

    Parameters
    ----------
    driven
        (n, r, n_in) displacement at each force per unit of each source, without the forces, m/N.
    fed_back
        (n, r, r) displacement per force put on the structure there, sources passive, m/N.
    omega
        (n,) rad/s.
    power
        (n,) mean square of every source's force that each frequency stands for, N^2.
    """
    rms = np.sqrt(_mean_squares(forces, driven, omega, power))
    for _ in range(ROUNDS):
        found = [force.at(float(value)) for force, value in zip(forces, rms, strict=True)]
        moved = _moved(_closed(found, fed_back, omega), driven)
        after = np.sqrt(_mean_squares(forces, moved, omega, power))
        if (np.abs(after - rms) <= SETTLED * rms).all():
            break
        rms = np.sqrt(rms * after)
    return tuple(force.at(float(value)) for force, value in zip(forces, rms, strict=True))


def _moved(closed: ComplexArray, driven: ComplexArray) -> ComplexArray:
    """Return the motion with the equivalents at work, (n, r, n_in)."""
    if closed.shape[-1] == 1:  # one division instead of a solver call for every frequency
        return np.asarray(driven / closed)
    return np.asarray(np.linalg.solve(closed, driven), complex)


def dynamic_stiffness(found: Sequence[Linearised], omega: FloatArray) -> ComplexArray:
    """Return k or i omega c of each equivalent, (n, r) N/m."""
    of_velocity = np.array([one.force.of_velocity for one in found])
    slopes = np.array([one.slope for one in found])
    return np.asarray(np.where(of_velocity, 1j * omega[:, None], 1.0) * slopes)


def _closed(found: Sequence[Linearised], fed_back: ComplexArray, omega: FloatArray) -> ComplexArray:
    """Return I + beta Z, (n, r, r)."""
    return np.asarray(np.eye(len(found)) + fed_back * dynamic_stiffness(found, omega)[:, None, :])


def _mean_squares(
    forces: Sequence[LocalForce], moved: ComplexArray, omega: FloatArray, power: FloatArray
) -> FloatArray:
    """Return the mean square of what each force takes: displacement or velocity."""
    size = (np.abs(moved) ** 2).sum(axis=2)
    scale = np.where([force.of_velocity for force in forces], omega[:, None] ** 2, 1.0)
    return np.asarray(power @ (size * scale))


def residual_density(one: Linearised, spectrum: FloatArray, spacing: float) -> FloatArray:
    """Return the one-sided density of a force's residual at the lines of a spectrum, (n_lines,) N^2/Hz.

    Parameters
    ----------
    spectrum
        (n_lines,) one-sided density from 0 Hz on of what the force takes.
    spacing
        Of the lines, Hz.
    """
    n = int(scipy.fft.next_fast_len(2 * FINER * (len(spectrum) - 1), real=True))
    two_sided = np.where(np.arange(len(spectrum)) == 0, 1.0, 0.5) * spectrum
    correlation = scipy.fft.irfft(two_sided, n) * n * spacing
    left = one.residual_correlation(np.clip(correlation / correlation[0], -1.0, 1.0))
    return np.asarray(2 * scipy.fft.rfft(left).real[: len(spectrum)] / (n * spacing)).clip(min=0.0)
