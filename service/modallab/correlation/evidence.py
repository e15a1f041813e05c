"""Evidence of disagreement between a measurement and its prediction."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.numerics import SAFE_DIVISOR
from modallab.correlation.settings import SUSPICION


@dataclass(frozen=True, eq=False)
class Evidence:
    """Residuals in units of their own random error, so that each has mean square 1 if nothing is missing.

    Lines and channels without information hold 0 and have zero `weight`.
    """

    freq: FloatArray  # (n_freq,) Hz
    outputs: tuple[Dof, ...]
    drive: Dof
    frf: ComplexArray  # (n_freq, n_out) ln(H_measured / H_predicted) over its error
    force: FloatArray | None  # (n_freq, n_out) ln of the force auto spectra's ratio over its error
    response: FloatArray | None  # (n_freq, n_out) the same of the conditional response spectrum
    coherence_drop: FloatArray  # (n_freq, n_out) predicted minus measured coherence
    weight: FloatArray  # (n_freq, n_out) 1 where the FRF counts, else 0
    mode_frequency: FloatArray  # (n_modes,) Hz, of the prediction
    frequency_shift: FloatArray  # (n_modes,) measured over predicted, minus 1
    response_amplitude: FloatArray  # (n_modes, n_out) |phi| of the prediction at the responses
    random_averages: float | None = None  # each of another random force; None: all of the same force

    @property
    def gaps(self) -> dict[str, float]:
        """Mean square of each part: 1 means only random error is left."""
        parts = {"frf": self.frf, "force": self.force, "response": self.response}
        count = max(self.weight.sum(), 1.0)
        return {
            name: float((np.abs(value) ** 2 * self.weight).sum() / count)
            for name, value in parts.items()
            if value is not None
        }

    @property
    def gap(self) -> float:
        """Mean square over all parts."""
        return float(np.mean(list(self.gaps.values())))

    @property
    def by_channel(self) -> FloatArray:
        """(n_out,) mean square of the FRF part by response."""
        count = np.maximum(self.weight.sum(axis=0), 1.0)
        return np.asarray((np.abs(self.frf) ** 2 * self.weight).sum(axis=0) / count)

    @property
    def standing_out(self) -> float:
        """Excess of the worst response over the median response, 0 to 1."""
        channel = self.by_channel
        return (
            float(1 - np.median(channel) / max(float(channel.max(initial=0.0)), 1.0)) if len(channel) else 0.0
        )

    def follows(self, course: ComplexArray | FloatArray) -> float:
        """Return the fraction of the worst response's residual that `course` (n_freq,) may cause, 0 to 1.

        The fraction f that is proportional to it, where nothing else is missing. Shifted resonances may
        cancel what is proportional by chance: of a residual that amounts to N independent numbers, sqrt(f)
        has a standard error of 1/sqrt(N).
        """
        worst = int(self.by_channel.argmax())
        residual = self.frf[:, worst] * self.weight[:, worst]
        size = float((np.abs(residual) ** 2).sum() * (np.abs(course) ** 2).sum())
        fraction = float((course.conj() * residual).real.sum()) ** 2 / max(size, SAFE_DIVISOR)
        reach = SUSPICION.excluded_errors / np.sqrt(
            SUSPICION.numbers_per_mode * max(len(self.mode_frequency), 1)
        )
        hidden = (np.sqrt(fraction) + reach) ** 2 - fraction
        return min(1.0, fraction + _excess_share(float(self.by_channel[worst])) * float(hidden))

    @property
    def wrong_force(self) -> float:
        """Fraction of the force spectra's residual that a cause in the exciter may have, 0 to 1.

        Most where the FRFs are right; but wrong FRFs exclude no such cause beside the one that makes them
        wrong. Few where no force spectrum tells.
        """
        gaps, least = self.gaps, SUSPICION.unlikely
        if "force" not in gaps:
            return least
        alone = max(0.0, gaps["force"] - gaps["frf"]) / max(gaps["force"], 1.0)
        return max(alone, least * _excess_share(gaps["force"]))

    @property
    def at_peaks(self) -> float:
        """Fraction of the residual at resonances in magnitude, not phase, 0 to 1: a sign of damping."""
        if not len(self.mode_frequency):
            return 0.0
        lines = np.abs(self.freq[:, None] - self.mode_frequency).argmin(axis=0)
        residual = (self.frf * self.weight)[lines]
        return float((residual.real**2).sum() / max(float((np.abs(residual) ** 2).sum()), SAFE_DIVISOR))

    @property
    def by_line(self) -> FloatArray:
        """(n_freq,) mean square of the FRF part by line."""
        count = np.maximum(self.weight.sum(axis=1), 1.0)
        return np.asarray((np.abs(self.frf) ** 2 * self.weight).sum(axis=1) / count)

    @property
    def excess(self) -> float:
        """By how many of its errors a line's incoherent response is too strong, on average; at least 0."""
        return self._surplus_of(self.response)

    @property
    def force_excess(self) -> float:
        """The same of the force."""
        return self._surplus_of(self.force)

    def _surplus_of(self, part: FloatArray | None) -> float:
        if part is None:
            return 0.0
        return max(0.0, float((part * self.weight).sum() / max(self.weight.sum(), 1.0)))

    @property
    def falling(self) -> float:
        """Number of modes with lowered frequency less those with raised one, over all modes, 0 to 1."""
        return _surplus(-self.frequency_shift)

    @property
    def rising(self) -> float:
        """Number of modes with raised frequency less those with lowered one, over all modes, 0 to 1."""
        return _surplus(self.frequency_shift)


def _excess_share(mean_square: float) -> float:
    """Return the share of a mean squared residual that is more than random error."""
    return 1 - 1 / max(mean_square, 1.0)


def _surplus(shifts: FloatArray) -> float:
    return max(0.0, float(np.sign(shifts).sum())) / max(len(shifts), 1)
