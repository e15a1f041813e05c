"""Pictures of one FRF, and of the time records that it is made of."""

from typing import TYPE_CHECKING, Any

import numpy as np

from modallab_client import _plots

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from modallab_client.models import ComplexArray, FloatArray
    from modallab_client.time_records import TimeRecords


class FrfPictures:
    """Pictures of one of many FRFs, in the form of Bode and of Nyquist."""

    if TYPE_CHECKING:
        freq: FloatArray
        values: ComplexArray
        outputs: tuple[str, ...]
        inputs: tuple[str, ...]
        kind: Any

    def plot_bode(self, output: str | None = None, drive: str | None = None) -> "tuple[Axes, Axes]":
        """Draw magnitude over phase of one FRF, the first by default; return both axes.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        ValueError
            If there is no such response or force.
        """
        rows = {"height_ratios": [2, 1]}
        _, (upper, lower) = _plots.pyplot().subplots(
            2, 1, sharex=True, gridspec_kw=rows, layout="constrained"
        )
        freq, values, name = _one(self, output, drive)
        upper.semilogy(freq, np.abs(values), linewidth=0.9)
        lower.plot(freq, np.degrees(np.angle(values)), linewidth=0.9)
        upper.set(ylabel=f"|{self.kind}|, {_plots.UNITS.get(self.kind, '')}", title=name)
        ticks = (-180, -90, 0, 90, 180)
        lower.set(xlabel="frequency, Hz", ylabel="phase, degrees", ylim=(-190, 190), yticks=ticks)
        return upper, lower

    def plot_nyquist(
        self,
        output: str | None = None,
        drive: str | None = None,
        *,
        band: tuple[float, float] | None = None,
    ) -> "Axes":
        """Draw one FRF, the first by default, in the complex plane; return the axes.

        Parameters
        ----------
        output, drive
            Response and force.
        band
            Hz, lowest and highest line drawn; by default all lines.

        Raises
        ------
        MissingExtraError
            If matplotlib is not installed.
        ValueError
            If there is no such response or force.
        """
        _, axes = _plots.pyplot().subplots(figsize=(5, 5), layout="constrained")
        freq, values, name = _one(self, output, drive)
        inside = np.ones(len(freq), bool) if band is None else (freq >= band[0]) & (freq <= band[1])
        axes.plot(values.real[inside], values.imag[inside], ".-", linewidth=0.8, markersize=4)
        axes.set(xlabel=f"real part, {_plots.UNITS.get(self.kind, '')}", ylabel="imaginary part", title=name)
        axes.axhline(0, color="grey", linewidth=0.5)
        axes.axvline(0, color="grey", linewidth=0.5)
        axes.set_aspect("equal", "datalim")
        return axes  # type: ignore[no-any-return]


def _one(frf: FrfPictures, output: str | None, drive: str | None) -> Any:
    """Return lines above 0 Hz, values and name of one FRF, the first one by default."""
    for kind, name, names in (("response", output, frf.outputs), ("force", drive, frf.inputs)):
        if name is not None and name not in names:
            raise ValueError(f"there is no {kind} {name}: there are {', '.join(names)}")
    response, force = output or frf.outputs[0], drive or frf.inputs[0]
    positive = frf.freq > 0
    values = frf.values[positive, frf.outputs.index(response), frf.inputs.index(force)]
    return frf.freq[positive], values, f"{response} / {force}"


def time_records(records: "TimeRecords", output: str | None, drive: str | None) -> "tuple[Axes, Axes]":
    """Draw the first record of one FRF, force over response; return both axes."""
    force, response = records.of(output, drive)
    _, (upper, lower) = _plots.pyplot().subplots(2, 1, sharex=True, layout="constrained")
    upper.plot(records.time, force[0], "C3", linewidth=0.8)
    lower.plot(records.time, response[0], "C0", linewidth=0.8)
    upper.set_ylabel(f"force, {records.force_unit}")
    lower.set(xlabel="time, s", ylabel="acceleration, m/s²")
    return upper, lower
