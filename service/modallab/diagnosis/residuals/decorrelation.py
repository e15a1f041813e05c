"""Decorrelation of residuals of FRFs and responses to several simultaneous forces."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from modallab.diagnosis.residuals.channel_spectra import ChannelSpectra
from modallab.diagnosis.residuals.settings import RANDOM_ERROR
from modallab.estimation.correlated_errors import CorrelatedErrors, IncoherentShares


@dataclass(frozen=True, eq=False)
class RunErrors:
    """Correlated errors of a run with several simultaneous forces, at its lines among all."""

    lines: IntArray
    """(n,) lines of the run, rising."""
    frfs: CorrelatedErrors
    """Errors of its FRFs."""
    responses: CorrelatedErrors
    """Errors of the logarithms of its incoherent response spectra."""

    def at(self, lines: IntArray) -> "RunErrors":
        """Return the errors at some of all lines, (n,) rising indices."""
        _, places, rows = np.intersect1d(lines, self.lines, return_indices=True)
        return RunErrors(places, self.frfs.at(rows), self.responses.at(rows))

    def moved(self, n_before: int, columns: IntArray) -> "RunErrors":
        """Return the errors in a stack of tests.

        Parameters
        ----------
        n_before
            Lines of other tests before those of this one.
        columns
            (n_channels,) columns in the stack of the test's FRFs.
        """
        frfs, responses = (
            replace(errors, groups=columns[errors.groups]) for errors in (self.frfs, self.responses)
        )
        return RunErrors(n_before + self.lines, frfs, responses)


@dataclass(frozen=True, eq=False)
class Decorrelation:
    """Correlated errors of all runs with several simultaneous forces; runs are independent."""

    runs: tuple[RunErrors, ...]
    """Runs."""

    @classmethod
    def of(cls, spectra: ChannelSpectra, random: FloatArray) -> "Decorrelation | None":
        """Return the correlated errors of a measurement; None with one force a run or unknown errors.

        Parameters
        ----------
        random
            (n_freq, n_channels) share of the variance of each FRF that follows from its coherence.
        """
        unknown = spectra.response_coherence is None or spectra.forces is None
        if spectra.n_simultaneous == 1 or unknown:
            return None
        return cls(tuple(_of_run(spectra, random, run) for run in range(spectra.channels[-1].run + 1)))

    def at(self, lines: IntArray) -> "Decorrelation":
        """Return the errors at some of all lines, (n,) rising indices."""
        return Decorrelation(tuple(run.at(lines) for run in self.runs))

    def of_frfs(self, residual: ComplexArray, used: BoolArray) -> ComplexArray:
        """Return residuals (.., n_freq, n_frf) of FRFs with those of each run decorrelated where used."""
        return _decorrelated(residual, used, [(run.lines, run.frfs) for run in self.runs])

    def of_responses(self, residual: FloatArray, used: BoolArray) -> FloatArray:
        """Return residuals (n_freq, n_frf) of response spectra, each in the column of its first FRF."""
        parts = [(run.lines, run.responses) for run in self.runs]
        return _decorrelated(residual.astype(complex), used, parts).real


def _decorrelated(
    residual: ComplexArray, used: BoolArray, parts: list[tuple[IntArray, CorrelatedErrors]]
) -> ComplexArray:
    out = residual.copy()
    for lines, errors in parts:
        part = errors.decorrelated(residual[..., lines, :], used[lines])
        columns = errors.groups.ravel()
        out[..., lines[:, None], columns] = part[..., columns]
    return out


def _of_run(spectra: ChannelSpectra, random: FloatArray, run: int) -> RunErrors:
    """Return the correlated errors of one run."""
    assert spectra.response_coherence is not None
    assert spectra.forces is not None
    in_run = np.flatnonzero([channel.run == run for channel in spectra.channels])
    columns = in_run.reshape(spectra.n_simultaneous, -1).T  # a run goes through its responses force by force
    first, h = columns[:, 0], spectra.h[:, columns]
    forces, g2 = spectra.forces[:, first], spectra.response_coherence[:, first]
    coherent = ((h[..., None, :].conj() @ forces) @ h[..., None])[..., 0, 0].real
    incoherent = coherent * (1 - g2) / np.maximum(g2, RANDOM_ERROR.prediction_error)
    shares = IncoherentShares.of(h, incoherent, spectra.freq > 0)
    return RunErrors(
        np.arange(len(spectra.freq)),
        shares.of_frfs(h, forces[:, 0], random[:, columns], columns),
        shares.of_responses(first),
    )
