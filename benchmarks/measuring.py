"""Whole measurements against what they cannot do without: eigensolutions, random numbers, transforms.

The test is the thesis's: its beam of 42 DoFs with hidden errors, an accelerometer roving over 11 places, a
gauge, an armature, noise on both sides, 801 lines.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
import scipy.fft
import scipy.linalg

from benchmarks.bench import Bench
from benchmarks.timing import ratio
from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.records import Recorder
from modallab.rig.setup import RigSetup
from modallab.rig.wishart import wishart_spectra

N_LINES, AVERAGES = 801, 100
NODES = range(1, 22, 2)
# Kind, window, limits of expected and sampled. What does not repeat with the record leaks: expected, it takes
# FRFs at 8,140 frequencies and a convolution; sampled, FRFs at 36,001 lines and what is expected.
SIGNALS = (("periodic_random", "rectangular", 5.0, 2.0), ("random", "hann", 30.0, 2.5))
GAUGE, ARMATURE, SENSOR = 0.01, 0.02, 0.02  # kg
ROUNDS = 15


def setup(excitation: str, window: str = "rectangular", averages: int = AVERAGES) -> RigSetup:
    """Return the rig."""
    return RigSetup(
        (Dof(1, "Y"),),
        tuple(Dof(node, "Y") for node in NODES),
        Exciter(armature_mass=ARMATURE),
        force_transducer=ForceTransducer(GAUGE),
        accelerometers=Accelerometers(SENSOR, roving=True),
        noise=Noise(1e-3, 1e-3),
        analyser=Analyser(800.0, N_LINES, window, averages, excitation=ExcitationSetting(excitation)),
    )


def measuring(rig: RigSetup, route: Route) -> Callable[[], object]:
    """Return what measures once, from the structure's elements to FRFs and coherence."""
    beam = STRUCTURES["chapter-5-beam"]()
    return lambda: measure(beam, rig, route=route, rng=np.random.default_rng(0))


def eigensolutions() -> Callable[[], object]:
    """Return what solves for all modes of the structure, the accelerometer at each of its places."""
    beam = assemble(STRUCTURES["chapter-5-beam"]()).add_mass(1, GAUGE)
    pairs = [
        (loaded.stiffness.toarray(), loaded.mass.toarray())
        for loaded in (beam.add_mass(node, SENSOR) for node in NODES)
    ]
    return lambda: [scipy.linalg.eigh(*pair, check_finite=False) for pair in pairs]


def bare_numbers() -> Callable[[], object]:
    """Return what draws the numbers of one test: two Gamma and two normal variables a line and response."""
    shape = (len(NODES), N_LINES)

    def draw() -> None:
        rng = np.random.default_rng(0)
        rng.standard_gamma(AVERAGES, shape)
        rng.standard_normal((*shape, 2))
        rng.standard_gamma(AVERAGES - 1, shape)

    return draw


def bare_transforms(rig: RigSetup) -> Callable[[], object]:
    """Return what draws source and noise, and takes both channels of each run there and back, no more.

    A signal that repeats with the record takes one transform a record; one that does not, a stretch of
    records with what it takes for the modes to ring out, of the length that the recorder lays out.
    """
    recorder = Recorder(chain(assemble(STRUCTURES["chapter-5-beam"]()), rig))
    layout, long = recorder.stretch_layout
    shape = recorder.shape
    stationary = rig.analyser.excitation.kind == "random"

    def bare() -> None:
        rng = np.random.default_rng(0)
        for _ in NODES:
            for start in range(0, AVERAGES, layout):
                n = min(layout, AVERAGES - start)
                rng.standard_normal((shape[0], n * shape[1]))
                n_draws, length = (1, long) if stationary else (n, 1)
                source = rng.standard_normal((n_draws, 1, 2 * ((N_LINES - 1) * length + 1))).view(complex)
                sources = np.broadcast_to(source, (n_draws, shape[0], source.shape[2]))
                signals = scipy.fft.irfft(sources, length * shape[1])
                records = signals.reshape(-1, *shape) if stationary else signals
                for record in records[:n]:
                    scipy.fft.rfft(record)

    return bare


def run(rounds: int = ROUNDS) -> list[tuple[str, float, float]]:
    """Return (name, time over that of the peer, limit)."""
    test = f"11 roving FRFs x {N_LINES} lines"
    solving, numbers = eigensolutions(), bare_numbers()
    rows = []
    for kind, window, most_expected, most_sampled in SIGNALS:
        rig = setup(kind, window)
        measured = ratio(measuring(rig, Route.EXPECTED), solving, rounds)
        rows.append((f"expected, {kind}: {test}, against 11 eigensolutions", measured, most_expected))
        measured = ratio(measuring(rig, Route.SAMPLED), bare_transforms(rig), min(rounds, 5))
        rows.append((f"sampled, {kind}: {test}, against rng + rfft", measured, most_sampled))
    spectra = expected_spectra(chain(assemble(STRUCTURES["chapter-5-beam"]()), setup("periodic_random")))
    direct_ratio = ratio(lambda: wishart_spectra(spectra, np.random.default_rng(0)), numbers, rounds)
    return [*rows, (f"drawn: {test} round their expectation, against rng", direct_ratio, 3.0)]


BENCH = Bench(run, short=partial(run, rounds=1))
