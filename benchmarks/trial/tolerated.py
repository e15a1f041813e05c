"""What differs a little in every test and is no missing effect: tolerances, all truly varied."""

from collections.abc import Sequence

import numpy as np

from benchmarks.trial.hidden import Gauge
from benchmarks.trial.rigs import Bench
from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.place import Channels
from modallab.diagnosis.numbers.tolerances import LIMIT, Nuisances, Tolerances, drawn, nuisances
from modallab.fe.assembly import assemble
from modallab.rig.effect import Effect
from modallab.rig.setup import RigSetup

DELAY = 1e-3  # over the top of the band
# The kind of effect that changes what is tolerated.
KIND = {
    "modulus": "stiffness_error",
    "density": "density_error",
    "sensitivity": "gain_error",
    "accelerometer_mass": "accelerometer_mass",
    "delay": "channel_delay",
    "modal_loss_factor": "loss_factor_error",
}


def tolerances(bench: Bench) -> Tolerances:
    """Return what the diagnosis is told of a test: how much may differ, not how much did."""
    return Tolerances(
        modulus=0.003,
        density=0.002,
        sensitivity=0.005,
        accelerometer_mass=0.03,
        delay=DELAY / bench.setup.analyser.frequency_max,
        modal_loss_factor=0.2,
    )


class Tolerated:
    """What may differ a little in a test, and what of hidden effects is more than that."""

    def __init__(self, bench: Bench, *, tolerant: bool = True) -> None:
        self._bench = bench
        system = assemble(bench.structure)
        self.numbers = nuisances(tolerances(bench), system, bench.setup) if tolerant else Nuisances()
        self._gauges: dict[tuple[bool, ...], Gauge] = {}

    def opened(self, effects: Sequence[Effect], setup: RigSetup | None = None) -> float:
        """Return the gap that effects open in expectation, beyond what is tolerated; see `Gauge`.

        Of what is tolerated itself only what lies beyond its limit counts.
        """
        own = np.any([np.zeros(len(self.numbers), bool), *map(self._changed, effects)], axis=0)
        key = tuple(own.tolist())
        if key not in self._gauges:
            self._gauges[key] = Gauge(self._bench, self.steps(~own))
        return self._gauges[key].opened([self.surplus(one) for one in effects], setup)

    def steps(self, which: BoolArray | None = None) -> list[tuple[Effect, ...]]:
        """Return each number that may differ alone, one standard deviation off; of some, or all."""
        each = np.eye(len(self.numbers))
        return [self.numbers.effects(position) for position in (each if which is None else each[which])]

    def surplus(self, effect: Effect) -> Effect:
        """Return what of an effect lies beyond what is tolerated of its kind there; all where nothing is."""
        limit = self.limit(effect)
        if not limit:
            return effect
        name, away = _amount(effect)
        beyond = float(np.sign(away)) * max(abs(away) - limit, 0.0)
        return effect.with_parameters({name: effect.parameters[name] - away + beyond})

    def limit(self, effect: Effect) -> float:
        """Return how far from nothing the diagnosis tolerates an effect, 0 where it does not."""
        spreads = [
            one.spread for one, own in zip(self.numbers.numbers, self._changed(effect), strict=True) if own
        ]
        unit = self.numbers.mass if effect.kind == "accelerometer_mass" else 1.0
        return LIMIT * unit * max(spreads, default=0.0)

    def _changed(self, effect: Effect) -> BoolArray:
        """Return which numbers (n,) an effect changes, if it is of their kind and acts just where they do."""
        whole = effect.at is None
        return np.array(
            [
                KIND[one.name] == effect.kind
                and (whole or (isinstance(one.at, Channels) and one.at == effect.at))
                for one in self.numbers.numbers
            ],
            bool,
        )

    def deviations(self, rng: np.random.Generator, hidden: Sequence[Effect] = ()) -> tuple[Effect, ...]:
        """Return how one test differs from what its model and log book say.

        Normal, within `LIMIT` standard deviations. Drawn again where it would draw what is hidden back
        within what is tolerated, so that there would be nothing to be found.
        """
        position = drawn(len(self.numbers), rng)
        while any(self._drawn_back(one, position) for one in hidden):
            position = drawn(len(self.numbers), rng)
        return self.numbers.effects(position)

    def _drawn_back(self, effect: Effect, position: FloatArray) -> bool:
        own = self._changed(effect)
        return bool(own.any() and (_amount(effect)[1] * position[own] < 0).all())


def _amount(effect: Effect) -> tuple[str, float]:
    """Return the only number that an effect of a tolerated kind has, and how far it is from nothing."""
    ((name, spec),) = effect.specs().items()
    assert spec.absent is not None
    return name, effect.parameters[name] - spec.absent
