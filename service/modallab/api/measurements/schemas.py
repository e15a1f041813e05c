"""Wire types of measurements."""

from typing import Any, Self

import numpy as np

from modallab.api.deps import Id
from modallab.api.limits import REPLY
from modallab.api.rigs.schemas import setup_out
from modallab.api.thinning import thinned
from modallab.api.wire import Effects, Reply, Seed, StoredEntry, Wire, effect_out
from modallab.core.errors import InvalidInputError, bounds
from modallab.fe.structure import Structure
from modallab.jobs.measuring import MeasurementInputs, MeasurementOptions
from modallab.rig.effect import build
from modallab.rig.measure import Route
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.store.base import Entry, Truth


class MeasurementStart(Wire):
    """A virtual test. `effects` act beside what the rig declares, and show in no log book."""

    structure_id: Id
    """id of the structure under test"""
    rig_id: Id
    """id of the rig"""
    effects: Effects = ()
    """effects beside those of the structure and the rig; no log book shows them"""
    route: Route = Route.SAMPLED
    """`expected`: without random error; `drawn`: spectra from their distribution; `sampled`: time records"""
    seed: Seed = 0
    """seed of the random numbers"""

    def to_task(self, structure: Structure, setup: RigSetup) -> tuple[MeasurementInputs, MeasurementOptions]:
        """Return the task's inputs and options, checked as far as can be before the work.

        Raises
        ------
        UnknownDofError
            If the rig drives or listens where the structure has no DoF.
        InvalidInputError
            If an effect is unknown, cannot sit where it is said to, or a value is out of bounds.
        """
        for dof in (*setup.drives, *setup.responses):
            structure.index(dof)
        effects = [effect.to_domain() for effect in self.effects]
        for effect in [*effects, *(build(spec) for spec in (*structure.effects, *setup.effects))]:
            effect.check(structure, setup)
        specs = tuple(effect.spec for effect in effects)
        options = MeasurementOptions(specs, self.route, self.seed)
        return MeasurementInputs(self.structure_id, self.rig_id), options


class MeasurementOut(StoredEntry):
    """A measurement without its arrays: what was measured, and the rig as declared."""

    rig_id: str
    """id of the rig"""
    kind: str
    """quantity over force: inertance, mobility or receptance"""
    outputs: list[str]
    """response degrees of freedom"""
    inputs: list[str]
    """force degrees of freedom"""
    n_lines: int
    """number of lines"""
    frequency_max: float
    """Hz, frequency of the last line"""
    averages: float
    """1, effective number of averages"""
    rig: dict[str, Any]
    """rig as declared"""
    notes: list[str]
    """remarks of the measurement"""

    @classmethod
    def of(cls, measurement: Measurement, entry: Entry) -> Self:
        """Return what the contract shows of a measurement."""
        frf = measurement.frf
        return cls(
            **cls.fields(entry),
            rig_id=entry.inputs["rig_id"],
            kind=frf.kind.value,
            outputs=[str(dof) for dof in frf.outputs],
            inputs=[str(dof) for dof in frf.inputs],
            n_lines=len(frf.freq),
            frequency_max=float(frf.freq[-1]),
            averages=measurement.averages,
            rig=setup_out(measurement.setup),
            notes=list(measurement.notes),
        )


class TruthOut(Reply):
    """How a measurement was made: for its owner."""

    structure_id: str
    """id of the structure that was tested"""
    effects: list[dict[str, Any]]
    """effects that were added, as `kind`, `at`, `parameters`"""

    @classmethod
    def of(cls, truth: Truth) -> Self:
        """Return what the contract shows of a truth."""
        return cls(structure_id=truth.structure_id, effects=[effect_out(spec) for spec in truth.effects])


class CurveOut(Reply):
    """One FRF: values as [re, im], and its coherence."""

    output: str
    """response degree of freedom"""
    input: str
    """force degree of freedom"""
    values: list[tuple[float, float]]
    """m/s^2/N, m/s/N or m/N as `kind` says, FRF as [re, im]"""
    coherence: list[float] | None
    """1, coherence; null where it was not measured"""


class CurvesOut(Reply):
    """FRFs thinned for plots; peaks and notches stay."""

    freq: list[float]
    """Hz, lines that are kept"""
    kind: str
    """inertance, mobility or receptance"""
    curves: list[CurveOut]
    """one curve an FRF"""
    notes: list[str]
    """remarks of the measurement"""

    @classmethod
    def of(cls, measurement: Measurement, points: int) -> Self:
        """Return the curves at about `points` lines.

        Raises
        ------
        InvalidInputError
            If the reply would hold more numbers than JSON is good for.
        """
        frf = measurement.frf
        keep = thinned(np.abs(frf.values).reshape(len(frf.freq), -1), points)
        if 3 * len(keep) * frf.values[0].size > REPLY.json_curve_values:
            raise InvalidInputError(
                "these curves are too long for JSON: take fewer points, or the arrays as npz",
                field="points",
                value=points,
                allowed=bounds(maximum=REPLY.json_curve_values // 3, unit="points x FRFs"),
            )
        curves, g2 = [], measurement.coherence
        for j, output in enumerate(frf.outputs):
            for i, given in enumerate(frf.inputs):
                h = frf.values[keep, j, i]
                frf_coherence = None if g2 is None else g2[keep, j] if g2.ndim == 2 else g2[keep, j, i]
                coherence = None if frf_coherence is None else frf_coherence.tolist()
                values = list(zip(h.real.tolist(), h.imag.tolist(), strict=True))
                curves.append(
                    CurveOut(output=str(output), input=str(given), values=values, coherence=coherence)
                )
        freq, notes = frf.freq[keep].tolist(), list(measurement.notes)
        return cls(freq=freq, kind=frf.kind.value, curves=curves, notes=notes)
