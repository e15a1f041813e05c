"""Equivalent linearisation of local nonlinear forces under Gaussian motion."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.fft

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray
from modallab.rig.cell_averages import CellAverages
from modallab.rig.local_force import LinearisedForce, LocalForce
from modallab.rig.nonlinear_settings import LINEARISATION

_TRIAL_RATIOS = np.geomspace(*LINEARISATION.trial_range, LINEARISATION.n_trials)
_EXTENSION_RATIOS = np.geomspace(LINEARISATION.extension_range, 1.0, LINEARISATION.n_extension_trials + 1)[
    :-1
]


def equivalent_rms(
    forces: Sequence[LocalForce],
    driven: ComplexArray,
    fed_back: ComplexArray,
    omega: FloatArray,
    power: FloatArray,
    initial_rms: FloatArray | None = None,
) -> FloatArray:
    """Return the root mean square motions that are consistent with the equivalent stiffness or damping.

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
    initial_rms
        (n_run, r) where to begin, and not to go far from in one call: for frequencies that are fine
        where the resonances of such motions are and nowhere else. None finds the least motion.

    Returns
    -------
    (n_run, r) m or m/s
    """
    unit = np.where([force.of_velocity for force in forces], 1j * omega[:, None], 1.0)
    driven, fed_back = driven * unit[..., None], fed_back * unit[..., None]
    if len(forces) == 1:
        return _solve_rms(forces[0], _motion_model(driven, fed_back, power), initial_rms)
    rms = np.zeros((len(driven), len(forces))) if initial_rms is None else initial_rms.copy()
    for _ in range(LINEARISATION.max_rounds):
        previous_rms = rms.copy()
        for i, force in enumerate(forces):
            receptances = _with_other_loops_closed(forces, rms, driven, fed_back, i)
            initial = None if initial_rms is None else rms[:, i : i + 1]
            rms[:, i : i + 1] = _solve_rms(force, _motion_model(*receptances, power), initial)
        if (np.abs(rms - previous_rms) <= LINEARISATION.rms_tolerance * rms).all():
            break
    return rms


def _with_other_loops_closed(
    forces: Sequence[LocalForce], rms: FloatArray, driven: ComplexArray, fed_back: ComplexArray, i: int
) -> tuple[ComplexArray, ComplexArray]:
    """Return the receptances at one force, the other forces linearised."""
    other_forces = [j for j in range(len(forces)) if j != i]
    z = _equivalent_coefficients([forces[j] for j in other_forces], rms[:, other_forces])[:, None, :]
    loop_matrix = np.eye(len(other_forces)) + fed_back[:, :, other_forces][..., other_forces] * z[:, :, None]
    right_hand_side = np.concatenate(
        [driven[:, :, other_forces], fed_back[:, :, other_forces, i : i + 1]], axis=3
    )
    reaction_motion = (fed_back[:, :, i : i + 1, other_forces] * z[:, :, None]) @ np.linalg.solve(
        loop_matrix, right_hand_side
    )
    n_in = driven.shape[3]
    return driven[:, :, i : i + 1] - reaction_motion[..., :n_in], fed_back[
        :, :, i : i + 1, i : i + 1
    ] - reaction_motion[..., n_in:]


class _MeanSquareMotion:
    """Mean square motion against an added stiffness or damping k: sum of a / (1 + b k + c k^2)."""

    def __init__(self, a: FloatArray, b: FloatArray, c: FloatArray) -> None:
        self._a, self._b, self._c = a, b, c  # (n_run, n) each

    @property
    def n_run(self) -> int:
        """Number of runs."""
        return len(self._a)

    def of(self, runs: BoolArray) -> "_MeanSquareMotion":
        """Return the model of selected runs."""
        return _MeanSquareMotion(self._a[runs], self._b[runs], self._c[runs])

    def rms(self, k: FloatArray) -> FloatArray:
        """Return the root mean squares (n_run,) with k (n_run,)."""
        return np.asarray(np.sqrt((self._a / self._resisted(k)).sum(axis=1)))

    def slope(self, k: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the root mean squares, and the derivative of their logarithm by k."""
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


