"""FRFs and coherence as they stood after the first averages of a simulated test."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import IntArray, frozen
from modallab.core.errors import InvalidInputError, bounds
from modallab.estimation.averaging import Densities, counts_of, effective_averages
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.analyser import Analyser
from modallab.rig.chain import Chain
from modallab.rig.record_settings import RECORDS
from modallab.rig.setup import RigSetup

SingleComplexArray = NDArray[np.complex64]
SingleArray = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Estimates:
    """FRFs and coherence after the first averages of every run, those after all of them left out.

    In single precision: their random errors are far above its rounding.
    """

    n_averages: IntArray
    """1, (n_estimates,) averages taken, ascending."""
    values: SingleComplexArray
    """unit of the FRFs, (n_estimates, n_freq, n_out, n_in) FRFs."""
    coherence: SingleArray
    """1, coherence (n_estimates, n_freq, n_out), (n_estimates, n_freq, n_out, n_in) with a roving hammer."""

    def __post_init__(self) -> None:
        n, shape = len(self.n_averages), self.values.shape[1:]
        coherence_shape = shape[: self.coherence.ndim - 1]
        object.__setattr__(self, "n_averages", frozen(self.n_averages, int, (n,), name="n_averages"))
        object.__setattr__(self, "values", frozen(self.values, np.complex64, (n, *shape), name="values"))
        coherence = frozen(self.coherence, np.float32, (n, *coherence_shape), name="coherence")
        object.__setattr__(self, "coherence", coherence)

    def __len__(self) -> int:
        return len(self.n_averages)


class SnapshotKeeper:
    """Collection of the spectra of every run after numbers of averages, while a test is simulated."""

    def __init__(self, n_estimates: int, analyser: Analyser, n_in: int) -> None:
        """Keep `n_estimates` less the last, after all averages; from as many as there are forces on."""
        self.counts = counts_of(n_estimates, analyser.simulated_averages, n_in)[:-1]
        self._runs: list[Sequence[Densities]] = []

    def add(self, snapshots: Sequence[Densities]) -> None:
        """Keep the spectra of a further run, one for each of `counts`."""
        self._runs.append(snapshots)

    def spectra(self, chain: Chain) -> Iterator[tuple[int, CrossSpectra]]:
        """Yield numbers of averages and the spectra of all runs after them."""
        analyser = chain.setup.analyser
        for i, count in enumerate(self.counts):
            ff, fx, xx = (np.array(part) for part in zip(*(run[i] for run in self._runs), strict=True))
            worth = effective_averages(count, chain.overlap, analyser.line_window)
            yield count, CrossSpectra(analyser.freq, ff, fx, xx, worth)


def check_estimates(n_estimates: int, setup: RigSetup, *, sampled: bool) -> None:
    """Return if this number of estimates of a test can be kept.

    Raises
    ------
    InvalidInputError
        If the test takes no averages one after the other, or its estimates are too large.
    """
    if n_estimates == 0:
        return
    if not sampled:
        raise InvalidInputError(
            "only the route sampled takes one average after the other",
            field="estimates",
            value=n_estimates,
            allowed=0,
        )
    values = setup.baseband.analyser.n_lines * len(setup.responses) * len(setup.drives)
    most = RECORDS.kept_estimate_values // values + 1  # the last is the measurement itself
    if n_estimates > most:
        raise InvalidInputError(
            "more estimates than can be kept of this test",
            field="estimates",
            value=n_estimates,
            allowed=bounds(0, most),
        )
