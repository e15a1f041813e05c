"""A point mass, held against the continuous beam that carries it."""

import numpy as np
import pytest
from scipy.optimize import brentq

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.effects.extra_mass import ExtraMass
from modallab.fe.assembly import assemble
from modallab.fe.receptance import direct_receptance
from modallab.rig.chain import chain
from modallab.rig.setup import AcquisitionRun
from tests import bernoulli
from tests.rigs import beam_system, dofs, rig, steel_beam

SHOT = AcquisitionRun(dofs(1), dofs(1))
ROOT = bernoulli.WAVE_NUMBERS * bernoulli.LENGTH


def end_mass_roots(ratio: float) -> np.ndarray:
    """Roots z of a free beam with a mass at one end, EI w''' = -m omega^2 w there.

    1 - cos z cosh z + mu z (sin z cosh z - cos z sinh z) = 0, here over cosh z.
    """

    def equation(z: float) -> float:
        return float(1 / np.cosh(z) - np.cos(z) + ratio * z * (np.sin(z) - np.cos(z) * np.tanh(z)))

    # Between those of a free and of a pinned end, for which the mass stands in at the two extremes.
    return np.array(
        [brentq(equation, (n + 0.25) * np.pi - 1e-2, (n + 0.5) * np.pi + 0.02) for n in range(1, 5)]
    )


@pytest.mark.parametrize("ratio", [0.02, 0.3, 1.5])
def test_at_an_end_of_a_free_beam_it_is_what_the_continuum_says(ratio: float) -> None:
    effect = ExtraMass(at=Dof(21, "Y"), mass=ratio * bernoulli.MASS)
    found = chain(beam_system(), rig(1), [effect]).poles()[0][0, :4]
    wanted = bernoulli.FREQUENCIES[:4] * (end_mass_roots(ratio) / ROOT[:4]) ** 2
    # Finite elements are stiff by (z/20)^4/1440: 2e-4 for z = 14.
    np.testing.assert_allclose(found, wanted, rtol=3e-4)


@pytest.mark.parametrize("node", [1, 9, 13])
def test_a_small_one_lowers_each_mode_by_half_of_mass_times_motion_squared(node: int) -> None:
    """Rayleigh, The Theory of Sound (1894), chapter IV."""
    mass = 1e-4
    bare, found = (
        chain(beam_system(), rig(1), added).poles()[0][0, :6]
        for added in ((), (ExtraMass(at=Dof(node, "Y"), mass=mass),))
    )
    phi2 = bernoulli.shapes(bernoulli.place(node)) ** 2 / bernoulli.MASS
    # Next order: a few times m phi^2, 7e-5. At the ends the sixth shape of twenty elements has a square
    # 2.4e-3 too large, which falls as (z/20)^4, z = 20.4 the wave number.
    np.testing.assert_allclose(
        found / bare - 1, -mass * phi2 / 2, rtol=0, atol=3e-3 * 2 * mass / bernoulli.MASS
    )


def test_it_loads_every_run_alike_and_the_frf_is_that_of_matrices_with_it() -> None:
    freq = np.linspace(5.0, 800.0, 40)
    mass, stiffness = bernoulli.matrices({}, {})
    damped = mass.copy()
    mass[16, 16] += 0.3  # node 9, Y
    omega = 2 * np.pi * freq[:, None, None]
    # A mass has no loss of its own: the law of damping is the members'.
    dynamic = stiffness + 1j * (100.0 * damped + 0.005 * stiffness) - omega**2 * mass
    alpha = np.linalg.inv(dynamic)[:, [0, 12], 0]
    found = chain(beam_system(), rig(1, 7), [ExtraMass(at=Dof(9, "Y"), mass=0.3)]).respond(freq).inertance
    wanted = -(omega[:, 0] ** 2) * alpha
    # rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6
    np.testing.assert_allclose(found[0, ..., 0], wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def test_added_to_the_model_it_is_a_mass_of_the_model() -> None:
    effect = ExtraMass(at=Dof(9, "Y"), mass=0.3)
    model = effect.added_to(steel_beam())
    assert [(mass.node, mass.mass) for mass in model.masses] == [(9, 0.3)]
    assert model.effects == ()
    freq, pick = np.linspace(5.0, 800.0, 40), beam_system().selection(dofs(1, 7))
    one, other = assemble(model), effect.on_system(beam_system(), SHOT).folded()
    np.testing.assert_allclose(
        direct_receptance(one, freq, pick, pick), direct_receptance(other, freq, pick, pick), rtol=1e-12
    )


def test_without_a_place_it_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="everywhere"):
        ExtraMass().check(steel_beam())