def _motion_model(driven: ComplexArray, fed_back: ComplexArray, power: FloatArray) -> _MeanSquareMotion:
    receptance = fed_back[:, :, 0, 0]
    size = driven.real**2 + driven.imag**2
    return _MeanSquareMotion(
        power * size[:, :, 0].sum(axis=2), 2 * receptance.real, receptance.real**2 + receptance.imag**2
    )


def _solve_rms(force: LocalForce, motion: _MeanSquareMotion, initial_rms: FloatArray | None) -> FloatArray:
    """Return the smallest self-consistent root mean square (n_run, 1) of one force.

    The first change of sign of ln(allowed/supposed) from small motions up, then Newton's method
    between its ends; or within `LINEARISATION.log_bracket` of a motion near it.
    """
    open_loop_rms = motion.rms(np.zeros(motion.n_run))
    if not (moving := open_loop_rms > 0).all():
        rms_of_runs = np.zeros((motion.n_run, 1))
        if moving.any():
            rms_of_runs[moving] = _solve_rms(
                force, motion.of(moving), None if initial_rms is None else initial_rms[moving]
            )
        return rms_of_runs
    if initial_rms is None:
        low, high = _bracket(force, motion, open_loop_rms)
        log_rms = (low + high) / 2
    else:
        log_rms = np.log(initial_rms[:, 0])
        low, high = log_rms - LINEARISATION.log_bracket, log_rms + LINEARISATION.log_bracket
    for _ in range(LINEARISATION.max_rounds):
        rms = np.exp(log_rms)
        k, coefficient_slope = force.equivalent_coefficients(rms)
        resulting_rms, log_slope = motion.slope(k)
        log_ratio = np.log(resulting_rms) - log_rms
        low, high = np.where(log_ratio > 0, log_rms, low), np.where(log_ratio > 0, high, log_rms)
        step = log_ratio / (1 - log_slope * coefficient_slope)
        newton_point = log_rms + step
        inside = (newton_point >= low) & (newton_point <= high)
        log_rms, previous = np.where(inside, newton_point, (low + high) / 2), log_rms
        if (np.abs(log_rms - previous) <= LINEARISATION.rms_tolerance).all():
            break
    return np.asarray(np.exp(log_rms))[:, None]


