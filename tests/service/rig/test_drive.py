"""What stands between a source and the structure."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.progress import silent
from modallab.estimation.coherence import coherence, frf_error
from modallab.estimation.estimator import ESTIMATORS
from modallab.fe.receptance import receptance
from modallab.rig.chain import chain
from modallab.rig.drive import Drive, reaction, transmission
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Coil, Exciter, ForceTransducer, Noise
from modallab.rig.line_kernels import refined_kernel
from modallab.rig.sampled import sampled_spectra
from modallab.rig.stinger import StingerRod
from tests.rigs import beam_system, dofs, rig
from tests.shakers import Shaker, solved

SYSTEM = beam_system()
ROD = StingerRod(diameter=4e-3, length=50e-3, modulus=2.07e11, density=7850.0)
FREQ = np.linspace(3.0, 800.0, 97)
OMEGA = 2 * np.pi * FREQ
HERE, THERE = (
    Shaker(Dof(1, "Y")),
    Shaker(Dof(16, "Y", -1), 0.1, 2e4, 0.5, 4e5, 0.01, 2e7, 0.0, 12.0, 3.0, 1e-3),
)


def alpha(*points: Dof) -> ComplexArray:
    """Receptance of the drive points, (1, n_freq, n_in, n_in)."""
    columns = SYSTEM.selection(points)
    return receptance(SYSTEM, FREQ, columns, columns)[None]


def near(found: ComplexArray, wanted: ComplexArray) -> None:
    """Equal up to the rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6,
    and that of a stinger's stiffness to the beam's first."""
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def test_a_shaker_with_all_it_can_have_moves_as_the_assembled_one_with_its_current() -> None:
    forces, motions, _ = solved(SYSTEM, (HERE,), FREQ)
    found = transmission((HERE.drive,), OMEGA, alpha(HERE.dof))
    near(found[0], forces)
    moved = alpha(HERE.dof)[0] @ found[0]
    near(moved[:, 0], motions[:, SYSTEM.index(HERE.dof)])


def test_two_shakers_feel_each_other_as_assembled_together() -> None:
    pair = (replace(HERE, dof=Dof(1, "Y")), replace(THERE, dof=Dof(16, "Y")))
    forces, _, _ = solved(SYSTEM, pair, FREQ)
    found = transmission((pair[0].drive, pair[1].drive), OMEGA, alpha(pair[0].dof, pair[1].dof))
    near(found[0], forces)
    # each moves the other: the coupling is a good part of the force at resonances
    assert np.abs(forces[:, 1, 0] / forces[:, 0, 0]).max() > 0.1


def test_a_shaker_that_drives_the_other_way_is_the_same_shaker() -> None:
    there, back = (
        transmission((replace(THERE, dof=dof).drive,), OMEGA, alpha(dof))
        for dof in (THERE.dof, THERE.dof.point)
    )
    np.testing.assert_allclose(there, back, rtol=1e-12)  # rounding of a sign


def test_the_force_drops_out_at_resonances_as_in_closed_form() -> None:
    mass = 0.05
    found = expected_spectra(chain(SYSTEM, rig(1, exciter=Exciter(armature_mass=mass))))
    omega = 2 * np.pi * found.freq[1:]
    points = SYSTEM.selection(dofs(1))
    inertance = -(omega**2) * receptance(SYSTEM, found.freq[1:], points, points)[:, 0, 0]
    share = found.ff[0, 1:, 0, 0] * 800.0  # of the source's: 1 N rms over 800 Hz
    wanted = 1 / np.abs(1 + mass * inertance) ** 2  # [5.4]
    np.testing.assert_allclose(share, wanted, rtol=1e-7)  # rounding of two solutions
    assert share.min() < 0.05


def test_it_reduces_to_the_armature_of_the_thesis() -> None:
    armature = Drive(Dof(1, "Y"), 0.04)
    at_drive = alpha(armature.dof)
    wanted = 1 / (1 - 0.04 * OMEGA[:, None, None] ** 2 * at_drive)  # [5.3]
    np.testing.assert_allclose(transmission((armature,), OMEGA, at_drive), wanted, rtol=1e-13)  # rounding
    # A spring of 1e12 N/m stands against 1e6 of armature and beam, a damper of 1e-5 N s/m and a coil of
    # 1e-3 N/A against 1e2: each adds less than 1e-6.
    almost = Drive(Dof(1, "Y"), 0.04, 1e-3, 1e-5, 1e-12, 0.0, 1e-12, 0.0, (Coil(1e-3, 1.0, 1e-12),))
    np.testing.assert_allclose(transmission((almost,), OMEGA, at_drive), wanted, rtol=1e-5)


def test_no_more_power_reaches_the_structure_than_the_amplifier_gives() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        one = Shaker(
            HERE.dof, *(10.0 ** rng.uniform(-1, 1) * value for value in list(vars(HERE).values())[1:])
        )
        _, _, powers = solved(SYSTEM, (one,), FREQ)
        found = transmission((one.drive,), OMEGA, alpha(one.dof))[0, :, 0, 0]
        velocity = 1j * OMEGA * alpha(one.dof)[0, :, 0, 0] * found
        taken = 0.5 * (found * velocity.conj()).real
        assert (taken >= 0).all()
        assert (taken <= powers[:, 0] * (1 + 1e-7)).all()  # rounding of two solutions
        # with its source silent it takes power from whatever moves it, never gives
        held = reaction((one.drive,), OMEGA, np.zeros((1, len(FREQ), 1, 1), complex))
        assert (held.imag >= 0).all()


PARTS = [
    Drive(Dof(1, "Y"), 0.04),
    Drive(Dof(1, "Y"), 0.04, 8e3, 1.5),
    Drive(Dof(1, "Y"), 0.04, 8e3, 1.5, 1 / 9e5),
    Drive(Dof(1, "Y"), 0.04, 8e3, 1.5, 1 / 9e5, 0.003),
    Drive(Dof(1, "Y"), 0.04, 8e3, 1.5, 1 / 9e5, 0.003, 1 / 4e7, 0.008, (Coil(7.0, 1.5),)),
    Drive(Dof(1, "Y"), 0.04, gauge_compliance=1 / 4e5),
    Drive(Dof(1, "Y"), 0.04, compliance=1e-15),
    Drive(Dof(1, "Y"), 0.0, 8e3, compliance=1 / 9e5),
]


@pytest.mark.parametrize("drive", PARTS)
def test_the_structure_with_the_shaker_on_it_moves_as_the_shaker_lets_it(drive: Drive) -> None:
    points = SYSTEM.selection((drive.dof,))
    at_drive = alpha(drive.dof)
    wanted = at_drive - at_drive @ reaction((drive,), OMEGA, at_drive) @ at_drive
    found = receptance(drive.attached_to(SYSTEM), FREQ, points, points)
    # A rod's mass is spread linearly and a joint in front of no mass is without damping: both shift
    # resonances by 1e-5, seen where the beam's own loss is some 1e-2.
    tolerance = 1e-6 if drive.mass and not drive.stinger_mass else 5e-3
    np.testing.assert_allclose(found, wanted[0], rtol=tolerance, atol=tolerance * np.abs(wanted).max())


def test_resonances_of_beam_and_shaker_together_are_those_of_a_stinger_cut_in_pieces() -> None:
    drive, pieces = replace(HERE.drive, coils=()), 40
    n = len(SYSTEM.dofs)
    mass, stiffness = (np.zeros((n + 1 + pieces, n + 1 + pieces)) for _ in range(2))
    mass[:n, :n], stiffness[:n, :n] = SYSTEM.mass.toarray(), SYSTEM.stiffness.toarray()
    point, rod = SYSTEM.index(HERE.dof), n + np.arange(1 + pieces)
    mass[point, point] += HERE.cancelled
    mass[-1, -1] += HERE.armature
    stiffness[-1, -1] += HERE.suspension
    between = np.array([[1.0, -1.0], [-1.0, 1.0]])
    stiffness[np.ix_([point, n], [point, n])] += HERE.gauge * between
    for ends in pairwise(rod):
        stiffness[np.ix_(ends, ends)] += HERE.stinger * pieces * between
        mass[ends, ends] += HERE.rod / pieces / 2
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)
    wanted = np.sqrt(squares[squares > 1.0]) / (2 * np.pi)
    wanted = wanted[wanted < 1e3]
    found, widths = drive.attached_to(SYSTEM).resonances(800.0)
    # the stinger's mass is spread linearly, (800 Hz/8.6 kHz)^2 of its 7 % of what moves; pieces err by 1/40^2
    np.testing.assert_allclose(found[: len(wanted)], wanted, rtol=1e-4)
    assert (widths > 0).all()


@pytest.mark.parametrize("inductance", [0.0, 3e-4, 3e-2])
def test_leakage_is_integrated_as_finely_as_beam_and_shaker_together_need(inductance: float) -> None:
    exciter = Exciter("shaker", 0.05, 2e4, 3.0, Coil(7.0, 1.5, inductance), "voltage")
    setup = rig(1, 7, excitation="random", exciter=exciter, stinger=ROD, analyser={"n_lines": 201})
    bench = chain(SYSTEM, setup)
    frequencies, widths = bench.poles()
    everywhere = np.arange(0.0, 800.0, 2.0)
    finer = refined_kernel(
        setup.analyser,
        np.concatenate([frequencies.ravel(), everywhere]),
        np.concatenate([widths.ravel() / 30, np.full(len(everywhere), 0.05)]),
    )
    answer = bench.respond(finer.nodes)
    density = np.abs(answer.force[..., 0]) ** 2 / 800.0
    wanted = finer.convolve(density.astype(complex))[0, :, 0]
    # a panel errs by 2.4^-20 = 2e-8 of the largest that reaches a line
    np.testing.assert_allclose(expected_spectra(bench).ff[0, :, 0, 0], wanted, rtol=1e-6)


@pytest.mark.parametrize("excitation", ["periodic_random", "random"])
def test_records_of_a_rig_with_all_of_it_scatter_about_the_expected_spectra(excitation: str) -> None:
    averages = 200
    setup = rig(
        1,
        7,
        excitation=excitation,
        exciter=Exciter("shaker", 0.05, 2e4, 3.0, Coil(7.0, 1.5, 3e-4), "voltage"),
        stinger=ROD,
        force_transducer=ForceTransducer(0.01, mass_cancelled=True, stiffness=4e7),
        noise=Noise(1e-3, 1e-4),
        analyser={"averages": averages},
    )
    bench = chain(SYSTEM, setup)
    expected, sampled = expected_spectra(bench), sampled_spectra(bench, np.random.default_rng(7), silent)
    error = frf_error(coherence(expected), averages)
    ratio = np.abs(ESTIMATORS["h1"](sampled) / ESTIMATORS["h1"](expected))[..., 0]
    assert (np.abs(ratio - 1) < 3 * error).mean() >= 0.99  # 0.997 if normal
    assert (np.abs(sampled.ff / expected.ff - 1) < 3 / np.sqrt(averages)).mean() >= 0.99
