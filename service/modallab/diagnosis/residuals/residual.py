"""Residuals of a prediction in units of their random error."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import polygamma

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.diagnosis.residuals.autocorrelation import correlation_length, dependent_channels
from modallab.diagnosis.residuals.decorrelation import Decorrelation
from modallab.diagnosis.residuals.normalised_difference import normalised_difference
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted, VarianceRatios
from modallab.diagnosis.residuals.settings import RANDOM_ERROR, RESIDUAL
from modallab.estimation.force_noise import decorrelated_by_run


@dataclass(frozen=True, eq=False)
class Residual:
    """Logarithmic ratios of measurement to prediction over their random errors.

    Their mean square is 1 if the prediction is correct.
    """

    frf: ComplexArray
    """(n_freq, n_out), complex, of mean squared magnitude 1."""
    force: FloatArray | None
    """(n_freq, n_force) of the force spectra."""
    response: FloatArray | None
    """(n_freq, n_out) of the incoherent response spectra, see `response_once`."""
    excess_variance: Callable[[], FloatArray] | None = None
    """Variance ratio of `response` where power leaks, see `Predicted`."""
    variance_ratios: Callable[[], VarianceRatios] | None = None
    """Variance ratios of all parts, see `Predicted`."""
    force_variance: FloatArray | float = 1.0
    """Variance that `force` is scaled by."""
    averages: float = np.inf
    """Effective number of averages."""
    variance_floor: float = RANDOM_ERROR.prediction_error**2
    """Least variance of the logarithm of a force spectrum."""
    shape_variance: FloatArray | None = None
    """Least variance of the same, of a source of unknown shape, see `Observed`."""
    lines_correlated: bool = False
    """Whether lines share random numbers beyond those that a window mixes."""
    shared_noise: FloatArray | None = None
    """Share of the FRFs' variance common to all channels of a run, see `Observed.shared_noise`."""
    runs: IntArray | None = None
    """(n_out,) number of each channel's run; None: one run, or one for every force channel."""
    forces: IntArray | None = None
    """(n_out,) number of each channel's force spectrum, ascending; None: that of its run."""
    response_once: BoolArray | None = None
    """(n_freq, n_out) entries of `response` that no other channel has, see `Observed.response_once`."""
    decorrelation: Decorrelation | None = None
    """Correlated errors of FRFs to simultaneous forces, see `Observed.decorrelation`."""

    @property
    def run_of_channel(self) -> IntArray:
        """(n_out,) number of each channel's run."""
        if self.runs is not None:
            return self.runs
        n_out = self.frf.shape[1]
        own = self.force is not None and self.force.shape[1] == n_out
        return np.arange(n_out) if own else np.zeros(n_out, int)

    @property
    def force_of_channel(self) -> IntArray:
        """(n_out,) number of each channel's force spectrum."""
        return self.run_of_channel if self.forces is None else self.forces

    @property
    def parts(self) -> dict[str, ComplexArray | FloatArray]:
        """The measured parts by name."""
        parts = {"frf": self.frf, "force": self.force, "response": self.response}
        return {name: part for name, part in parts.items() if part is not None}

    def vector(self, mask: BoolArray) -> FloatArray:
        """Return the residuals (n_data,) at the entries of `mask` (n_freq, n_out), decorrelated.

        Each has unit variance; noise of the force that channels have in common is counted once.
        """
        frf, response = self.frf, self.response
        response_mask = self.mask_of("response", mask)
        if self.shared_noise is not None:
            share, forces = self.shared_noise, self.force_of_channel
            frf = decorrelated_by_run(frf, share, mask, forces)
            if response is not None:
                response = decorrelated_by_run(response, share**2, response_mask, forces)
        if self.decorrelation is not None:
            frf = self.decorrelation.of_frfs(frf, mask)
            response = None if response is None else self.decorrelation.of_responses(response, response_mask)
        frf = frf[mask]
        parts = [np.sqrt(2) * frf.real, np.sqrt(2) * frf.imag]
        if self.force is not None:
            parts.append(self.force[self.mask_of("force", mask)])
        if response is not None:
            parts.append(response[response_mask])
        return np.concatenate(parts)

    def means_by_part(self, squares: FloatArray, mask: BoolArray) -> dict[str, float]:
        """Return the mean over each part of squares (n_data,) of the entries of `vector`."""
        sizes = self.sizes_by_part(mask)
        pieces = np.split(squares, np.cumsum(list(sizes.values()))[:-1])
        return {name: float(piece.mean()) for name, piece in zip(sizes, pieces, strict=True)}

    def sizes_by_part(self, mask: BoolArray) -> dict[str, int]:
        """Return the number of entries of `vector` that each part has, one part after the other."""
        return {
            name: int(self.mask_of(name, mask).sum()) * (2 if np.iscomplexobj(part) else 1)
            for name, part in self.parts.items()
        }

    @cached_property
    def rescaled(self) -> dict[str, ComplexArray | FloatArray]:
        """The parts over their true standard deviation, that of leaking, periodic or burst signals included.

        A fit uses the parts themselves: with these its weights would depend on its parameters.
        """
        parts = self.parts
        if self.response is not None and self.excess_variance is not None:
            parts["response"] = self.response / np.sqrt(self.excess_variance())
        if self.variance_ratios is None:
            return parts
        ratios = self.variance_ratios()
        parts["frf"] = self.frf / np.sqrt(ratios.frf)
        if self.response is not None:
            parts["response"] = parts["response"] / np.sqrt(ratios.response)
        if self.force is not None:
            gamma_shape = self.averages / np.maximum(ratios.force, RANDOM_ERROR.prediction_error**2)
            variance = polygamma(1, gamma_shape) + self.variance_floor
            if self.shape_variance is not None:
                variance = np.maximum(variance, self.shape_variance)
            parts["force"] = self.force * np.sqrt(self.force_variance / variance)
        return parts

    def gaps(self, mask: BoolArray) -> dict[str, float]:
        """Return the mean square of each part at the entries of `mask`."""
        return {
            name: float((np.abs(part[self.mask_of(name, mask)]) ** 2).mean()) if mask.any() else 0.0
            for name, part in self.rescaled.items()
        }

    def mask_of(self, part: str, mask: BoolArray) -> BoolArray:
        """Return a mask (n_freq, n_out) for a part: of forces, where any channel of the force is in it."""
        if part == "response" and self.response_once is not None:
            return np.asarray(mask & self.response_once)
        if part != "force" or self.force is None or self.force.shape[1] == mask.shape[1]:
            return mask
        first_channels = np.unique(self.force_of_channel, return_index=True)[1]
        return np.logical_or.reduceat(mask, first_channels, axis=1)

    def gap(self, mask: BoolArray) -> float:
        """Return the mean of the parts' mean squares."""
        return float(np.mean(list(self.gaps(mask).values())))


