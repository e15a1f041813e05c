"""Virtual tests: the only work that knows how a measurement was made."""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from modallab.core.options import Options, option
from modallab.core.place import EffectSpec
from modallab.core.progress import Progress
from modallab.jobs.destination import Destination
from modallab.rig.change import Change
from modallab.rig.effect import build
from modallab.rig.effects_in_other_test import effects_in_other_test
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.record_settings import RECORDS
from modallab.rig.setup import RigSetup
from modallab.store.base import Store, Truth

# The same numbers in another order round otherwise: to the byte, a measurement is theirs too.
_LIBRARIES = {"numpy": np.__version__, "scipy": scipy.__version__}


@dataclass(frozen=True)
class MeasurementInputs:
    """Stored things that a measurement is made from."""

    structure_id: str
    rig_id: str


@dataclass(frozen=True)
class MeasurementOptions(Options):
    """Options of a virtual test."""

    effects: tuple[EffectSpec, ...] = option(
        (), max_items=50, doc="effects beside those of the structure and the rig; no log book shows them"
    )
    route: Route = option(
        Route.SAMPLED,
        doc="`expected`: without random error; `drawn`: spectra from their distribution; `sampled`: "
        "time records",
    )
    seed: int = option(0, unit="1", lower=0, upper=2**63 - 1, doc="seed of the random numbers")
    records: int = option(
        0,
        unit="records",
        lower=0,
        upper=RECORDS.kept_samples,
        doc="number of time records of every run that are kept, at most as many as averages; of the route "
        "`sampled`",
    )
    estimates: int = option(
        0,
        unit="estimates",
        lower=0,
        upper=RECORDS.most_estimates,
        doc="number of estimates of FRFs and coherence that are kept while averages are taken, the last "
        "after all; of the route `sampled`",
    )


def measure_and_store(
    store: Store,
    progress: Progress,
    into: Destination,
    inputs: MeasurementInputs,
    options: MeasurementOptions,
) -> None:
    """Run the virtual test; store the measurement, and separately its truth."""
    rig_id, seed = inputs.rig_id, options.seed
    truth = Truth(inputs.structure_id, options.effects)
    setup = store.rigs.get(rig_id)
    kept = {"records": options.records, "estimates": options.estimates}
    measurement = measured(store, progress, truth, setup, options.route, seed, **kept)
    with store.together() as batch:
        batch.measurements.add(
            measurement, owner=into.owner, inputs={"rig_id": rig_id}, seed=seed, id=into.id
        )
        batch.truths.add(truth, measurement_id=into.id, owner=into.owner)


def measure_again(
    store: Store, progress: Progress, into: Destination, *, measurement_id: str, change: Change, number: int
) -> None:
    """Run a virtual test again with a change; store measurement, log book and, separately, the truth.

    Hidden effects act as in the first test, where their places exist in the further test.

    Parameters
    ----------
    number
        Counts the further tests of the first one: each has a seed of its own.

    Raises
    ------
    InvalidInputError
        If the rig cannot do it.
    """
    if store.measurements.holds(into.id):
        return  # done by an attempt that died later
    first, entry = store.measurements.get(measurement_id), store.measurements.entry(measurement_id)
    setup = change.applied(first.setup)
    truth = _on_other_rig(store.truths.get(measurement_id, owner=entry.owner), first.setup, setup)
    seed = _further_seed(entry.seed or 0, number)
    measurement = measured(store, progress, truth, setup, first.route or Route.SAMPLED, seed)
    rig_id = into.derived_id("rig")
    with store.together() as batch:
        batch.rigs.add(setup, owner=into.owner, inputs={"rig_id": entry.inputs["rig_id"]}, id=rig_id)
        batch.measurements.add(
            measurement,
            owner=into.owner,
            inputs={"rig_id": rig_id, "first_measurement_id": measurement_id},
            seed=seed,
            id=into.id,
        )
        # Whoever may not see how the first was made may not see how this one was.
        batch.truths.add(truth, measurement_id=into.id, owner=entry.owner)


def measured(
    store: Store,
    progress: Progress,
    truth: Truth,
    setup: RigSetup,
    route: str,
    seed: int,
    *,
    records: int = 0,
    estimates: int = 0,
) -> Measurement:
    """Return the measurement of a virtual test, with its route, seed and libraries."""
    structure = store.structures.get(truth.structure_id)
    hidden = [build(spec) for spec in truth.effects]
    rng = np.random.default_rng(seed)
    kept = {"records": records, "estimates": estimates}
    measurement = measure(structure, setup, hidden, route=Route(route), rng=rng, progress=progress, **kept)
    return replace(measurement, seed=seed, route=route, libraries=_LIBRARIES)


def _on_other_rig(truth: Truth, first: RigSetup, setup: RigSetup) -> Truth:
    hidden = effects_in_other_test([build(spec) for spec in truth.effects], first, setup)
    return replace(truth, effects=tuple(effect.spec for effect in hidden))


def _further_seed(seed: int, number: int) -> int:
    """Return the seed of a further test, in the range that seeds have on the wire."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1, np.uint64)[0] >> np.uint64(1))
