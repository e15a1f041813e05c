"""Local nonlinear forces as springs and dampers of the size that the motion itself gives them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.fft

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.rig.local_force import Linearised, LocalForce

SETTLED = 1e-10  # relative change of a root mean square at which it is found
ROUNDS = 100
LOOKED_AT = np.geomspace(0.01, 8.0, 28)  # shares of the motion without the force, from the least up
FARTHER = np.geomspace(1e2, 1.0, 9)[:-1]  # times below and above, where that is not enough
REACH = 0.5  # of a logarithm, from where a motion is looked for nearby
FINER = 4  # samples of an autocorrelation per one of a signal over the band: room for third harmonics


def equivalents(
    forces: Sequence[LocalForce],
    driven: ComplexArray,
    fed_back: ComplexArray,
    omega: FloatArray,
    power: FloatArray,
    near: FloatArray | None = None,
) -> FloatArray:
    """Return the root mean squares of what forces take under the motion that they themselves allow.

    With several forces each is settled in turn beside the others, until none moves any more. Where a
    resonance passes lines of a periodic test several motions may agree with their own force: the least
    is found, which is where a test arrives whose level is turned up.

    Parameters
    ----------
    driven
        (n_run, n, r, n_in) displacement at each force per unit of each source, without the forces, m/N.
    fed_back
        (n_run, n, r, r) displacement per force put on the structure there, sources passive, m/N.
    omega
        (n,) rad/s.
    power
        (n,) mean square of every source's force that each frequency stands for, N^2.
    near
        (n_run, r) where to begin, and not to go far from in one call: for frequencies that are fine
        where the resonances of such motions are and nowhere else. None finds the least motion.

    Returns
    -------
    (n_run, r) m or m/s
    """
    unit = np.where([force.of_velocity for force in forces], 1j * omega[:, None], 1.0)
    driven, fed_back = driven * unit[..., None], fed_back * unit[..., None]
    if len(forces) == 1:
        return _settled(forces[0], _motion(driven, fed_back, power), near)
    rms = np.zeros((len(driven), len(forces))) if near is None else near.copy()
    for _ in range(ROUNDS):
        before = rms.copy()
        for i, force in enumerate(forces):
            beside = _beside(forces, rms, driven, fed_back, i)
            about = None if near is None else rms[:, i : i + 1]
            rms[:, i : i + 1] = _settled(force, _motion(*beside, power), about)
        if (np.abs(rms - before) <= SETTLED * rms).all():
            break
    return rms


def _beside(
    forces: Sequence[LocalForce], rms: FloatArray, driven: ComplexArray, fed_back: ComplexArray, i: int
) -> tuple[ComplexArray, ComplexArray]:
    """Return what one force takes per source and per force of its own, the others at work."""
    others = [j for j in range(len(forces)) if j != i]
    z = _lines([forces[j] for j in others], rms[:, others])[:, None, :]
    closed = np.eye(len(others)) + fed_back[:, :, others][..., others] * z[:, :, None]
    right = np.concatenate([driven[:, :, others], fed_back[:, :, others, i : i + 1]], axis=3)
    held = (fed_back[:, :, i : i + 1, others] * z[:, :, None]) @ np.linalg.solve(closed, right)
    n_in = driven.shape[3]
    return driven[:, :, i : i + 1] - held[..., :n_in], fed_back[:, :, i : i + 1, i : i + 1] - held[..., n_in:]


class _Motion:
    """The mean square of one motion with a spring or a damper k at work: sum of a / (1 + b k + c k^2)."""

    def __init__(self, a: FloatArray, b: FloatArray, c: FloatArray) -> None:
        self._a, self._b, self._c = a, b, c  # (n_run, n) each

    @property
    def n_run(self) -> int:
        """How many runs there are."""
        return len(self._a)

    def of(self, runs: BoolArray) -> "_Motion":
        """Return the same of some runs."""
        return _Motion(self._a[runs], self._b[runs], self._c[runs])

    def rms(self, k: FloatArray) -> FloatArray:
        """Return the root mean squares (n_run,) with k (n_run,)."""
        return np.asarray(np.sqrt((self._a / self._resisted(k)).sum(axis=1)))

    def slope(self, k: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the root mean squares, and how their logarithm changes with k."""
        resisted = self._resisted(k)
        part = self._a / resisted
        total = part.sum(axis=1)
        change = (part * (self._b + 2 * self._c * k[:, None]) / resisted).sum(axis=1)
        return np.sqrt(total), -change / (2 * total)

    def _resisted(self, k: FloatArray) -> FloatArray:
        out = self._c * k[:, None]
        out += self._b
        out *= k[:, None]
        out += 1.0
        return out


def _motion(driven: ComplexArray, fed_back: ComplexArray, power: FloatArray) -> _Motion:
    own = fed_back[:, :, 0, 0]
    size = driven.real**2 + driven.imag**2
    return _Motion(power * size[:, :, 0].sum(axis=2), 2 * own.real, own.real**2 + own.imag**2)


