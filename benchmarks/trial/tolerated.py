"""What differs a little in every test and is no missing effect: tolerances, all truly varied."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from benchmarks.trial.hidden import Gauge, spectra_of
from benchmarks.trial.rigs import Bench
from modallab.diagnosis.fitting.fit import fit
from modallab.diagnosis.optimisation.nuisance_parameters import nuisance_parameters
from modallab.diagnosis.optimisation.nuisances import Nuisances, draw_positions
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.fe.assembly import assemble
from modallab.rig.effect import Effect
from modallab.rig.measure import measurement_of

DELAY = 1e-3  # over the top of the band


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
        numbers = nuisance_parameters(tolerances(bench), system, bench.setup) if tolerant else Nuisances()
        self.numbers = numbers.without(numbers.optional)

    @cached_property
    def gauge(self) -> Gauge:
        """Gaps beyond what a straight line of these numbers explains."""
        directions = np.eye(len(self.numbers))
        return Gauge(self._bench, [self.numbers.effects(position) for position in directions])

    def deviations(self, rng: np.random.Generator) -> tuple[Effect, ...]:
        """Return how one test differs from what its model and log book say."""
        return self.numbers.effects(draw_positions(len(self.numbers), rng))

    def unexplained(self, acting: Sequence[Effect]) -> float:
        """Return the gap that is left in expectation where all numbers lie as well as their limits let them.

        Random error included. Of what is itself tolerated, or what several numbers do together, a straight
        line does not tell how much is left.
        """
        if not len(self.numbers):
            return self.gauge.opened(acting)
        measured = measurement_of(spectra_of(self._bench, acting), self._bench.setup)
        observed = observe(measured, (), fraction=0.0)
        predictor = SingleTestPredictor.of(self._bench.structure, self._bench.setup, observed)
        predictor = predictor.with_nuisances(self.numbers)
        effects = self.numbers.effects(fit(predictor, ()).nuisance_position)
        return Gauge(self._bench).opened(acting, accepted=effects)
