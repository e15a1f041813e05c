"""What differs a little in every test and is no missing effect: tolerances, all truly varied."""

import numpy as np

from benchmarks.trial.rigs import Bench
from modallab.diagnosis.numbers.tolerances import Tolerances, drawn, nuisances
from modallab.fe.assembly import assemble
from modallab.rig.effect import Effect

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


def deviations(bench: Bench, rng: np.random.Generator) -> tuple[Effect, ...]:
    """Return how one test differs from what its model and log book say."""
    return drawn(tolerances(bench), bench.structure, bench.setup, rng)


def steps(bench: Bench) -> list[tuple[Effect, ...]]:
    """Return each number that may differ alone, one standard deviation off."""
    known = nuisances(tolerances(bench), assemble(bench.structure), bench.setup)
    return [known.effects(position) for position in np.eye(len(known))]