def _settled(force: LocalForce, motion: _Motion, near: FloatArray | None) -> FloatArray:
    """Return the least root mean square (n_run, 1) that a force allows under its own straight line.

    The first change of sign of ln(allowed/supposed) from small motions up, then Newton's method
    between its ends; or within `REACH` of a motion near it.
    """
    free = motion.rms(np.zeros(motion.n_run))
    if not (moving := free > 0).all():
        found = np.zeros((motion.n_run, 1))
        if moving.any():
            found[moving] = _settled(force, motion.of(moving), None if near is None else near[moving])
        return found
    if near is None:
        low, high = _bracket(force, motion, free)
        at = (low + high) / 2
    else:
        at = np.log(near[:, 0])
        low, high = at - REACH, at + REACH
    for _ in range(ROUNDS):
        rms = np.exp(at)
        k, change = force.lines(rms)
        allowed, falls = motion.slope(k)
        off = np.log(allowed) - at
        low, high = np.where(off > 0, at, low), np.where(off > 0, high, at)
        step = off / (1 - falls * change)
        new = at + step
        inside = (new >= low) & (new <= high)
        at, before = np.where(inside, new, (low + high) / 2), at
        if (np.abs(at - before) <= SETTLED).all():
            break
    return np.asarray(np.exp(at))[:, None]


def _bracket(force: LocalForce, motion: _Motion, free: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return logarithms of motions, the force allowing more than the first and less than the second."""
    looked = LOOKED_AT * free.max()
    while True:
        lines = force.lines(looked)[0]
        allowed = np.array([motion.rms(np.full(motion.n_run, line)) for line in lines])
        less = allowed <= looked[:, None]
        if less[0].any():
            looked = np.concatenate([looked[0] / FARTHER, looked])
        elif not less[-1].all():
            looked = np.concatenate([looked, looked[-1] * FARTHER[::-1]])
        else:
            break
    first = less.argmax(axis=0)
    return np.log(looked[first - 1]), np.log(looked[first])


def at_work(
    forces: Sequence[LocalForce],
    rms: FloatArray,
    driven: ComplexArray,
    fed_back: ComplexArray,
    omega: FloatArray,
) -> tuple[ComplexArray, ComplexArray]:
    """Return displacements per unit of each source and per force, with the straight lines at work, m/N.

    Parameters
    ----------
    rms
        (n_run, r), of `equivalents`, as the rest is.

    Returns
    -------
    (n_run, n, r, n_in) and (n_run, n, r, r)
    """
    unit = np.where([force.of_velocity for force in forces], 1j * omega[:, None], 1.0)
    z = _lines(forces, rms)[:, None, :] * unit
    if len(forces) == 1:
        closed = 1 + fed_back * z[..., None]
        return driven / closed, fed_back / closed
    closed = np.eye(len(forces)) + fed_back * z[:, :, None, :]
    return np.asarray(np.linalg.solve(closed, driven)), np.asarray(np.linalg.solve(closed, fed_back))


def _lines(forces: Sequence[LocalForce], rms: FloatArray) -> FloatArray:
    """Return the straight lines, (n_run, r) N/m or N s/m; 0 of a force that does not move."""
    each = [
        np.where(own > 0, force.lines(np.maximum(own, np.finfo(float).tiny))[0], 0.0)
        for force, own in zip(forces, rms.T, strict=True)
    ]
    return np.stack(each, axis=1)


@dataclass(frozen=True, eq=False)
class Taken:
    """What nonlinear forces take on evenly spaced lines from 0 Hz, and how the structure answers them."""

    spectrum: FloatArray  # (n_lines, r) one-sided densities of displacement or velocity
    answer: ComplexArray  # (n_lines, r) of the same per force put on the structure, straight lines at work


def left_over(
    one: Linearised, spectrum: FloatArray, answer: ComplexArray, spacing: float
) -> tuple[FloatArray, ComplexArray]:
    """Return the density of a force's residual, N^2/Hz, and what it holds against the motion itself.

    The residual moves the structure, and so the next residual. To second order in the force that is a
    force again in line with the motion: minus the transform of C'(R) g, with C the residual's
    autocorrelation, R the motion's and g the structure's answer to an impulse. It damps resonances where
    the residual feeds on them, so that they do not gain more than sources give; for a cubic
    18 k_3^2 R^2 g. Kraichnan (1961), J. Math. Phys. 2, 124-148 (direct interaction).

    Parameters
    ----------
    spectrum, answer
        (n_lines,) of a `Taken`.
    spacing
        Of the lines, Hz.

    Returns
    -------
    (n_lines,) each; the second in force per displacement or velocity, whichever the force takes.
    """
    n_lines = len(spectrum)
    n = int(scipy.fft.next_fast_len(FINER * (n_lines - 1), real=True))
    two_sided = np.zeros(n + 1)
    two_sided[:n_lines] = spectrum / 2
    two_sided[0] = spectrum[0]
    # Both are even: half of each says it all.
    motion = scipy.fft.dct(two_sided, type=1)
    correlation = np.clip(motion / motion[0], -1.0, 1.0) if motion[0] > 0 else motion
    density = scipy.fft.dct(one.residual_correlation(correlation), type=1)[:n_lines] / (n * spacing)
    memory = one.residual_memory(correlation)
    impulse = scipy.fft.irfft(answer, 2 * n)
    impulse[: n + 1] *= memory
    impulse[n + 1 :] *= memory[-2:0:-1]
    return density.clip(min=0.0), -scipy.fft.rfft(impulse)[:n_lines]
