"""Spectra of several tests as those of one: lines one below the other, outputs side by side."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import BoolArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.diagnosis.residuals.decorrelation import Decorrelation, RunErrors
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted, SimulatedDeviations, VarianceRatios
from modallab.rig.frf_channel import FrfChannel

ChannelKey = tuple[Dof, int]
"""Response of an FRF, and the number of its drive point in its test."""


@dataclass(frozen=True)
class SpectrumStack:
    """FRF channels of several tests and their places in the stack of all.

    Channels of one response are stacked in one column, wherever a further test moves the force to; with a
    roving hammer or several shakers, in one column for each drive point.
    """

    tests: tuple[tuple[FrfChannel, ...], ...]
    """FRFs of each test."""
    roving: bool
    """Whether a roving accelerometer has a run, and a force, for each output."""
    averages: tuple[float, ...]
    """Effective number of averages of each test."""
    simultaneous: bool = False
    """Whether several forces act at once in some test."""

    @classmethod
    def of(cls, observed: Sequence[Observed], *, roving: bool) -> "SpectrumStack":
        """Return the stack of several measurements."""
        return cls(
            tuple(o.channels for o in observed),
            roving,
            tuple(o.averages for o in observed),
            any(o.n_simultaneous > 1 for o in observed),
        )

    @cached_property
    def keys(self) -> tuple[tuple[ChannelKey, ...], ...]:
        """Key of each FRF of each test."""
        return tuple(map(_keys, self.tests))

    @cached_property
    def all_keys(self) -> tuple[ChannelKey, ...]:
        """The keys of all tests, each once, by drive point."""
        return tuple(sorted(dict.fromkeys(key for keys in self.keys for key in keys), key=lambda key: key[1]))

    @property
    def all_channels(self) -> tuple[FrfChannel, ...]:
        """The FRFs of all tests, each once, with runs numbered in the stack."""
        firsts: dict[ChannelKey, FrfChannel] = {}
        for keys, channels in zip(self.keys, self.tests, strict=True):
            for key, channel in zip(keys, channels, strict=True):
                firsts.setdefault(key, channel)
        runs = list(dict.fromkeys(map(self._run_of, self.all_keys)))
        return tuple(replace(firsts[key], run=runs.index(self._run_of(key))) for key in self.all_keys)

    def _force_of(self, key: ChannelKey) -> object:
        """Return the key of an FRF's force spectrum: with a roving accelerometer each FRF has its own."""
        return key if self.roving else key[1]

    @property
    def _force_numbers(self) -> IntArray:
        """(n_channels,) number of each FRF's force: tests may drive one point as first and as second."""
        forces = list(dict.fromkeys(map(self._force_of, self.all_keys)))
        return np.array([forces.index(self._force_of(key)) for key in self.all_keys])

    def _run_of(self, key: ChannelKey) -> object:
        """Return the key of an FRF's run: that of its force, or of its response with simultaneous forces."""
        if not self.simultaneous:
            return self._force_of(key)
        return key[0] if self.roving else None

    def channels(self, parts: Sequence[NDArray[Any]], absent: complex) -> NDArray[Any]:
        """Return arrays (.., n_freq, n_out) as one (.., n_freq of all, n_out of all).

        Parameters
        ----------
        parts
            One array for each test.
        absent
            Value where a test has no such FRF.
        """
        return _stacked(parts, self.keys, self.all_keys, absent)

    def forces(self, parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Return arrays (.., n_freq, n_force) as one."""
        forces = [tuple(dict.fromkeys(map(self._force_of, keys))) for keys in self.keys]
        return _stacked(parts, forces, tuple(dict.fromkeys(map(self._force_of, self.all_keys))), 1.0)

    def predicted(self, parts: Sequence[Predicted]) -> Predicted:
        """Return the predictions of all tests as one."""
        leaking = any(part.excess_variance for part in parts)
        rescaled = any(part.variance_ratios for part in parts)
        return Predicted(
            h=self.channels([part.h for part in parts], 1.0),
            coherence=self.channels([part.coherence for part in parts], 1.0),
            force=self.forces([part.force for part in parts]),
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
            self.forces([part.force * share for part, share in zip(parts, shares, strict=True)]),
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
        return self.forces(force), self.channels(frf, 0.0), self.channels(response, 0.0)

    def observed(self, parts: Sequence[Observed]) -> Observed:
        """Return the measurements of all tests as one; nothing is usable where a test did not measure."""
        held_out = np.any(self.channels([part.held_out[None] for part in parts], False), axis=0)
        return Observed(
            freq=np.concatenate([part.freq for part in parts]),
            channels=self.all_channels,
            held_out=held_out,
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
            response_once=(
                self.channels([_response_once(part) for part in parts], False) if self.simultaneous else None
            ),
            n_simultaneous=max(part.n_simultaneous for part in parts),
            decorrelation=self._decorrelation(parts),
            stacked_forces=self._force_numbers,
            **self._auto_spectra(parts),
        )

    def _decorrelation(self, parts: Sequence[Observed]) -> Decorrelation | None:
        """Return the correlated errors of all tests."""
        runs: list[RunErrors] = []
        n_before = 0
        for keys, part in zip(self.keys, parts, strict=True):
            columns = np.array([self.all_keys.index(key) for key in keys])
            if part.decorrelation is not None:
                runs += [run.moved(n_before, columns) for run in part.decorrelation.runs]
            n_before += len(part.freq)
        return Decorrelation(tuple(runs)) if runs else None

    def _auto_spectra(self, parts: Sequence[Observed]) -> Mapping[str, Any]:
        """Return the auto spectra that all tests have, with the variance of their logarithms."""
        spectra: dict[str, Any] = {"force": None, "force_variance": 1.0}
        force = [part.force for part in parts if part.force is not None]
        if len(force) == len(parts):
            spectra["force"] = self.forces(force)
            spectra["force_variance"] = self.forces(
                [np.broadcast_to(p.force_variance, f.shape) for p, f in zip(parts, force, strict=True)]
            )
            if any(part.shape_variance is not None for part in parts):
                spectra["shape_variance"] = self.forces([_shape_variance(part) for part in parts])
        alike = len({part.per_force for part in parts}) == 1
        for name in ("incoherent", "incoherent_variance"):
            arrays = [array for part in parts if (array := getattr(part, name)) is not None]
            spectra[name] = self.channels(arrays, 1.0) if alike and len(arrays) == len(parts) else None
        spectra["per_force"] = parts[0].per_force
        return spectra


def _shape_variance(part: Observed) -> FloatArray:
    assert part.force is not None
    return np.zeros(part.force.shape) if part.shape_variance is None else part.shape_variance


def _keys(channels: Sequence[FrfChannel]) -> tuple[ChannelKey, ...]:
    drives = list(dict.fromkeys(channel.drive for channel in channels))
    return tuple((channel.response, drives.index(channel.drive)) for channel in channels)


def _stacked(
    parts: Sequence[NDArray[Any]],
    keys: Sequence[Sequence[object]],
    all_keys: Sequence[object],
    absent: complex,
) -> NDArray[Any]:
    """Return the columns of arrays (.., n_freq, n) at the places of their keys, one below the other."""
    padded_parts = []
    for columns, part in zip(keys, parts, strict=True):
        padded = np.full((*part.shape[:-1], len(all_keys)), absent, part.dtype)
        padded[..., [all_keys.index(key) for key in columns]] = part
        padded_parts.append(padded)
    return np.concatenate(padded_parts, axis=-2)


def _shared_noise(part: Observed) -> FloatArray:
    return np.zeros(part.h.shape) if part.shared_noise is None else part.shared_noise


def _response_once(part: Observed) -> BoolArray:
    return np.ones(part.h.shape, bool) if part.response_once is None else part.response_once


def _unit_ratios(part: Predicted) -> VarianceRatios:
    """Return the variance ratios of independent records."""
    unit = np.ones(part.h.shape)
    return VarianceRatios(np.ones(part.force.shape), unit, unit)