def residual(observed: Observed, predicted: Predicted, *, noise_inflation: float = 0.0) -> Residual:
    """Return the whitened residual of a prediction at every line.

    Parameters
    ----------
    noise_inflation
        Relative error added to every random error. Far from its minimum a fit then follows the shape of
        the resonances instead of their noise.
    """
    inflation = noise_inflation**2
    frf = normalised_difference(observed, predicted.h) / np.sqrt(2 * (observed.error**2 + inflation))
    force = response = None
    force_variance = observed.force_variance + inflation
    if observed.force is not None:
        force = np.log(observed.force / predicted.force) / np.sqrt(force_variance)
    if observed.incoherent is not None and observed.incoherent_variance is not None:
        error = np.sqrt(observed.incoherent_variance + inflation)
        response = np.log(observed.incoherent / observed.expected_incoherent(predicted)) / error
    return Residual(
        frf,
        force,
        response,
        predicted.excess_variance,
        predicted.variance_ratios,
        force_variance,
        observed.averages,
        observed.variance_floor,
        observed.shape_variance,
        predicted.lines_correlated,
        observed.shared_noise,
        observed.runs,
        observed.forces,
        observed.response_once,
        observed.decorrelation,
    )


def inflation_weights(observed: Observed, mask: BoolArray, noise_inflation: float) -> FloatArray:
    """Return the factors (n_data,) of a residual's vector over `mask` under inflated random errors."""
    inflation = noise_inflation**2
    frf = observed.error / np.sqrt(observed.error**2 + inflation)
    force = response = None
    if observed.force is not None:
        factor = np.sqrt(observed.force_variance / (observed.force_variance + inflation))
        force = np.full(observed.force.shape, factor)
    if observed.incoherent_variance is not None:
        response = np.sqrt(observed.incoherent_variance / (observed.incoherent_variance + inflation))
    factors = Residual(
        (1 + 1j) / np.sqrt(2) * frf,
        force,
        response,
        forces=observed.forces,
        response_once=observed.response_once,
    )
    return factors.vector(mask)


