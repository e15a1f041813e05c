"""Measured frequency responses in the form in which a model is compared with them."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray, frozen
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.numerics import SAFE_SQUARED_DIVISOR
from modallab.estimation.coherence import frf_error
from modallab.estimation.partial_coherence import partial_coherence
from modallab.estimation.settings import FORCE_NOISE
from modallab.updating.responses.settings import RESPONSE_ERRORS


@dataclass(frozen=True, eq=False)
class TargetResponses:
    """Receptances at some lines, with their random errors."""

    freq: FloatArray  # (n_lines,) Hz, above zero
    values: ComplexArray  # (n_lines, n_out, n_in) m/N
    errors: FloatArray  # (n_lines, n_out, n_in) standard error of ln |H|, also of the phase in radians
    used: BoolArray  # (n_lines, n_out, n_in) False for numbers without information
    # (n_lines, n_out, n_in) share of the variance that all outputs of an input have in common: noise of the
    # force, one random factor for each line
    common: FloatArray
    outputs: tuple[Dof, ...]
    inputs: tuple[Dof, ...]

    def __post_init__(self) -> None:
        shape = (len(self.freq), len(self.outputs), len(self.inputs))
        for name, kind in (("values", complex), ("errors", float), ("used", bool), ("common", float)):
            object.__setattr__(self, name, frozen(getattr(self, name), kind, shape, name=name))
        object.__setattr__(self, "freq", frozen(self.freq, float, shape[:1], name="freq"))

    @property
    def n_numbers(self) -> int:
        """Number of real numbers: magnitude and phase of every used response."""
        return 2 * int(self.used.sum())

    @property
    def sizes(self) -> FloatArray:
        """(n_lines, n_in) m/N, root mean square of the used responses at a line."""
        power = np.where(self.used, np.abs(self.values) ** 2, 0.0).sum(axis=1)
        return np.asarray(np.sqrt(power / np.maximum(self.used.sum(axis=1), 1)))

    def at(self, lines: IntArray) -> "TargetResponses":
        """Return the responses at some of the lines."""
        arrays = {name: getattr(self, name)[lines] for name in ("freq", "values", "errors", "used", "common")}
        return replace(self, **arrays)

    def evenly_spaced(self, numbers: int) -> IntArray:
        """Return indices of evenly spaced lines with at most `numbers` real numbers, at least one line."""
        n = len(self.freq)
        most = max(1, min(n, numbers // max(1, 2 * self.values[0].size)))
        return np.unique(np.linspace(0, n - 1, most).round().astype(int))


def target_responses(
    frf: FrfSet,
    coherence: FloatArray | None,
    averages: float,
    noise_floor: float | None = None,
    common: FloatArray | None = None,
) -> TargetResponses:
    """Return measured responses above 0 Hz as receptances with their random errors.

    Random errors are sqrt((1 - g2) / (2 g2 (n_d - 2))) with coherence g2, which is an estimate too, and the
    stated noise floor relative to the median of each FRF, as noise is not smaller where a structure
    hardly moves. 1992 thesis, eq. [5.16]. The bias of averages weighted by these errors, which depend on
    chance too, is removed.

    Parameters
    ----------
    coherence
        (n_freq, n_out), of several inputs the multiple coherence of simultaneous forces; or
        (n_freq, n_out, n_in) where each FRF has its own.
    averages, noise_floor
        Effective number of independent averages; stated relative random error of the FRFs.
    common
        (n_freq, n_out, n_in) variance of ln |H| by noise of the force, common to all outputs of an input;
        None without.

    Raises
    ------
    InvalidInputError
        If neither coherence with more than two averages nor a noise floor is given, or no response is
        usable.
    """
    _check_errors_known(coherence, averages, noise_floor)
    lines = _elastic_lines(frf)
    receptance = frf.between(0.0, np.inf).to(FrfKind.RECEPTANCE)
    size = np.abs(receptance.values)
    line_coherence = None
    if coherence is not None and averages > RESPONSE_ERRORS.unknown_averages:
        line_coherence = _of_frfs(receptance.values, coherence[lines])
        averages = _independent_averages(averages, coherence, size.shape[2])
    errors = _errors(size, line_coherence, averages, noise_floor)
    common_variance = np.zeros(size.shape) if common is None else common[lines]
    # The error by coherence is random itself; the common error is a lower bound of it.
    errors = np.maximum(errors, np.sqrt(common_variance / FORCE_NOISE.max_common_fraction))
    used = (size > SAFE_SQUARED_DIVISOR) & (errors < RESPONSE_ERRORS.max_error)
    if not used.any():
        raise InvalidInputError(
            "no response says anything: each is zero, or its random error larger than half of it",
            field="coherence",
            value=float(np.min(errors)),
            allowed=f"a relative random error below {RESPONSE_ERRORS.max_error}",
        )
    return TargetResponses(
        receptance.freq,
        receptance.values * np.exp(-_bias(size, line_coherence, averages, errors**2, common_variance)),
        errors,
        used,
        common_variance / errors**2,
        receptance.outputs,
        receptance.inputs,
    )


def _elastic_lines(frf: FrfSet) -> BoolArray:
    """Return the lines above 0 Hz, (n_freq,); raise `InvalidInputError` if there is none."""
    lines = frf.freq > 0
    if not lines.any():
        raise InvalidInputError(
            "there is no line above 0 Hz",
            field="freq",
            value=0.0,
            allowed=bounds(exclusive_minimum=0, unit="Hz"),
        )
    return lines


def _independent_averages(averages: float, coherence: FloatArray, n_in: int) -> float:
    """Return the averages that the random error has; each further simultaneous force takes one."""
    if coherence.ndim == 3:
        return averages
    return max(averages + 1 - n_in, float(np.nextafter(RESPONSE_ERRORS.unknown_averages, np.inf)))


def _of_frfs(values: ComplexArray, coherence: FloatArray) -> FloatArray:
    """Return the coherence of each FRF, (n_lines, n_out, n_in); without `n_in` it is the multiple one."""
    return coherence if coherence.ndim == 3 else partial_coherence(values, coherence)


def _errors(
    size: FloatArray, coherence: FloatArray | None, averages: float, noise_floor: float | None
) -> FloatArray:
    """Return the standard errors of log magnitudes, (n_lines, n_out, n_in)."""
    errors = np.full(size.shape, RESPONSE_ERRORS.model_error)
    if coherence is not None:
        errors = np.hypot(errors, _random_error(coherence, averages))
    if noise_floor is not None:
        relative_size = np.median(size, axis=0) / np.where(size > 0, size, np.inf)
        errors = np.hypot(errors, noise_floor * np.maximum(relative_size, 1.0))
    return np.asarray(errors)


def _random_error(coherence: FloatArray, averages: float) -> FloatArray:
    g2 = np.maximum(coherence, RESPONSE_ERRORS.min_coherence)
    return np.asarray(frf_error(g2, averages - RESPONSE_ERRORS.unknown_averages))


def _bias(
    size: FloatArray, coherence: FloatArray | None, averages: float, variance: FloatArray, common: FloatArray
) -> FloatArray:
    """Return the bias of ln |H| in weighted averages, (n_lines, n_out, n_in).

    A line whose magnitude is too large by chance has a higher coherence and more weight: the weight goes as
    |H|^2, and the average is off by twice the variance.
    """
    if coherence is None:
        return np.zeros(size.shape)
    individual_variance = variance - common
    random_variance = np.clip(_random_error(coherence, averages) ** 2 - common, 0.0, individual_variance)
    return np.asarray(2 * random_variance**2 / individual_variance)


def _check_errors_known(coherence: FloatArray | None, averages: float, noise_floor: float | None) -> None:
    """Raise `InvalidInputError` if random errors are neither estimated nor stated."""
    if noise_floor is not None or (coherence is not None and averages > RESPONSE_ERRORS.unknown_averages):
        return
    raise InvalidInputError(
        "responses count by their random errors: give the coherence and the number of averages, or else "
        "a noise floor",
        field="coherence" if coherence is None else "averages",
        value="none" if coherence is None else averages,
        allowed=f"coherence of more than {RESPONSE_ERRORS.unknown_averages} averages; "
        "or noise_floor, a relative error",
    )
