"""Spectra of several tests as those of one: lines one below the other, outputs side by side."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted, SimulatedDeviations, VarianceRatios


@dataclass(frozen=True)
class SpectrumStack:
    """Outputs of several tests and their places in the stack of all."""

    outputs: tuple[tuple[Dof, ...], ...]
    """Outputs of each test."""
    roving: bool
    """Whether a roving accelerometer has a run, and a force, for each output."""
    averages: tuple[float, ...]
    """Effective number of averages of each test."""

    @classmethod
    def of(cls, observed: Sequence[Observed], *, roving: bool) -> "SpectrumStack":
        """Return the stack of several measurements."""
        return cls(tuple(o.outputs for o in observed), roving, tuple(o.averages for o in observed))

    @property
    def all_outputs(self) -> tuple[Dof, ...]:
        """The outputs of all tests, each once."""
        return tuple(dict.fromkeys(dof for outputs in self.outputs for dof in outputs))

    def channels(self, parts: Sequence[NDArray[Any]], absent: complex) -> NDArray[Any]:
        """Return arrays (.., n_freq, n_out) as one (.., n_freq of all, n_outputs of all).

        Parameters
        ----------
        parts
            One array for each test.
        absent
            Value where a test has no such output.
        """
        all_outputs = self.all_outputs
        padded_parts = []
        for outputs, part in zip(self.outputs, parts, strict=True):
            padded = np.full((*part.shape[:-1], len(all_outputs)), absent, part.dtype)
            padded[..., [all_outputs.index(dof) for dof in outputs]] = part
            padded_parts.append(padded)
        return np.concatenate(padded_parts, axis=-2)

    def runs(self, parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Return arrays (.., n_freq, n_run) as one: a roving accelerometer's runs are its outputs."""
        return self.channels(parts, 1.0) if self.roving else np.concatenate(parts, axis=-2)

    def predicted(self, parts: Sequence[Predicted]) -> Predicted:
        """Return the predictions of all tests as one."""
        leaking = any(part.excess_variance for part in parts)
        rescaled = any(part.variance_ratios for part in parts)
        return Predicted(
            h=self.channels([part.h for part in parts], 1.0),
            coherence=self.channels([part.coherence for part in parts], 1.0),
            force=self.runs([part.force for part in parts]),
            incoherent=self.channels([part.incoherent for part in parts], 1.0),
            excess_variance=partial(self._excess_variance, parts) if leaking else None,
            variance_ratios=partial(self._variance_ratios, parts) if rescaled else None,
            lines_correlated=any(part.lines_correlated for part in parts),
        )

    def _excess_variance(self, parts: Sequence[Predicted]) -> FloatArray:
        ratios = [
            np.ones(part.incoherent.shape) if part.excess_variance is None else part.excess_variance()
            for part in parts
        ]
        return self.channels(ratios, 1.0)

    def _variance_ratios(self, parts: Sequence[Predicted]) -> VarianceRatios:
        return self.variance_ratios(
            [_unit_ratios(part) if part.variance_ratios is None else part.variance_ratios() for part in parts]
        )

    def variance_ratios(self, parts: Sequence[VarianceRatios]) -> VarianceRatios:
        """Return the variance ratios of all tests as one."""
        # They multiply the variance of as many averages as the stack states, the fewest of all tests.
        shares = [min(self.averages) / averages for averages in self.averages]
        return VarianceRatios(
            self.runs([part.force * share for part, share in zip(parts, shares, strict=True)]),
            self.channels([part.frf for part in parts], 1.0),
            self.channels([part.response for part in parts], 1.0),
            self._deviations([part.deviations for part in parts]),
        )

    def _deviations(self, parts: Sequence[SimulatedDeviations | None]) -> SimulatedDeviations | None:
        """Return the deviations of simulated tests; those of each further test shifted by one simulation.

        One seed drew the simulations of all tests: without the shift they would be the same draws.
        """
        shifted = [
            [np.roll(part, i, axis=0) for part in deviations]
            for i, deviations in enumerate(parts)
            if deviations is not None
        ]
        if len(shifted) < len(parts):
            return None
        force, frf, response = zip(*shifted, strict=True)
        return self.runs(force), self.channels(frf, 0.0), self.channels(response, 0.0)

    def observed(self, parts: Sequence[Observed]) -> Observed:
        """Return the measurements of all tests as one; nothing is usable where a test did not measure."""
        held_out = {dof.point for part in parts for dof in np.array(part.outputs, object)[part.held_out]}
        return Observed(
            freq=np.concatenate([part.freq for part in parts]),
            outputs=self.all_outputs,
            held_out=np.array([dof.point in held_out for dof in self.all_outputs]),
            held_out_lines=np.concatenate([part.held_out_lines for part in parts]),
            correlation_length=max(part.correlation_length for part in parts),
            averages=min(part.averages for part in parts),
            variance_floor=max(part.variance_floor for part in parts),
            h=self.channels([part.h for part in parts], 1.0),
            error=self.channels([part.error for part in parts], 1.0),
            bias=self.channels([np.broadcast_to(part.bias, part.h.shape) for part in parts], 0.0),
            coherence=self.channels([part.coherence for part in parts], 0.0),
            usable=self.channels([part.usable for part in parts], False),
            shared_noise=self.channels([_shared_noise(part) for part in parts], 0.0),
            **self._auto_spectra(parts),
        )

    def _auto_spectra(self, parts: Sequence[Observed]) -> Mapping[str, Any]:
        """Return the auto spectra that all tests have, with the variance of their logarithms."""
        spectra: dict[str, Any] = {"force": None, "force_variance": 1.0}
        force = [part.force for part in parts if part.force is not None]
        if len(force) == len(parts):
            spectra["force"] = self.runs(force)
            spectra["force_variance"] = self.runs(
                [np.broadcast_to(p.force_variance, f.shape) for p, f in zip(parts, force, strict=True)]
            )
        for name in ("incoherent", "incoherent_variance"):
            arrays = [array for part in parts if (array := getattr(part, name)) is not None]
            spectra[name] = self.channels(arrays, 1.0) if len(arrays) == len(parts) else None
        return spectra


def _shared_noise(part: Observed) -> FloatArray:
    return np.zeros(part.h.shape) if part.shared_noise is None else part.shared_noise


def _unit_ratios(part: Predicted) -> VarianceRatios:
    """Return the variance ratios of independent records."""
    unit = np.ones(part.h.shape)
    return VarianceRatios(np.ones(part.force.shape), unit, unit)
