"""Time records of a simulated test that are kept: force and response, as the analyser took them."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import FloatArray, frozen
from modallab.core.errors import InvalidInputError, bounds
from modallab.rig.acquisition import samples_of
from modallab.rig.record_settings import RECORDS
from modallab.rig.setup import RigSetup

FORCE_UNIT = "N"
RESPONSE_UNIT = "m/s^2"


@dataclass(frozen=True, eq=False)
class TimeRecords:
    """Force and response of the first records of every run, before the window."""

    force: FloatArray
    """N, (n_records, n_samples, n_runs, n_forces) force."""
    response: FloatArray
    """m/s^2, (n_records, n_samples, n_runs, n_responses) acceleration."""
    sample_rate: float
    """Hz, sample rate."""

    def __post_init__(self) -> None:
        shape = self.force.shape
        object.__setattr__(self, "force", frozen(self.force, float, shape, name="force"))
        expected = (*shape[:3], self.response.shape[-1])
        object.__setattr__(self, "response", frozen(self.response, float, expected, name="response"))

    def __len__(self) -> int:
        return len(self.force)


class RecordKeeper:
    """Collection of the first records of every run while a test is simulated."""

    def __init__(self, n_records: int, sample_rate: float) -> None:
        self._n, self._sample_rate = n_records, sample_rate
        self._parts: dict[int, list[FloatArray]] = {}
        self._counts: dict[int, int] = {}

    def add(self, run: int, samples: FloatArray) -> None:
        """Keep what is still wanted of further records (n, n_ch, n_samples) of a run."""
        count = self._counts.get(run, 0)
        wanted = samples[: self._n - count]
        if len(wanted):
            # a copy: the recorder makes the next records in the same place
            self._parts.setdefault(run, []).append(wanted.copy())
            self._counts[run] = count + len(wanted)

    def records(self, n_in: int) -> TimeRecords:
        """Return the records of all runs, of which the first `n_in` channels are forces."""
        runs = np.stack([np.concatenate(self._parts[run]) for run in sorted(self._parts)])
        channels_last = runs.transpose(1, 3, 0, 2)
        return TimeRecords(channels_last[..., :n_in], channels_last[..., n_in:], self._sample_rate)


def check_records(n_records: int, setup: RigSetup, *, sampled: bool) -> None:
    """Return if this number of records of a test can be kept.

    Raises
    ------
    InvalidInputError
        If the test has no records, has fewer, or they are too large.
    """
    if n_records == 0:
        return
    if not sampled:
        raise InvalidInputError(
            "only the route sampled has time records", field="records", value=n_records, allowed=0
        )
    analyser = setup.simulated.analyser
    channels = sum(len(run.drives) + len(run.outputs) for run in setup.simulated.acquisition_runs)
    largest = RECORDS.kept_samples // (channels * samples_of(analyser))
    most = min(analyser.simulated_averages, largest)
    if n_records > most:
        reason = "the test has" if largest >= analyser.simulated_averages else "can be kept of this test"
        raise InvalidInputError(
            f"more time records than {reason}", field="records", value=n_records, allowed=bounds(0, most)
        )
