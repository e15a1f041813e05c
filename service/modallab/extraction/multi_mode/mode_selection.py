"""Selection of modes from the tracks of a stabilisation chart, with reasons."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, FloatArray, IntArray, frozen
from modallab.core.modal_model import DoubtfulMode, StabilisationChart
from modallab.extraction.multi_mode.chart_settings import SELECTION
from modallab.extraction.multi_mode.global_method import Poles
from modallab.extraction.multi_mode.pole_tracks import pole_tracks


@dataclass(frozen=True, eq=False)
class Selection:
    """Poles accepted as modes, in ascending frequency, with the reasons."""

    pole: ComplexArray
    """(n_modes,) s = -zeta omega_r + i omega_r sqrt(1 - zeta^2), rad/s."""
    frequency_scatter: FloatArray
    """(n_modes,) Hz, standard deviation over its representative orders."""
    loss_factor_scatter: FloatArray
    """(n_modes,) standard deviation over its representative orders."""
    mode: IntArray
    """(n_poles,) mode of each pole of the chart, from 0; -1 for none."""
    reasons: tuple[str, ...]
    """(n_modes,) reason of each mode as text."""
    pairs: tuple[tuple[int, int], ...]
    """Neighbouring modes closer than `pair_distance` bandwidths."""
    left_out: tuple[DoubtfulMode, ...]
    """Rejected columns, with the reason."""
    participation: ComplexArray | None
    """(n_modes, n_in) participation factors at the highest of these orders."""

    def __post_init__(self) -> None:
        n = len(self.pole)
        object.__setattr__(self, "pole", frozen(self.pole, complex, (n,), name="pole"))
        for name in ("frequency_scatter", "loss_factor_scatter"):
            object.__setattr__(self, name, frozen(getattr(self, name), float, (n,), name=name))
        object.__setattr__(self, "mode", frozen(self.mode, int, (None,), name="mode"))

    @property
    def frequency(self) -> FloatArray:
        """(n_modes,) |s|/2 pi, Hz."""
        return np.asarray(np.abs(self.pole) / (2 * np.pi))

    @property
    def loss_factor(self) -> FloatArray:
        """(n_modes,) twice the damping ratio."""
        return np.asarray(-2 * self.pole.real / np.abs(self.pole))


def chart_of(poles: Poles, stability: IntArray, selection: Selection) -> StabilisationChart:
    """Return the stabilisation chart with the selected modes."""
    return StabilisationChart(poles.order, poles.frequency, poles.loss_factor, stability, selection.mode)


@dataclass(frozen=True, eq=False)
class _TrackSummary:
    """Summary of one pole over the orders."""

    members: IntArray
    """Indices of its poles in the chart, highest order first."""
    representative: IntArray
    """Indices of its stable poles at the higher orders, which give its values."""
    pole: complex
    frequency: float
    """Hz."""
    loss_factor: float
    frequency_scatter: float
    loss_factor_scatter: float
    strength: float
    n_stable: int
    n_alike: int
    """Number of its poles stable in the vector too."""
    first: int
    """Order of the lowest stable pole."""
    n_since: int
    """Number of orders of the chart from the lowest stable one."""


def select(poles: Poles, stability: IntArray) -> Selection:
    """Return the modes of a chart with the reason for each, and notes on rejected tracks.

    A track is a mode if it is stable at enough orders, and at most orders from its first stable pole on; if
    its contribution to the FRFs exceeds noise; and if its bandwidth is that of a resonance. Its pole is the
    median of the stable poles at the higher orders, where noise biases them least.

    Parameters
    ----------
    poles
        Of rising orders, from a member of `GLOBAL_METHODS`.
    stability
        (n_poles,) from `stabilise`.
    """
    candidates = [_track_summary(poles, stability, members) for members in pole_tracks(poles)]
    columns = sorted(
        (column for column in candidates if column is not None), key=lambda column: column.frequency
    )
    objections = [_objection(column, poles) for column in columns]
    modes = [column for column, why in zip(columns, objections, strict=True) if why is None]
    mode = np.full(len(poles.order), -1)
    for m, column in enumerate(modes):
        mode[column.members] = m
    pairs = _pairs(modes)
    return Selection(
        np.array([column.pole for column in modes], complex),
        np.array([column.frequency_scatter for column in modes]),
        np.array([column.loss_factor_scatter for column in modes]),
        mode,
        tuple(_reason(modes, m, int(poles.orders[-1]), pairs) for m in range(len(modes))),
        pairs,
        tuple(
            DoubtfulMode(column.frequency, column.loss_factor, why)
            for column, why in zip(columns, objections, strict=True)
            if why is not None and column.n_stable >= SELECTION.noted_stable
        ),
        None
        if poles.participation is None
        else poles.participation[[int(c.representative[0]) for c in modes]],
    )


def _track_summary(poles: Poles, stability: IntArray, members: IntArray) -> _TrackSummary | None:
    """Return the summary of a column, None if it is not stable at any order."""
    stable = members[stability[members] >= SELECTION.stable_level]
    if not len(stable):
        return None
    representative = stable[: max(SELECTION.minimum_stable, (len(stable) + 1) // 2)]
    first = int(poles.order[stable].min())
    pole = complex(np.median(poles.pole[representative].real), np.median(poles.pole[representative].imag))
    return _TrackSummary(
        members=members,
        representative=representative,
        pole=pole,
        frequency=abs(pole) / (2 * np.pi),
        loss_factor=-2 * pole.real / abs(pole),
        frequency_scatter=float(poles.frequency[representative].std()),
        loss_factor_scatter=float(poles.loss_factor[representative].std()),
        strength=float(np.median(poles.strength[representative])),
        n_stable=len(stable),
        n_alike=int((stability[stable] > SELECTION.stable_level).sum()),
        first=first,
        n_since=int((poles.orders >= first).sum()),
    )


def _objection(column: _TrackSummary, poles: Poles) -> str | None:
    """Return the reason why a track is not a mode, None if it is one."""
    # the lowest order has no lower order to be compared with
    minimum = min(
        SELECTION.minimum_stable, max(1, int(SELECTION.minimum_stable_fraction * (len(poles.orders) - 1)))
    )
    if column.n_stable < minimum or column.n_stable < SELECTION.stable_fraction * column.n_since:
        return f"stable at only {column.n_stable} of {column.n_since} orders from {column.first} on"
    if column.strength < SELECTION.minimum_strength * np.sqrt(
        1 + SELECTION.few_frf_factor / poles.vector.shape[1]
    ):
        return f"not above noise, {column.strength:.2g} standard errors of a line"
    if column.loss_factor > SELECTION.largest_loss_factor:
        return f"no resonance, loss factor {column.loss_factor:.2g}"
    width = column.loss_factor * column.frequency / poles.spacing
    if width < SELECTION.smallest_width:
        return f"a single line, not a resonance: bandwidth of {width:.2g} lines"
    return None


def _pairs(modes: list[_TrackSummary]) -> tuple[tuple[int, int], ...]:
    return tuple(
        (m, m + 1) for m in range(len(modes) - 1) if _gap(modes[m], modes[m + 1]) < SELECTION.pair_distance
    )


def _gap(lower: _TrackSummary, upper: _TrackSummary) -> float:
    """Return the distance of two modes in half-power bandwidths of the broader one."""
    width = max(column.loss_factor * column.frequency for column in (lower, upper))
    return (upper.frequency - lower.frequency) / width


def _reason(modes: list[_TrackSummary], m: int, highest: int, pairs: tuple[tuple[int, int], ...]) -> str:
    column = modes[m]
    parts = [
        f"stable at {column.n_stable} of {column.n_since} orders from {column.first} to {highest}, "
        f"{column.n_alike} of them in shape too",
        f"scatter {100 * column.frequency_scatter / column.frequency:.2g} % in frequency and "
        f"{100 * column.loss_factor_scatter / column.loss_factor:.2g} % in loss factor",
        f"{20 * np.log10(column.strength):.0f} dB above the noise of a line",
    ]
    for pair in pairs:
        if m in pair:
            neighbour = modes[pair[0] + pair[1] - m]
            gap = _gap(modes[pair[0]], modes[pair[1]])
            parts.append(f"a pair with {neighbour.frequency:.5g} Hz, {gap:.2g} bandwidths away")
    return "; ".join(parts)
