"""How long a diagnosis takes: CPU seconds on one core for tests on a beam and on a frame.

`python -m benchmarks.diagnosing [name ...]` prints the seconds of every case, or of those that are named.
The ratios of `make bench` are medians, and the longest of the beam, over what is allowed.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.bench import Bench, parser
from benchmarks.trial.rigs import LAW, free_beam
from modallab.core.dof import Dof
from modallab.core.place import Channels, Members, Place
from modallab.diagnosis.diagnose import diagnose
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.structure import Structure
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup

BEAM_MEDIAN, BEAM_WORST, FRAME_MEDIAN = 10.0, 120.0, 60.0  # s on one core
NOISE = 1e-4


@dataclass(frozen=True)
class Timed:
    """A test of something hidden, and what the diagnosis may look for."""

    structure: Structure
    setup: RigSetup
    hidden: tuple[Effect, ...]
    suspects: tuple[str, ...] | None = None

    def measured(self) -> Measurement:
        """Return the test, its records averaged."""
        rng = np.random.default_rng(0)
        return measure(self.structure, self.setup, self.hidden, route=Route.SAMPLED, rng=rng)


def rig(drive: Dof, responses: Sequence[Dof], kind: str = "periodic_random") -> RigSetup:
    """Return a rig with fixed accelerometers, 401 lines to 800 Hz and 100 averages."""
    window = "hann" if kind == "random" else "rectangular"
    setup = RigSetup(
        drives=(drive,),
        responses=tuple(responses),
        exciter=Exciter(armature_mass=0.02),
        force_transducer=ForceTransducer(mass_below=0.01),
        accelerometers=Accelerometers(mass=0.02, roving=False),
        noise=Noise(NOISE, NOISE),
        analyser=Analyser(window=window, excitation=ExcitationSetting(kind)),
    )
    if kind != "impact":
        return setup
    return replace(setup, exciter=Exciter("hammer"), force_transducer=ForceTransducer())


def effect(kind: str, at: Place, **numbers: float) -> Effect:
    """Return an effect with some of its parameters."""
    return EFFECTS[kind](at=at).with_parameters(numbers)


def beam_cases() -> Mapping[str, Timed]:
    """Return tests of the free beam: 42 DoFs, 11 responses."""
    outputs = [Dof(n, "Y") for n in range(1, 22, 2)]
    stiff = effect("stiffness_error", Members((6,)), factor=0.8)
    mass = effect("extra_mass", Dof(13, "Y"), mass=0.05)
    louder = effect("gain_error", Channels((Dof(9, "Y"),)), factor=1.2)
    joint = effect("joint_flexibility", Dof(8, "RZ"), flexibility=2e-4)
    tested = {
        "beam-mass": ("periodic_random", (mass,)),
        "beam-stiffness": ("periodic_random", (stiff,)),
        "beam-gain": ("periodic_random", (louder,)),
        "beam-mass-random": ("random", (mass,)),
        "beam-pair": ("periodic_random", (stiff, louder)),
        "beam-hammer": ("impact", (mass,)),
    }
    diagnosis = {
        name: Timed(free_beam(), rig(Dof.parse("1:+Y"), outputs, kind), hidden)
        for name, (kind, hidden) in tested.items()
    }
    rivals = tuple(k for k, cls in EFFECTS.items() if cls.suspected and k != "joint_flexibility")
    diagnosis["beam-unexplained"] = Timed(free_beam(), rig(Dof.parse("1:+Y"), outputs), (joint,), rivals)
    return diagnosis


def frame_cases() -> Mapping[str, Timed]:
    """Return tests of the frame of three bays: 234 DoFs, 36 responses."""
    structure = replace(STRUCTURES["garteur"](), damping=LAW)
    nodes = sorted(structure.nodes)
    outputs = [Dof(n, direction) for n in nodes[1::4][:18] for direction in ("X", "Y")]
    setup = rig(Dof(nodes[1], "Y"), outputs)
    members = [member.number for member in structure.members]
    tested = {
        "frame-mass": effect("extra_mass", Dof(nodes[30], "Y"), mass=0.2),
        "frame-stiffness": effect("stiffness_error", Members((members[40],)), factor=0.7),
        "frame-gain": effect("gain_error", Channels((outputs[7],)), factor=1.2),
    }
    return {name: Timed(structure, setup, (hidden,)) for name, hidden in tested.items()}


def seconds(name: str, case: Timed) -> float:
    """Return the CPU seconds a diagnosis takes; print them, and what it found."""
    measurement = case.measured()
    start = time.process_time()
    diagnosis = diagnose(case.structure, measurement, suspects=case.suspects)
    elapsed = time.process_time() - start
    steps = ", ".join(f"{case.effect.kind} {case.effect.at}" for case in diagnosis.steps)
    print(
        f"{name:<18} {elapsed:7.1f} s  {diagnosis.verdict}: {steps}  gap {diagnosis.remaining_gap:.2f}",
        flush=True,
    )
    return elapsed


def run(
    beams: Mapping[str, Timed] | None = None, frames: Mapping[str, Timed] | None = None
) -> list[tuple[str, float, float]]:
    """Return median and longest seconds over what is allowed, each limit 1."""
    beam = [seconds(name, case) for name, case in (beam_cases() if beams is None else beams).items()]
    frame = [seconds(name, case) for name, case in (frame_cases() if frames is None else frames).items()]
    of_beam, of_frame = float(np.median(beam)), float(np.median(frame))
    return [
        (f"diagnosis of the beam, median over {BEAM_MEDIAN:.0f} s", of_beam / BEAM_MEDIAN, 1.0),
        (f"diagnosis of the beam, longest over {BEAM_WORST:.0f} s", max(beam) / BEAM_WORST, 1.0),
        (f"diagnosis of the frame, median over {FRAME_MEDIAN:.0f} s", of_frame / FRAME_MEDIAN, 1.0),
    ]


def main() -> None:
    """Print what some cases take, or all."""
    cases = {**beam_cases(), **frame_cases()}
    arguments = parser(__doc__)
    arguments.add_argument("names", nargs="*", metavar="name", help=f"of {', '.join(cases)}; default: all")
    for name in arguments.parse_args().names or cases:
        seconds(name, cases[name])


def short() -> list[tuple[str, float, float]]:
    """Return the same of one quick test, which stands for the frames too."""
    mass = beam_cases()["beam-mass"]
    setup = replace(mass.setup, analyser=replace(mass.setup.analyser, n_lines=101))
    quick = {"beam-mass": replace(mass, setup=setup, suspects=("extra_mass",))}
    return run(quick, quick)


BENCH = Bench(run, short)


if __name__ == "__main__":
    main()
