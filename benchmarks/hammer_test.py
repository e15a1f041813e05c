"""A hammer test against a periodic test of the same FRFs: one prediction, and a whole diagnosis.

Nine FRFs of the beam at 3,201 lines, one element too soft. The hammer strikes nine points, the shaker drives
one and nine accelerometers listen. A blow rings on beyond its record: its lines are those of a decayed one
less what the modes leave, in closed form.
"""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from benchmarks.bench import Bench
from benchmarks.timing import ratio
from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.diagnosis.diagnose import diagnose
from modallab.effects.stiffness_error import StiffnessError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.expected import coarse_spectra, expected_spectra
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.setup import RigSetup

POINTS = tuple(Dof(node, "Y") for node in (1, 4, 6, 8, 11, 13, 15, 18, 21))
SOFT = StiffnessError(Members((6,)), 0.8)
STEP = 8
N_LINES = 3201
# Exact, screening, diagnosis: measured 2.0, 1.2 and 1.4; the goal is 1 for each.
LIMITS = (3.0, 2.0, 2.5)


def periodic(n_lines: int) -> RigSetup:
    """Return a rig with a shaker at one end and an accelerometer at every point."""
    return RigSetup(
        POINTS[:1],
        POINTS,
        accelerometers=Accelerometers(roving=False),
        noise=Noise(1e-4, 1e-4),
        analyser=Analyser(800.0, n_lines, averages=30, excitation=ExcitationSetting("periodic_random")),
    )


def struck(n_lines: int) -> RigSetup:
    """Return a rig with a hammer at every point and an accelerometer at one end."""
    setup = periodic(n_lines)
    analyser = replace(setup.analyser, excitation=ExcitationSetting("impact"))
    return replace(setup, drives=POINTS, responses=POINTS[:1], exciter=Exciter("hammer"), analyser=analyser)


def predicted(setup: RigSetup, step: int | None = None) -> None:
    """Predict a test with an element of a stiffness that no cache holds; None: exactly, else to screen."""
    beam = assemble(STRUCTURES["chapter-5-beam"]())
    measuring_chain = chain(beam, setup, [SOFT])
    if step is None:
        expected_spectra(measuring_chain)
    else:
        coarse_spectra(measuring_chain, step)


def run(n_lines: int = N_LINES, rounds: int = 15, **options: Any) -> list[tuple[str, float, float]]:
    """Return processor times of the hammer test over those of the periodic test; `options` of `diagnose`."""
    hammer, shaker = struck(n_lines), periodic(n_lines)
    beam = STRUCTURES["chapter-5-beam"]()
    tests = [
        measure(beam, setup, [SOFT], route=Route.DRAWN, rng=np.random.default_rng(0))
        for setup in (hammer, shaker)
    ]
    ratios = (
        ratio(lambda: predicted(hammer), lambda: predicted(shaker), rounds),
        ratio(lambda: predicted(hammer, STEP), lambda: predicted(shaker, STEP), rounds),
        ratio(
            lambda: diagnose(beam, tests[0], **options),
            lambda: diagnose(beam, tests[1], **options),
            max(rounds // 5, 1),
        ),
    )
    names = ("exact prediction", "screening", "diagnosis")
    return [
        (f"hammer test over periodic test, {name}", figure, limit)
        for name, figure, limit in zip(names, ratios, LIMITS, strict=True)
    ]


BENCH = Bench(run, short=partial(run, n_lines=401, rounds=1, suspects=[SOFT.kind]))
