"""Write a report page for each of several hidden causes: `python -m docs.gallery.reports [folder]`.

The pages are for looking at; they are not kept.
"""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from modallab.core.dof import Dof
from modallab.core.place import Channels, EffectSpec, Members
from modallab.diagnosis.diagnose import diagnose
from modallab.diagnosis.reporting.report import report
from modallab.diagnosis.result import Diagnosis
from modallab.fe.beam import beam
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Section, Structure
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.effect import build
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.setup import RigSetup

FOLDER = Path(__file__).parents[1] / "_build" / "reports"


@dataclass(frozen=True)
class Case:
    """What is hidden in a test, and what the diagnosis is asked."""

    hidden: tuple[EffectSpec, ...]
    excitation: str = "periodic_random"
    window: str = "rectangular"
    suspects: tuple[str, ...] | None = None
    hold_out: tuple[Dof, ...] = ()


def _one(kind: str, at: Dof | Members | Channels | None = None, **parameters: float) -> EffectSpec:
    return EffectSpec(kind, at, parameters)


def _at(node: int) -> Dof:
    return Dof(node, "Y")


CASES: Mapping[str, Case] = {
    "nothing": Case(()),
    "extra_mass": Case((_one("extra_mass", _at(5), mass=0.03),), hold_out=(_at(6), _at(7))),
    "stiffness_error": Case((_one("stiffness_error", Members((4,)), factor=1.2),)),
    "modulus": Case((_one("stiffness_error", None, factor=0.97),)),
    "loss_factor_error": Case((_one("loss_factor_error", None, factor=1.5),)),
    "attached_oscillator": Case((_one("attached_oscillator", _at(7), mass=0.05, frequency=150.0),)),
    "exciter_armature": Case((_one("exciter_armature", None, mass=0.03),)),
    "force_transducer_mass": Case((_one("force_transducer_mass", None, mass=0.01),)),
    "gain_error": Case((_one("gain_error", Channels((_at(7),)), factor=1.08),)),
    "polarity": Case((_one("polarity", Channels((_at(7),))),)),
    "channel_delay": Case((_one("channel_delay", Channels((_at(9),)), delay=2e-5),)),
    "leakage": Case((_one("leakage", None, share=0.1),)),
    "pure_random": Case((_one("density_error", Members((2,)), factor=1.3),), "random", "hann"),
    "pair": Case((_one("extra_mass", _at(7), mass=0.05), _one("stiffness_error", Members((3,)), factor=1.2))),
    "not_suspected": Case(
        (_one("ground_spring", _at(5), stiffness=2e4),), suspects=("extra_mass", "stiffness_error")
    ),
    "ground_spring": Case((_one("ground_spring", _at(5), stiffness=2e4),)),
}


def structure() -> Structure:
    """Return a free steel beam of ten elements."""
    return beam(
        length=1.2,
        n_elements=10,
        section=Section(5e-4, 4.1667e-9),
        material=Material(2.09e11, 7800.0),
        damping=StructuralDamping(stiffness_coefficient=0.008, mass_coefficient=100.0),
    )


def rig(case: Case) -> RigSetup:
    """Return the log book of its test: a roving accelerometer, eight responses, 201 lines to 500 Hz."""
    return RigSetup(
        drives=(_at(1),),
        responses=tuple(map(_at, (1, 2, 3, 4, 5, 7, 9, 11))),
        exciter=Exciter(armature_mass=0.02),
        force_transducer=ForceTransducer(mass_below=0.01),
        accelerometers=Accelerometers(mass=0.02, roving=True),
        noise=Noise(1e-3, 1e-3),
        analyser=Analyser(
            frequency_max=500.0,
            n_lines=201,
            window=case.window,
            averages=100,
            excitation=ExcitationSetting(case.excitation),
        ),
    )


def found(name: str) -> Diagnosis:
    """Return the diagnosis of a case, which knows nothing of what is hidden."""
    case = CASES[name]
    hidden = [build(spec) for spec in case.hidden]
    rng = np.random.default_rng([3, *name.encode()])
    test = measure(structure(), rig(case), hidden, route=Route.DRAWN, rng=rng)
    return diagnose(structure(), test, suspects=CASES[name].suspects, hold_out=case.hold_out, seed=1)


def main(folder: Path = FOLDER, names: Sequence[str] = tuple(CASES)) -> None:
    """Write the pages of some cases, by default of all."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        page = folder / f"{name}.html"
        page.write_text(report(found(name)), encoding="utf-8")
        sys.stdout.write(f"{page}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
