"""Against the frequency equation of a beam held in rotation, and a stinger of many beam elements."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.effects.exciter_armature import ExciterArmature
from modallab.effects.stinger_axial import StingerAxial
from modallab.effects.stinger_bending import StingerBending
from modallab.effects.stinger_mass import StingerMass
from modallab.fe.assembly import assemble
from modallab.fe.structure import PLANE, Material, Member, PointMass, Section, Structure, Support
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.hardware import ForceTransducer
from modallab.rig.setup import AcquisitionRun, RigSetup
from modallab.rig.stinger import StingerRod, StingerStiffness
from tests.rigs import BAR, STEEL, beam_system, rig, steel_beam

FREQ = np.linspace(2.0, 800.0, 400)
ARMATURE = 0.02
LONG = StingerRod(1.5e-3, 67e-3, 2.07e11, 7850.0)  # appendix D of the 1992 thesis
SHORT = StingerRod(1.5e-3, 13e-3, 2.07e11, 7850.0)
STUD = StingerRod(4e-3, 50e-3, 2.07e11, 7850.0)


def loaded(effect: StingerBending, drive: Dof, structure: Structure | None = None) -> FloatArray:
    """Elastic natural frequencies, Hz."""
    system = assemble(structure or steel_beam(n_elements=60))
    return effect.on_system(system, AcquisitionRun((drive,), (drive,))).modes().elastic(6).frequencies


@pytest.mark.parametrize("stiffness", [3.0, 100.0, 1e4])
def test_a_free_beam_held_in_rotation_has_the_frequencies_of_its_equation(stiffness: float) -> None:
    """v'' = (k/EI) v' and v''' = 0 at the driven end, v'' = v''' = 0 at the other; v = e^(ax), roots of the
    determinant in a L."""
    rigidity, mass, length = STEEL.modulus * BAR.second_moment, STEEL.density * BAR.area, 1.5

    def equation(al: float) -> float:
        a = al / length
        ch, sh, c, s = np.cosh(al), np.sinh(al), np.cos(al), np.sin(al)
        k = stiffness / (rigidity * a)
        rows = [  # of cosh, sinh, cos, sin
            [1.0, -k, -1.0, -k],
            [0.0, 1.0, 0.0, -1.0],
            [ch, sh, -c, -s],
            [sh, ch, s, -c],
        ]
        return float(np.linalg.det(np.array(rows)) / ch)

    grid = np.linspace(0.3, 14.0, 600)
    signs = np.sign([equation(al) for al in grid])
    roots = [brentq(equation, *grid[i : i + 2]) for i in np.flatnonzero(np.diff(signs))]
    wanted = (np.array(roots) / length) ** 2 * np.sqrt(rigidity / mass) / (2 * np.pi)
    found = loaded(StingerBending(stiffness=stiffness), Dof(1, "Y"))
    assert len(wanted) >= 4
    # 60 elements err by some 1e-6 in frequency, falling with the fourth power of their number; and every
    # eigenvalue by the rounding of the largest one, which a spring that hardly holds the beam feels
    highest = assemble(steel_beam(n_elements=60)).modes().eigenvalues.real.max()
    rounding = np.finfo(float).eps * highest / (8 * np.pi**2 * wanted[:4])
    assert (np.abs(found[:4] - wanted[:4]) < 2e-6 * wanted[:4] + rounding).all()


def rod_elements(
    rod: StingerRod, direction: tuple[float, float], pieces: int, structure: Structure
) -> tuple[Structure, int]:
    """The structure with the rod on node 1 as beam elements, clamped in an armature that moves along it."""
    section = Section(np.pi / 4 * rod.diameter**2, np.pi / 64 * rod.diameter**4)
    material = Material(rod.modulus, rod.density)
    start = np.array(structure.nodes[1])
    nodes, members, last = dict(structure.nodes), list(structure.members), 1
    for i in range(1, pieces + 1):
        number = max(nodes) + 1
        x, y = start + np.array(direction) * rod.length * i / pieces
        nodes[number] = (float(x), float(y))
        own = Member(len(members) + 1, (last, number), section, material, loss_factor=0.0)
        members.append(own)
        last = number
    held = Support(last, ("X" if direction[0] == 0 else "Y", "RZ"))
    whole = replace(
        structure,
        nodes=nodes,
        members=tuple(members),
        supports=(*structure.supports, held),
        masses=(*structure.masses, PointMass(last, ARMATURE)),
    )
    return whole, last


def plane_beam() -> Structure:
    """The beam at a slope of 3 to 4: where it is driven, it moves along X and Y and turns."""
    straight = steel_beam()
    tilted = {node: (0.8 * x, 0.6 * x) for node, (x, _) in straight.nodes.items()}
    return replace(straight, nodes=tilted, directions=PLANE)


@cache
def explicit(rod: StingerRod, drive: str, response: str) -> tuple[ComplexArray, ComplexArray]:
    """Force on the beam per force on the armature, and response per that force, from the elements."""
    at, heard = Dof.parse(drive), Dof.parse(response)
    away = (-1.0, 0.0) if at.direction == "X" else (0.0, -1.0)
    whole, armature = rod_elements(rod, away, 24, plane_beam())
    system, alone = assemble(whole), assemble(plane_beam())
    rows = [system.index(dof) for dof in alone.dofs]
    force, answer = [], []
    for omega in 2 * np.pi * FREQ:
        z, own = (
            (s.stiffness + 1j * s.damping - omega**2 * s.mass).toarray()  # type: ignore[operator]
            for s in (system, alone)
        )
        push = np.zeros(len(system.dofs))
        push[system.index(Dof(armature, at.direction))] = 1.0
        x = np.linalg.solve(z, push)
        force.append((own @ x[rows])[alone.index(at)])
        answer.append(-(omega**2) * x[system.index(heard)])
    return np.array(force), np.array(answer) / np.array(force)


def by_effects(
    rod: StingerRod, drive: str, response: str, *kinds: type[Effect]
) -> tuple[ComplexArray, ComplexArray]:
    """The same from effects."""
    every: list[Effect] = [
        StingerBending(stiffness=rod.bending_stiffness, length=rod.length),
        StingerAxial(stiffness=rod.axial_stiffness),
        StingerMass(mass=rod.mass, length=rod.length),
        ExciterArmature(mass=ARMATURE),
    ]
    setup = RigSetup((Dof.parse(drive),), (Dof.parse(response),))
    answer = chain(assemble(plane_beam()), setup, [e for e in every if type(e) not in kinds]).respond(FREQ)
    return answer.force[0, :, 0, 0], answer.inertance[0, :, 0, 0]


def worst(found: ComplexArray, wanted: ComplexArray, band: float) -> float:
    """Largest difference up to `band`, Hz, over the largest value there."""
    there = band >= FREQ
    return float(np.abs(found - wanted)[there].max() / np.abs(wanted[there]).max())


@pytest.mark.parametrize("rod", [LONG, SHORT, STUD])
@pytest.mark.parametrize(("drive", "response"), [("1:+Y", "7:+Y"), ("1:+X", "7:+Y")])
def test_it_is_a_stinger_of_many_beam_elements_below_the_stinger_s_own_modes(
    rod: StingerRod, drive: str, response: str
) -> None:
    wanted, found = explicit(rod, drive, response), by_effects(rod, drive, response)
    # The rod's own deflection is left out from the fourth power of frequency on: some (1/4)^4 of its share
    # up to a quarter of its first bending mode, ten times that up to a half.
    for band, tolerance in ((rod.bending_frequency / 4, 1e-3), (rod.bending_frequency / 2, 1e-2)):
        for one, other in zip(found, wanted, strict=True):
            assert worst(one, other, min(band, 800.0)) < tolerance
    without = by_effects(rod, drive, response, StingerBending)
    assert worst(without[1], wanted[1], 800.0) > 0.2


def test_a_stinger_on_the_other_side_leans_the_other_way() -> None:
    """Seen from behind, a structure is its mirror image: lateral motion and slope couple the other way."""
    effect = StingerBending(stiffness=50.0, length=0.1)
    plus, minus = (loaded(effect, Dof(11, "Y", sign), plane_beam()) for sign in (1, -1))
    # in the middle a half turn maps one to the other; rounding of the softest among squares up to 1e12
    np.testing.assert_allclose(plus, minus, rtol=1e-6)
    plus, minus = (loaded(effect, Dof(5, "Y", sign), plane_beam()) for sign in (1, -1))
    assert np.abs(plus / minus - 1).max() > 1e-5


def test_without_coupling_it_is_two_springs_apart() -> None:
    system, drive = assemble(plane_beam()), Dof(5, "Y")
    (apart,) = StingerBending(stiffness=50.0, length=0.1).variants(system)
    assert [name for name, *_ in apart.fitted_specs()] == ["stiffness", "length"]
    springs = system.add_spring(Dof(5, "RZ"), 50.0).add_spring(Dof(5, "X"), 3 * 50.0 / 0.1**2)
    held = apart.on_system(system, AcquisitionRun((drive,), (drive,)))
    np.testing.assert_allclose(
        held.folded().stiffness.toarray(), springs.folded().stiffness.toarray(), rtol=1e-12
    )  # the same sums


def test_mass_cancellation_takes_the_mass_away_and_leaves_the_bending() -> None:
    gauge = ForceTransducer(0.05, mass_cancelled=True)
    bare = chain(beam_system(), rig(1, 7)).respond(FREQ).inertance
    with_mass = chain(beam_system(), rig(1, 7, force_transducer=gauge)).respond(FREQ).inertance
    np.testing.assert_allclose(with_mass, bare, rtol=1e-12)  # rounding
    declared = rig(1, 7, force_transducer=gauge, stinger=STUD)
    held = chain(beam_system(), declared).respond(FREQ).inertance
    assert np.abs(held - bare).max() > 0.5 * np.abs(bare).max()
    # what is left is the stinger alone, that turns with the drive point
    turning = [
        StingerBending(stiffness=STUD.bending_stiffness),
        StingerMass(mass=STUD.mass, length=STUD.length),
    ]
    alone = chain(beam_system(), rig(1, 7), turning)
    np.testing.assert_allclose(held, alone.respond(FREQ).inertance, rtol=1e-6)  # rounding, two solutions


def test_a_rod_declares_both_its_stiffnesses_and_springs_declare_a_rod_that_has_them() -> None:
    (found,) = StingerBending.from_setup(rig(1, stinger=STUD))
    assert found.stiffness == pytest.approx(4 * 2.07e11 * np.pi / 64 * 4e-3**4 / 50e-3)
    assert found.length == 50e-3
    lateral = 12 * 2.07e11 * np.pi / 64 * 4e-3**4 / 50e-3**3
    springs = StingerStiffness(bending_stiffness=found.stiffness, lateral_stiffness=lateral)
    (again,) = StingerBending.from_setup(rig(1, stinger=springs))
    assert again.length == pytest.approx(50e-3)
    assert StingerBending.from_setup(rig(1, stinger=StingerStiffness(2e6))) == []