def _bracket(
    force: LocalForce, motion: _MeanSquareMotion, open_loop_rms: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return a bracket of the logarithm of the smallest self-consistent root mean square."""
    trial_rms = _TRIAL_RATIOS * open_loop_rms.max()
    while True:
        coefficients = force.equivalent_coefficients(trial_rms)[0]
        resulting_rms = np.array(
            [motion.rms(np.full(motion.n_run, coefficient)) for coefficient in coefficients]
        )
        is_smaller = resulting_rms <= trial_rms[:, None]
        if is_smaller[0].any():
            trial_rms = np.concatenate([trial_rms[0] / _EXTENSION_RATIOS, trial_rms])
        elif not is_smaller[-1].all():
            trial_rms = np.concatenate([trial_rms, trial_rms[-1] * _EXTENSION_RATIOS[::-1]])
        else:
            break
    first = is_smaller.argmax(axis=0)
    return np.log(trial_rms[first - 1]), np.log(trial_rms[first])


def closed_loop_receptances(
    forces: Sequence[LocalForce],
    rms: FloatArray,
    driven: ComplexArray,
    fed_back: ComplexArray,
    omega: FloatArray,
) -> tuple[ComplexArray, ComplexArray]:
    """Return receptances at the forces with the linearised forces attached, m/N.

    Parameters
    ----------
    rms
        (n_run, r), of `equivalent_rms`, as the rest is.

    Returns
    -------
    (n_run, n, r, n_in) and (n_run, n, r, r)
    """
    unit = np.where([force.of_velocity for force in forces], 1j * omega[:, None], 1.0)
    z = _equivalent_coefficients(forces, rms)[:, None, :] * unit
    if len(forces) == 1:
        loop_matrix = 1 + fed_back * z[..., None]
        return driven / loop_matrix, fed_back / loop_matrix
    loop_matrix = np.eye(len(forces)) + fed_back * z[:, :, None, :]
    return np.asarray(np.linalg.solve(loop_matrix, driven)), np.asarray(
        np.linalg.solve(loop_matrix, fed_back)
    )


def _equivalent_coefficients(forces: Sequence[LocalForce], rms: FloatArray) -> FloatArray:
    """Return the equivalent stiffness or damping, (n_run, r) N/m or N s/m; 0 without motion."""
    coefficients = [
        np.where(
            force_rms > 0, force.equivalent_coefficients(np.maximum(force_rms, np.finfo(float).tiny))[0], 0.0
        )
        for force, force_rms in zip(forces, rms.T, strict=True)
    ]
    return np.stack(coefficients, axis=1)


@dataclass(frozen=True, eq=False)
class LocalResponseSpectrum:
    """Motion at the nonlinear forces on a uniform grid from 0 Hz, and the receptance there."""

    spectrum: FloatArray  # (n_lines, r) one-sided densities of displacement or velocity
    receptance: (
        ComplexArray  # (n_lines, r) of the same per force on the structure, with equivalent linearisation
    )

    def averaged(self, averages: CellAverages, at_nodes: "LocalResponseSpectrum") -> "LocalResponseSpectrum":
        """Return the same with averages over cells in place of samples.

        Parameters
        ----------
        at_nodes
            The motion at 0 Hz and at the nodes of the averages.
        """
        spectrum, receptance = self.spectrum.copy(), self.receptance.copy()
        spectrum[averages.points] = averages.weights @ at_nodes.spectrum[1:]
        receptance[averages.points] = averages.weights @ at_nodes.receptance[1:]
        return LocalResponseSpectrum(spectrum, receptance)


def residual_spectrum(
    linearised_force: LinearisedForce, spectrum: FloatArray, receptance: ComplexArray, spacing: float
) -> tuple[FloatArray, ComplexArray]:
    """Return the spectral density of a force's residual, N^2/Hz, and its equivalent feedback.

    The residual force causes motion, and this motion changes the residual force. To second order in the
    force, the change is a feedback proportional to the motion: minus the Fourier transform of C'(R) g, with
    the autocorrelations C of the residual and R of the motion, and the impulse response g of the structure.
    The feedback damps the resonances that the residual excites, so that they gain no more energy than the
    sources supply. For a cubic spring C'(R) is 18 k_3^2 R^2. Kraichnan (1961), J. Math. Phys. 2, 124-148
    (direct interaction).

    Parameters
    ----------
    spectrum, receptance
        (n_lines,) of a `LocalResponseSpectrum`.
    spacing
        Of the lines, Hz.

    Returns
    -------
    (n_lines,) each; the second in force per displacement or velocity, whichever the force takes.
    """
    n_lines = len(spectrum)
    n = int(scipy.fft.next_fast_len(LINEARISATION.oversampling * (n_lines - 1), real=True))
    two_sided = np.zeros(n + 1)
    two_sided[:n_lines] = spectrum / 2
    two_sided[0] = spectrum[0]
    # Both are even: half of each says it all.
    motion = scipy.fft.dct(two_sided, type=1)
    correlation = np.clip(motion / motion[0], -1.0, 1.0) if motion[0] > 0 else motion
    density = scipy.fft.dct(linearised_force.residual_correlation(correlation), type=1)[:n_lines] / (
        n * spacing
    )
    correlation_slope = linearised_force.residual_correlation_derivative(correlation)
    impulse = scipy.fft.irfft(receptance, 2 * n)
    impulse[: n + 1] *= correlation_slope
    impulse[n + 1 :] *= correlation_slope[-2:0:-1]
    return density.clip(min=0.0), -scipy.fft.rfft(impulse)[:n_lines]
