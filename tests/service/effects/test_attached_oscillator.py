"""A small resonant part: an extra degree of freedom, and Den Hartog's absorber."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.effects.attached_oscillator import AttachedOscillator
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.receptance import receptance
from modallab.fe.structure import Support
from modallab.fe.system import DynamicSystem
from modallab.rig.chain import chain
from modallab.rig.setup import AcquisitionRun
from tests.rigs import BAR, STEEL, beam_system, dofs, rig, steel_beam

SYSTEM = beam_system()
SHOT = AcquisitionRun(dofs(1), dofs(1, 7, 16))


def by_hand(
    system: DynamicSystem, at: Dof, m: float, f: float, eta: float, zeta: float, freq: FloatArray
) -> ComplexArray:
    """Receptance of nodes 1, 7, 16 to a force at 1, the oscillator a row of the matrices, line by line."""
    n, i = len(system.dofs), system.index(at)
    mass, stiffness = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1), complex)
    assert system.damping is not None
    mass[:n, :n] = system.mass.toarray()
    stiffness[:n, :n] = system.stiffness.toarray() + 1j * system.damping.toarray()
    mass[n, n] = m
    k, c = m * (2 * np.pi * f) ** 2 * (1 + 1j * eta), 2 * zeta * m * 2 * np.pi * f
    between = np.array([[1, -1], [-1, 1]])
    stiffness[np.ix_([i, n], [i, n])] += k * between
    damper = np.zeros((n + 1, n + 1), complex)
    damper[np.ix_([i, n], [i, n])] = c * between
    force = np.eye(n + 1)[:, system.index(Dof(1, "Y"))]
    rows = [system.index(dof) for dof in dofs(1, 7, 16)]
    omega = 2 * np.pi * freq
    matrices = (stiffness + 1j * w * damper - w**2 * mass for w in omega)
    return np.array([np.linalg.solve(matrix, force)[rows] for matrix in matrices])


@pytest.mark.parametrize(
    ("mass", "frequency", "loss_factor", "damping_ratio"),
    [(0.3, 65.0, 0.01, 0.0), (0.02, 300.0, 0.3, 0.0), (0.05, 120.0, 1e-3, 0.02)],
)
def test_it_is_an_extra_degree_of_freedom(
    mass: float, frequency: float, loss_factor: float, damping_ratio: float
) -> None:
    effect = AttachedOscillator(Dof(9, "Y"), mass, frequency, loss_factor, damping_ratio)
    freq = np.linspace(5.0, 800.0, 160)
    found = chain(SYSTEM, rig(1, 7, 16), [effect]).respond(freq).inertance[0, :, :, 0]
    wanted = -((2 * np.pi * freq[:, None]) ** 2) * by_hand(
        SYSTEM, Dof(9, "Y"), mass, frequency, loss_factor, damping_ratio, freq
    )
    # rounding: 1e-16 times the ratio of the beam's eigenvalues, 1e6
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def one_mass(mass_ratio: float) -> tuple[DynamicSystem, float, float]:
    """A system of one DoF, its natural frequency, Hz, and the mass of an absorber for it."""
    held = (Support(1, ("Y", "RZ")), Support(2, ("RZ",)))
    system = assemble(beam(length=0.5, n_elements=1, section=BAR, material=STEEL, supports=held))
    m, k = system.mass[0, 0], system.stiffness[0, 0]
    return system, float(np.sqrt(k / m) / (2 * np.pi)), mass_ratio * float(m)


@pytest.mark.parametrize("loss_factor", [0.05, 0.4, 1.5])
def test_a_tuned_absorbers_fixed_points_are_den_hartogs(loss_factor: float) -> None:
    """Den Hartog, Mechanical Vibrations, section 3.3: x / x_st = sqrt(1 + 2 / mu) at tuning 1 / (1 + mu)."""
    mu = 0.1
    system, own, mass = one_mass(mu)
    tuning = 1 / (1 + mu)
    effect = AttachedOscillator(Dof(2, "Y"), mass, tuning * own, loss_factor)
    # roots of g^4 - 2 g^2 (1 + (1 + mu) f^2) / (2 + mu) + 2 f^2 / (2 + mu), where damping does not matter
    half = (1 + (1 + mu) * tuning**2) / (2 + mu)
    squares = half + np.array([-1, 1]) * np.sqrt(half**2 - 2 * tuning**2 / (2 + mu))
    y = np.ones((1, 1))
    loaded = effect.on_system(system, AcquisitionRun((Dof(2, "Y"),), (Dof(2, "Y"),)))
    moved = np.abs(receptance(loaded, own * np.sqrt(squares), y, y))[:, 0, 0] * system.stiffness[0, 0]
    np.testing.assert_allclose(moved, np.sqrt(1 + 2 / mu), rtol=1e-9)  # closed form: rounding only


def test_the_structure_stands_still_at_the_oscillators_own_frequency() -> None:
    mass, frequency, loss_factor = 0.2, 180.0, 1e-5
    loaded = AttachedOscillator(Dof(9, "Y"), mass, frequency, loss_factor).on_system(SYSTEM, SHOT)
    point = SYSTEM.selection(dofs(9))
    bare, still = (abs(receptance(s, np.array([frequency]), point, point)[0, 0, 0]) for s in (SYSTEM, loaded))
    stiffness = mass * (2 * np.pi * frequency) ** 2
    # 1 / Z with Z = k (1 + i eta) / (i eta); the beam adds 1 / (Z alpha) of it
    assert still == pytest.approx(loss_factor / stiffness, rel=2 * loss_factor / stiffness / bare)


def test_below_its_frequency_it_weighs_and_above_it_stiffens() -> None:
    bare = SYSTEM.modes().elastic(8).frequencies
    frequency = 250.0  # between modes 4 and 5, at a node where all of them move
    effect = AttachedOscillator(Dof(1, "Y"), 0.05, frequency, 1e-3)
    found = effect.on_system(SYSTEM, SHOT).modes().elastic(9).frequencies
    assert (found[:4] < bare[:4]).all()
    assert found[4] == pytest.approx(frequency, rel=0.1)
    assert (found[5:] > bare[4:]).all()


def test_it_hangs_on_a_translation() -> None:
    with pytest.raises(InvalidInputError, match="5:"):
        AttachedOscillator(Dof(5, "RZ")).check(steel_beam())


def test_first_looks_lie_within_the_band() -> None:
    for top in (50.0, 5000.0):
        looks = AttachedOscillator(Dof(5, "Y")).scan_values(SYSTEM, rig(1, analyser={"frequency_max": top}))
        assert all(0 < frequency < top for frequency in looks["frequency"])


@pytest.mark.parametrize(
    ("mass", "frequency", "kind"), [(0.02, 1e5, "extra_mass"), (8.0, 3.0, "ground_spring")]
)
def test_what_it_tends_to_outside_the_band_does_the_same(mass: float, frequency: float, kind: str) -> None:
    attached = AttachedOscillator(Dof(9, "Y"), mass, frequency, loss_factor=1e-6)
    (limit,) = (effect for effect in attached.limiting_effects() if effect.kind == kind)
    freq = np.linspace(60.0, 800.0, 100)
    oscillator, alone, bare = (
        chain(SYSTEM, rig(1, 7, 16), effects).respond(freq).inertance for effects in ([attached], [limit], [])
    )
    # A line is twenty times the oscillator's frequency or more, or a hundredth of it: (1/20)^2 of its effect.
    assert np.linalg.norm(oscillator - alone) < 0.02 * np.linalg.norm(bare - alone)


def test_a_mass_beyond_the_bounds_of_an_extra_mass_is_none() -> None:
    kinds = [e.kind for e in AttachedOscillator(Dof(3, "Y"), 80.0, 3.0).limiting_effects()]
    assert kinds == ["ground_spring"]
