"""Models and log books of the trial: for every kind of effect one on which it can show."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from modallab.core.dof import Dof
from modallab.fe.beam import beam
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Member, Section, Structure, Support
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.setup import RigSetup

BAR, STEEL = Section(area=5e-4, second_moment=4.1667e-9), Material(modulus=2.09e11, density=7800.0)
LAW = StructuralDamping(stiffness_coefficient=0.005, mass_coefficient=100.0)
# A beam has neither motion along its axis nor a length of stinger that could be told.
ON_FRAME = ("transverse_sensitivity", "stinger_bending")
# A free beam drifts on a hardening spring further than straight lines reach.
ON_CANTILEVER = (
    "cubic_stiffness",
    "friction",
    "cubic_damper",
    "elastic_support",
    "rotational_elastic_support",  # and these need a support
)
ON_HAMMER = ("double_hit",)
ON_ROVING = ("drift",)  # one run sees nothing of it


@dataclass(frozen=True)
class Bench:
    """A model and the rig that tests it, as its log book has it."""

    structure: Structure
    setup: RigSetup


@lru_cache(maxsize=1)
def free_beam() -> Structure:
    """Return the beam of most cases: 42 DoFs, eight bending modes below 800 Hz."""
    return STRUCTURES["chapter-5-beam"]()


@lru_cache(maxsize=1)
def cantilever() -> Structure:
    """Return the same beam clamped at node 1."""
    return STRUCTURES["cantilever"]()


@lru_cache(maxsize=1)
def frame() -> Structure:
    """Return two legs at a right angle, clamped at the foot: X and Y move together."""
    nodes = {i + 1: (0.0, 0.1 * i) for i in range(8)} | {i + 1: (0.1 * (i - 7), 0.7) for i in range(8, 13)}
    members = tuple(Member(i, (i, i + 1), BAR, STEEL) for i in range(1, 13))
    supports = (Support(1, ("X", "Y", "RZ")),)
    return Structure(nodes=nodes, members=members, supports=supports, damping=LAW, name="frame")


@lru_cache(maxsize=1)
def short_beam() -> Structure:
    """Return a free beam of eight elements, five modes below 400 Hz, for trials that have to be quick."""
    return beam(length=1.2, n_elements=8, section=BAR, material=STEEL, damping=LAW)


def bench(kinds: tuple[str, ...], rng: np.random.Generator, *, noise: float, leaking: bool) -> Bench:
    """Return a model and a rig on which all these kinds can show.

    Parameters
    ----------
    noise
        Declared ratio of noise to signal, of force and responses alike.
    leaking
        Pure random excitation through a Hann window, instead of periodic random.
    """
    roving = bool(rng.integers(2)) or any(kind in ON_ROVING for kind in kinds)
    base = RigSetup(
        drives=(Dof.parse("1:+Y"),),
        responses=tuple(Dof(n, "Y") for n in range(1, 22, 2)),
        exciter=Exciter(armature_mass=0.02),
        force_transducer=ForceTransducer(mass_below=0.01),
        accelerometers=Accelerometers(mass=0.02, roving=roving),
        noise=Noise(noise, noise),
        analyser=Analyser(
            window="hann" if leaking else "rectangular",
            excitation=ExcitationSetting("random" if leaking else "periodic_random"),
        ),
    )
    if any(kind in ON_HAMMER for kind in kinds):
        struck = replace(base.analyser, window="rectangular", excitation=ExcitationSetting("impact"))
        gauge = ForceTransducer()
        return Bench(
            free_beam(), replace(base, exciter=Exciter("hammer"), force_transducer=gauge, analyser=struck)
        )
    if any(kind in ON_FRAME for kind in kinds):
        along = tuple(Dof(n, "X") for n in (3, 5, 7)) + tuple(Dof(n, "Y") for n in (8, 9, 10, 11, 12, 13))
        return Bench(
            frame(), replace(base, drives=(Dof(13, "Y"),), responses=(*along, Dof(2, "X"), Dof(6, "X")))
        )
    if any(kind in ON_CANTILEVER for kind in kinds):
        # Fixed accelerometers: records of nonlinear forces are stepped, a minute for ten runs.
        fixed = replace(base.accelerometers, roving=False)
        outputs = tuple(Dof(n, "Y") for n in range(3, 22, 2))
        return Bench(
            cantilever(), replace(base, drives=(Dof(11, "Y"),), responses=outputs, accelerometers=fixed)
        )
    return Bench(free_beam(), base)


def small_bench(rng: np.random.Generator, *, noise: float) -> Bench:
    """Return a short beam with six responses and 161 lines to 400 Hz."""
    whole = bench((), rng, noise=noise, leaking=False).setup
    outputs = tuple(Dof(n, "Y") for n in (1, 2, 4, 5, 7, 9))
    settings = replace(whole.analyser, frequency_max=400.0, n_lines=161)
    return Bench(short_beam(), replace(whole, responses=outputs, analyser=settings))
