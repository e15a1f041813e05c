"""Straight lines of nonlinear forces, against a plain iteration and closed forms."""

from collections.abc import Sequence

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.friction import Friction
from modallab.effects.rattle import Rattle
from modallab.rig.equivalent_linearisation import closed_loop_receptances, equivalent_rms
from modallab.rig.local_force import LocalForce

HERE, THERE = Dof(1, "Y"), Dof(2, "Y")
OMEGA = 2 * np.pi * np.linspace(0.25, 60.0, 240)
LEVEL = 0.25 / 60.0  # N^2 a line
POLES = 2 * np.pi * np.array([10.0, 25.0, 41.0])
SHAPES = np.array([[1.0, 0.6], [0.5, -0.8], [-0.7, 0.4]])  # 1/sqrt(kg)


def structure(loss: float = 0.1) -> tuple[ComplexArray, ComplexArray]:
    """Three modes driven at the first of two DoFs, in two runs of which the second is 3 % stiffer."""
    runs = []
    for stiffer in (1.0, 1.03):
        d = POLES**2 * stiffer * (1 + 1j * loss) - OMEGA[:, None] ** 2
        runs.append(np.einsum("mr,ms,fm->frs", SHAPES, SHAPES, 1 / d))
    alpha = np.array(runs)
    return alpha[..., :1], alpha


def law(effect: CubicStiffness | Friction | Rattle) -> LocalForce:
    found = effect.on_motion()
    assert found is not None
    return found


def iterated(
    forces: Sequence[LocalForce], driven: ComplexArray, fed_back: ComplexArray, power: FloatArray
) -> FloatArray:
    """The plain way: root mean square to line to root mean square, halfway from step to step."""
    out = np.ones((len(driven), len(forces)))
    for run, rms in enumerate(out):
        rms[:] = 1e-4
        for _ in range(300):
            lines = [force.linearised(float(own)).slope for force, own in zip(forces, rms, strict=True)]
            units = [1j * OMEGA if force.of_velocity else np.ones(len(OMEGA)) for force in forces]
            z = np.array([line * unit for line, unit in zip(lines, units, strict=True)]).T
            moved = np.linalg.solve(np.eye(len(forces)) + fed_back[run] * z[:, None, :], driven[run])[..., 0]
            taken = np.abs(moved * np.array(units).T) ** 2
            rms[:] = np.sqrt(rms * np.sqrt(power @ taken))
    return out


CUBIC = CubicStiffness(HERE, 1.5e9)
RUBBING = Friction(THERE, 0.02, 1e-3)
STOPS = Rattle(THERE, 3000.0, 2e-4)


@pytest.mark.parametrize(
    "effects",
    [[CUBIC], [RUBBING], [STOPS], [CUBIC, RUBBING], [STOPS, CUBIC]],
    ids=["cubic", "friction", "rattle", "cubic and friction", "rattle and cubic"],
)
def test_the_motion_is_the_one_that_plain_iteration_settles_on(
    effects: list[CubicStiffness | Friction | Rattle],
) -> None:
    forces = [law(effect) for effect in effects]
    where = [{HERE: 0, THERE: 1}[force.dof] for force in forces]
    driven, alpha = structure()
    driven, fed_back = driven[:, :, where], alpha[:, :, where][..., where]
    power = np.full(len(OMEGA), LEVEL)
    found = equivalent_rms(forces, driven, fed_back, OMEGA, power)
    wanted = iterated(forces, driven, fed_back, power)
    np.testing.assert_allclose(found, wanted, rtol=1e-9)
    free = np.sqrt(np.einsum("f,nfr->nr", power, np.abs(driven[..., 0]) ** 2))
    moved, _ = closed_loop_receptances(forces, found, driven, fed_back, OMEGA)
    held = np.sqrt(np.einsum("f,nfr->nr", power, np.abs(moved[..., 0]) ** 2))
    assert (np.abs(held / free - 1) > 0.02).all(), "the forces hardly act: nothing was shown"


def test_where_several_motions_hold_the_least_is_found() -> None:
    """A hardly damped resonance stiffens past one line after the other of a test."""
    force, (driven, alpha) = law(CubicStiffness(HERE, 1e8)), structure(loss=1e-3)
    power = np.full(len(OMEGA), LEVEL)
    driven, fed_back = driven[:1, :, :1], alpha[:1, :, :1, :1]
    (found,) = equivalent_rms([force], driven, fed_back, OMEGA, power)[0]
    supposed = found * np.geomspace(0.1, 10.0, 4001)
    k = 3 * 1e8 * supposed[:, None] ** 2
    allowed = np.sqrt((np.abs(driven[0, :, 0, 0] / (1 + fed_back[0, :, 0, 0] * k)) ** 2) @ power)
    crossings = supposed[:-1][np.diff(np.sign(allowed - supposed)) != 0]
    assert len(crossings) >= 3, "only one motion holds: nothing was shown"
    np.testing.assert_allclose(found, crossings[0], rtol=2e-3)  # a step of the table is 1.2e-3


@pytest.mark.parametrize("stiffness", [1e-3, 1e24])
def test_hardly_any_force_and_one_that_stops_all_motion_are_found_as_well(stiffness: float) -> None:
    force, (driven, alpha) = law(CubicStiffness(HERE, stiffness)), structure()
    driven, fed_back, power = driven[:, :, :1], alpha[:, :, :1, :1], np.full(len(OMEGA), LEVEL)
    rms = equivalent_rms([force], driven, fed_back, OMEGA, power)
    moved, _ = closed_loop_receptances([force], rms, driven, fed_back, OMEGA)
    # sums over lines, of numbers that may differ by as much as stiffness turns them: rounding
    np.testing.assert_allclose(np.sqrt(power @ np.abs(moved[:, :, 0, 0].T) ** 2), rms[:, 0], rtol=1e-8)


def test_a_force_that_nothing_drives_has_no_motion() -> None:
    driven, alpha = structure()
    still = np.array([1.0, 0.0])[:, None, None, None]  # the second run is not driven at all
    power = np.full(len(OMEGA), LEVEL)
    forces = [law(CUBIC), law(RUBBING)]
    rms = equivalent_rms(forces, driven * still, alpha, OMEGA, power)
    np.testing.assert_allclose(rms[0], equivalent_rms(forces, driven, alpha, OMEGA, power)[0], rtol=1e-9)
    assert (rms[1] == 0).all()
    assert (closed_loop_receptances(forces, rms, driven * still, alpha, OMEGA)[0][1] == 0).all()
