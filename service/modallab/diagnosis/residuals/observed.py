"""A measurement as a fit sees it: spectra, their random errors, the data held out."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.diagnosis.residuals.channel_noise import ChannelNoise
from modallab.diagnosis.residuals.decorrelation import Decorrelation
from modallab.diagnosis.residuals.free_levels import ALL_DECLARED, FreeLevels
from modallab.diagnosis.residuals.predicted import Predicted, VarianceRatios
from modallab.diagnosis.residuals.settings import FREE_LEVELS, RANDOM_ERROR
from modallab.diagnosis.residuals.source_power import SourcePower
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.frf_channel import FrfChannel, force_numbers


@dataclass(frozen=True, eq=False)
class Observed:
    """Measured H1, force and incoherent response spectra with the variance of their logarithms.

    By Bartlett's factorisation of the Wishart distribution the three are independent: G_ff has a
    Gamma(n) distribution, H1 given G_ff a normal one, the incoherent response spectrum Gamma(n - 1). If
    the force repeats in every average, G_ff varies by its noise alone, which coherence bounds from above.
    """

    freq: FloatArray
    """(n_freq,) Hz."""
    channels: tuple[FrfChannel, ...]
    """FRFs, n_out of them: one for each response and each force of each run."""
    h: ComplexArray
    """(n_freq, n_out) H1 as inertance, 1/kg."""
    error: FloatArray
    """(n_freq, n_out) relative random error of |H|, and of its phase in rad."""
    coherence: FloatArray
    """(n_freq, n_out), 1 where it is unknown."""
    force: FloatArray | None
    """(n_freq, n_force), N^2/Hz, the expectation of its logarithm unbiased; of the forces of all runs."""
    force_variance: FloatArray | float
    """(n_freq, n_force), variance of the logarithm of `force`."""
    incoherent: FloatArray | None
    """(n_freq, n_out), (m/s^2)^2/Hz, response spectrum times 1 - coherence; see `per_force`."""
    incoherent_variance: FloatArray | None
    """(n_freq, n_out), variance of its logarithm."""
    usable: BoolArray
    """(n_freq, n_out), entries with enough coherence."""
    held_out: BoolArray
    """(n_out,), FRFs excluded from every fit."""
    held_out_lines: BoolArray
    """(n_freq,), lines excluded from every fit."""
    correlation_length: float
    """Lines per independent line, by the window."""
    bias: FloatArray | float = 0.0
    """(n_freq, n_out), bias of ln |H| when weighted by its measured error."""
    averages: float = np.inf
    """Effective number of averages."""
    scale_error: float = 0.0
    """Relative standard error of the variances of all FRFs, where they are estimated themselves."""
    variance_floor: float = RANDOM_ERROR.prediction_error**2
    """Least variance of the logarithm of an auto spectrum."""
    shape_variance: FloatArray | None = None
    """(n_freq, n_force), least variance of the logarithm of `force`, of a source of unknown shape."""
    free_levels: FreeLevels = ALL_DECLARED
    """Levels that the log book leaves open."""
    shared_noise: FloatArray | None = None
    """(n_freq, n_out), share of an FRF's variance that the force's noise has, common to all of a run."""
    response_once: BoolArray | None = None
    """(n_freq, n_out), False where the incoherent spectrum is that of another FRF; None: nowhere.

    Several simultaneous forces have one spectrum of each response.
    """
    n_simultaneous: int = 1
    """Forces that act at the same time."""
    decorrelation: Decorrelation | None = None
    """Correlated errors of FRFs to simultaneous forces."""
    per_force: bool = False
    """Whether the incoherent spectra are those over the force spectrum, 1/kg^2: neither is known alone."""
    stacked_forces: IntArray | None = None
    """(n_out,) number of each FRF's force spectrum in a stack of tests; None: of one test."""
    force_correlation: ComplexArray | None = None
    """(n_run, n_freq, n_in, n_in), G_ff of simultaneous forces over its diagonal; None: not measured."""

    @property
    def outputs(self) -> tuple[Dof, ...]:
        """(n_out,): the response of each FRF."""
        return tuple(channel.response for channel in self.channels)

    @cached_property
    def runs(self) -> IntArray:
        """(n_out,): the number of each FRF's run."""
        return np.array([channel.run for channel in self.channels])

    @cached_property
    def forces(self) -> IntArray:
        """(n_out,): the number of each FRF's force spectrum, in ascending order."""
        return force_numbers(self.channels) if self.stacked_forces is None else self.stacked_forces

    @property
    def conditional_averages(self) -> float:
        """Effective number of averages, less the one that each further simultaneous force takes up."""
        return self.averages - (self.n_simultaneous - 1)

    @property
    def fitted(self) -> BoolArray:
        """(n_freq, n_out): entries that a fit may use."""
        return np.asarray(self.usable & ~self.held_out & ~self.held_out_lines[:, None])

    @property
    def held_out_mask(self) -> BoolArray:
        """(n_freq, n_out): usable entries that are held out."""
        return np.asarray(self.usable & ~self.fitted)

    def with_variance_ratios(self, ratios: VarianceRatios) -> "Observed":
        """Return the measurement with its variances multiplied by ratios."""
        incoherent = self.incoherent_variance
        return replace(
            self,
            error=self.error * np.sqrt(ratios.frf),
            force_variance=self.force_variance * ratios.force,
            incoherent_variance=None if incoherent is None else incoherent * ratios.response,
        )

    @cached_property
    def source_power(self) -> SourcePower | None:
        """Fits of the power of the sources; None without force spectra."""
        return SourcePower.of(self)

    def with_levels(
        self,
        spectra: CrossSpectra,
        lines: IntArray | None = None,
        *,
        start: ChannelNoise | None = None,
        last_step: float = FREE_LEVELS.last_step,
    ) -> CrossSpectra:
        """Return expected spectra with the levels that the log book leaves open, fitted to the measured ones.

        Parameters
        ----------
        lines
            (n,) indices of the measured lines among those of the spectra; None: all.
        start
            Noise of a prediction very much like this one, if it is known.
        last_step
            As in `fit_channel_noise`.
        """
        return self.free_levels.fitted(spectra, self, lines, start=start, last_step=last_step)

    def channel_noise(self, spectra: CrossSpectra) -> ChannelNoise | None:
        """Return the noise that the log book leaves open, fitted beside expected spectra; None without it."""
        levels = self.free_levels
        return levels.fitted_noise(levels.with_source(spectra, self), self) if levels.noise else None

    def force_of_channels(self, predicted: Predicted) -> FloatArray:
        """Return the expected force spectrum of each FRF, (n_freq, n_out)."""
        return predicted.force[:, self.forces]

    def expected_incoherent(self, predicted: Predicted) -> FloatArray:
        """Return the incoherent spectra (n_freq, n_out) of a prediction, as they were measured."""
        if not self.per_force:
            return predicted.incoherent
        return predicted.incoherent / self.force_of_channels(predicted)

    @property
    def level_known(self) -> bool:
        """Whether log book or force spectrum tell the level of the source."""
        return self.force is not None or not self.free_levels.source

    def at(self, lines: IntArray) -> "Observed":
        """Return some of the lines, (n,) indices."""
        return replace(
            self,
            freq=self.freq[lines],
            h=self.h[lines],
            error=self.error[lines],
            bias=self.bias if isinstance(self.bias, float) else self.bias[lines],
            force_variance=self._force_variance_at(lines),
            coherence=self.coherence[lines],
            force=_rows(self.force, lines),
            shape_variance=_rows(self.shape_variance, lines),
            incoherent=_rows(self.incoherent, lines),
            incoherent_variance=_rows(self.incoherent_variance, lines),
            usable=self.usable[lines],
            free_levels=self.free_levels.at(lines),
            held_out_lines=self.held_out_lines[lines],
            shared_noise=_rows(self.shared_noise, lines),
            response_once=None if self.response_once is None else self.response_once[lines],
            decorrelation=None if self.decorrelation is None else self.decorrelation.at(lines),
            force_correlation=None if self.force_correlation is None else self.force_correlation[:, lines],
        )

    def _force_variance_at(self, lines: IntArray) -> FloatArray | float:
        variance = self.force_variance
        return variance if isinstance(variance, float) else variance[lines]


def _rows(array: FloatArray | None, lines: IntArray) -> FloatArray | None:
    return None if array is None else array[lines]
