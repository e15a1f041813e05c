"""FRFs at fewer lines, for plots in JSON."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from modallab.api.limits import REPLY
from modallab.api.thinning import thinned
from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, bounds
from modallab.core.frf import FrfKind
from modallab.core.reply import Axes, Vector
from modallab.rig.measurement import Measurement


@dataclass(frozen=True, eq=False)
class Curve:
    """One FRF with its coherence."""

    output: Dof
    """Response DoF."""
    input: Dof
    """Force DoF."""
    values: Annotated[ComplexArray, Axes(1)]
    """(n_lines,) FRF in the unit of `kind`."""
    coherence: Vector | None
    """1, (n_lines,) coherence, multiple with several forces; None where it was not measured."""


@dataclass(frozen=True, eq=False)
class Curves:
    """FRFs of a measurement, thinned for plots; peaks and notches stay."""

    freq: Vector
    """Hz, (n_lines,) lines that are kept."""
    kind: FrfKind
    """Kind of the FRFs: receptance, mobility or inertance."""
    curves: tuple[Curve, ...]
    """One curve an FRF."""
    notes: tuple[str, ...]
    """Remarks on systematic changes of the FRFs."""


def curves_of(measurement: Measurement, points: int) -> Curves:
    """Return the FRFs of a measurement at about `points` lines.

    Raises
    ------
    InvalidInputError
        If the reply would hold more numbers than JSON is good for.
    """
    frf = measurement.frf
    lines = thinned(np.abs(frf.values).reshape(len(frf.freq), -1), points)
    if 3 * len(lines) * frf.values[0].size > REPLY.json_curve_values:
        raise InvalidInputError(
            "these curves are too long for JSON: take fewer points, or the arrays as npz",
            field="points",
            value=points,
            allowed=bounds(maximum=REPLY.json_curve_values // 3, unit="points x FRFs"),
        )
    coherence = measurement.coherence
    if coherence is not None:
        coherence = np.broadcast_to(coherence.reshape(*coherence.shape[:2], -1), frf.values.shape)[lines]
    curves = tuple(
        Curve(output, drive, frf.values[lines, j, i], None if coherence is None else coherence[:, j, i])
        for j, output in enumerate(frf.outputs)
        for i, drive in enumerate(frf.inputs)
    )
    return Curves(frf.freq[lines], frf.kind, curves, measurement.notes)