def error_ratio(narrow: Observed, wide: Observed) -> FloatArray:
    """Return the ratio (n_data,) of narrow to wide random errors, by entry of the fitted vector."""
    force = response = None
    if narrow.force is not None:
        force = np.full(narrow.force.shape, np.sqrt(narrow.force_variance / wide.force_variance))
    if narrow.incoherent_variance is not None and wide.incoherent_variance is not None:
        response = np.sqrt(narrow.incoherent_variance / wide.incoherent_variance)
    frf = (1 + 1j) / np.sqrt(2) * narrow.error / wide.error
    ratios = Residual(frf, force, response, forces=narrow.forces, response_once=narrow.response_once)
    return ratios.vector(narrow.fitted)


def correlation_lengths(
    observed: Observed, residual: Residual, *, max_lag: int | None = None
) -> dict[str, float]:
    """Return the number of lines per independent line, by part.

    The number that a window causes is known. Leakage, and blows of different sizes, spread the few random
    numbers of a resonance over all lines; for them the number follows from the autocorrelation of the
    residuals.

    Parameters
    ----------
    max_lag
        Largest distance, in lines, of correlated lines; None for any distance, but then a missing effect
        that changes slowly from line to line looks like leakage too.
    """
    if not residual.lines_correlated:
        return dict.fromkeys(residual.parts, observed.correlation_length)
    return {
        name: correlation_length(np.where(residual.mask_of(name, observed.usable), part, 0.0), max_lag)
        for name, part in residual.rescaled.items()
    }


def gap_errors(
    observed: Observed, residual: Residual, mask: BoolArray, *, max_lag: int | None = None
) -> dict[str, float]:
    """Return the standard error of each part's gap over `mask` if no effect is missing.

    `max_lag` as in `correlation_lengths`.
    """
    errors: dict[str, float] = {}
    for name, length in correlation_lengths(observed, residual, max_lag=max_lag).items():
        part = residual.parts[name]
        # A complex residual consists of two numbers, so its mean square scatters less. Its error comes from
        # a measured coherence: the ratio of its square to the squared error has an F distribution.
        f_variance = 1 + 2 / max(observed.conditional_averages - 3, RESIDUAL.min_freedom)
        square_variance = f_variance if np.iscomplexobj(part) else 2.0
        part_mask = residual.mask_of(name, mask)
        count = max(int(part_mask.sum()), 1)
        values = np.where(part_mask, residual.rescaled[name], 0.0)
        if name == "response" and residual.response_once is not None:
            values = values[:, residual.response_once.any(axis=0)]
        channels = dependent_channels(values)
        errors[name] = float(np.sqrt(square_variance * length * channels / count))
    return errors


def gap_error(observed: Observed, residual: Residual, mask: BoolArray) -> float:
    """Return the standard error of the whole gap over `mask` if no effect is missing."""
    errors = np.array(list(gap_errors(observed, residual, mask).values()))
    return float(np.sqrt((errors**2).sum()) / len(errors))
