"""Time records of a measurement: force and response as the analyser took them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from modallab_client import _frf_plots, _tables
from modallab_client.models import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class TimeRecords:
    """Force and response of the first records of every run, before the window."""

    force: FloatArray = field(repr=False)
    """N, (n_records, n_samples, n_runs, n_forces)."""
    response: FloatArray = field(repr=False)
    """m/s^2, (n_records, n_samples, n_runs, n_responses)."""
    sample_rate: float
    """Hz."""
    inputs: tuple[tuple[str, ...], ...]
    """Force DoFs of every run."""
    outputs: tuple[tuple[str, ...], ...]
    """Response DoFs of every run."""
    force_unit: str = "N"
    response_unit: str = "m/s^2"

    @property
    def time(self) -> FloatArray:
        """s, (n_samples,) from the start of a record."""
        return np.arange(self.force.shape[1]) / self.sample_rate

    def of(self, output: str | None = None, drive: str | None = None) -> tuple[FloatArray, FloatArray]:
        """Return force and response of one FRF, each (n_records, n_samples); of the first one by default.

        Raises
        ------
        ValueError
            If no run has such a response and such a force.
        """
        for run, (drives, outputs) in enumerate(zip(self.inputs, self.outputs, strict=True)):
            if (drive is None or drive in drives) and (output is None or output in outputs):
                i = 0 if drive is None else drives.index(drive)
                j = 0 if output is None else outputs.index(output)
                return self.force[:, :, run, i], self.response[:, :, run, j]
        raise ValueError(f"no run has the response {output} and the force {drive}")

    def plot(self, output: str | None = None, drive: str | None = None) -> "tuple[Axes, Axes]":
        """Draw the first record, force over response, of one FRF; return both axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        ValueError
            If no run has such a response and such a force.
        """
        return _frf_plots.time_records(self, output, drive)

    def _repr_html_(self) -> str:
        n_records, n_samples, n_runs, _ = self.force.shape
        rows = [
            ("records", f"{n_records} of each run, {n_runs} run{'s' * (n_runs > 1)}"),
            ("samples", f"{n_samples} at {self.sample_rate:g} Hz"),
            ("forces", f"{', '.join(dict.fromkeys(sum(self.inputs, ())))}, {self.force_unit}"),
            ("responses", f"{', '.join(dict.fromkeys(sum(self.outputs, ())))}, {self.response_unit}"),
        ]
        return _tables.html((), rows, caption="Time records")


def time_records_of(arrays: Mapping[str, NDArray[Any]]) -> TimeRecords:
    """Return time records from the arrays of their npz file."""
    return TimeRecords(
        force=arrays["force"],
        response=arrays["response"],
        sample_rate=float(arrays["sample_rate"]),
        inputs=tuple(tuple(map(str, run)) for run in arrays["inputs"]),
        outputs=tuple(tuple(map(str, run)) for run in arrays["outputs"]),
        force_unit=str(arrays["force_unit"]),
        response_unit=str(arrays["response_unit"]),
    )
