"""The gap of sampled tests in which nothing is missing: is it 1 in every part, whatever the excitation?

`python -m benchmarks.gap_without_cause [seeds]` prints the mean over some seeds of the mean squared residual
of the FRFs, the force spectra and what is not coherent in the responses, its scatter from test to test, and
the scatter that is expected of it. The ratio of `make bench` is the distance of a mean from 1 over its
standard error, the worst of all.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.bench import Bench, count
from modallab.core.dof import Dof
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.residuals.observe import observe
from modallab.diagnosis.residuals.residual import gap_errors
from modallab.fe.beam import beam
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Section
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.setup import RigSetup

SEEDS = 6
TOLERANCE = 4.5  # standard errors: the worst of 24 means is beyond four by chance once in 700 runs
KINDS = (
    ("periodic_random", "rectangular"),
    ("random", "hann"),
    ("random", "rectangular"),
    ("pseudo_random", "rectangular"),
    ("chirp", "rectangular"),
    ("stepped_sine", "rectangular"),
    ("burst_random", "rectangular"),
    ("impact", "rectangular"),
)
BEAM = beam(
    length=1.2,
    n_elements=8,
    section=Section(5e-4, 4.1667e-9),
    material=Material(2.09e11, 7800.0),
    damping=StructuralDamping(stiffness_coefficient=0.008, mass_coefficient=100.0),
)


def rig(kind: str, window: str) -> RigSetup:
    """Return a noisy rig with a roving accelerometer; blows come from a hammer."""
    setup = RigSetup(
        drives=(Dof(1, "Y"),),
        responses=tuple(Dof(n, "Y") for n in (1, 2, 4, 5, 7, 9)),
        exciter=Exciter(armature_mass=0.02),
        force_transducer=ForceTransducer(mass_below=0.01),
        accelerometers=Accelerometers(mass=0.02, roving=True),
        noise=Noise(1e-3, 1e-3),
        analyser=Analyser(400.0, 161, window, 100, excitation=ExcitationSetting(kind)),
    )
    if kind != "impact":
        return setup
    return replace(setup, exciter=Exciter(kind="hammer"), force_transducer=ForceTransducer())


def gaps(kind: str, window: str, seeds: int) -> Iterator[tuple[str, float, float, float]]:
    """Yield part, mean gap, its scatter from test to test, and the expected scatter."""
    setup, gaps, stated = rig(kind, window), [], []
    for seed in range(seeds):
        test = measure(BEAM, setup, route=Route.SAMPLED, rng=np.random.default_rng(seed))
        observed = observe(test, (), fraction=0.0)
        residual = SingleTestPredictor.of(BEAM, setup, observed).residual(())
        gaps.append(residual.gaps(observed.usable))
        stated.append(gap_errors(observed, residual, observed.usable))
    for part in gaps[0]:
        part_gaps = [run[part] for run in gaps]
        yield (
            part,
            float(np.mean(part_gaps)),
            float(np.std(part_gaps)),
            float(np.mean([run[part] for run in stated])),
        )


def run(seeds: int = SEEDS, kinds: Sequence[tuple[str, str]] = KINDS) -> list[tuple[str, float, float]]:
    """Return the distance from 1 of the worst mean, in its standard errors."""
    worst = max(
        abs(mean - 1) / (stated / np.sqrt(seeds))
        for kind, window in kinds
        for _, mean, _, stated in gaps(kind, window, seeds)
    )
    return [("gap with nothing missing, off 1 in standard errors", float(worst), TOLERANCE)]


def main() -> None:
    """Print the table."""
    seeds = count(__doc__, SEEDS, "seeds")
    print(f"{'excitation':<16} {'window':<12} {'part':<9} {'gap':>6} {'scatter':>8} {'expected':>8}")
    for kind, window in KINDS:
        for part, mean, scatter, stated in gaps(kind, window, seeds):
            print(f"{kind:<16} {window:<12} {part:<9} {mean:6.3f} {scatter:8.3f} {stated:8.3f}", flush=True)


BENCH = Bench(run, short=partial(run, seeds=1, kinds=KINDS[:1]))


if __name__ == "__main__":
    main()
