import numpy as np
import pytest
from numpy.testing import assert_allclose

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.rig.force_equilibrium import ForceEquilibrium
from modallab.rig.local_force import LinearisedForce, LocalForce

N_STEPS, N_RECORDS = 32, 5
COMPLIANCE = 1e-4  # m/N within a step


def law(stiffness: float, bend: float, *, of_velocity: bool = False) -> LocalForce:
    """A spring that saturates at motions beyond `bend`, m, or friction beyond `bend`, m/s."""
    return LocalForce(
        Dof(1, "Y"),
        lambda x: stiffness * bend * np.tanh(x / bend),
        lambda x: stiffness * (1 - np.tanh(x / bend) ** 2),
        of_velocity=of_velocity,
    )


def response(n_run: int, n_forces: int, growth: float) -> FloatArray:
    """Motions due to a force that grow with the steps after it, (n_steps, n_run, r, r)."""
    size = COMPLIANCE * (1 + growth * np.arange(N_STEPS))
    coupling = np.eye(n_forces) + 0.3
    by_run = np.array([coupling * (1 + 0.1 * run) for run in range(n_run)])
    return np.asarray(size[:, None, None, None] * by_run)


def linearised(one: LocalForce, n_run: int, n_forces: int) -> list[list[LinearisedForce]]:
    return [[one.linearised(0.01)] * n_forces] * n_run


def motions(n_run: int, n_forces: int) -> FloatArray:
    rng = np.random.default_rng(2)
    return np.asarray(0.01 * rng.standard_normal((N_STEPS, n_run, N_RECORDS, n_forces)))


@pytest.mark.parametrize(("n_run", "n_forces"), [(1, 1), (2, 1), (1, 2), (2, 3)])
@pytest.mark.parametrize("stiffness", [30.0, 3e3])  # solved for together, and where that does not converge
def test_every_force_is_in_equilibrium_with_all_motions(n_run: int, n_forces: int, stiffness: float) -> None:
    one, answer = law(stiffness, 0.004), response(n_run, n_forces, 0.05)
    runs, free = linearised(one, n_run, n_forces), motions(n_run, n_forces)
    found = ForceEquilibrium(runs, answer).forces(free, np.zeros(free.shape[1:]))
    x = free.copy()
    for t in range(N_STEPS):
        for s in range(t + 1):
            x[t] += np.einsum("nij,nkj->nki", answer[t - s], found[s])
    wanted = -(one.law(x) - one.linearised(0.01).slope * x)
    # the tolerance of the iterations, and what they would still change
    assert_allclose(found, wanted, rtol=0, atol=1e-8 * np.abs(wanted).max())


@pytest.mark.parametrize("bend", [1e-4, 1e-6, 1e-8])
def test_a_force_that_sticks_within_a_step_is_in_equilibrium(bend: float) -> None:
    """Newton steps jumped from one side of rest to the other: half the forces of dry friction were wrong."""
    one, answer = law(5.0 / bend, bend, of_velocity=True), response(1, 1, 0.0)
    runs, free = linearised(one, 1, 1), motions(1, 1)  # 5 N: 0.7 mm/s within a step, of 10 mm/s
    found = ForceEquilibrium(runs, answer).forces(free, np.zeros(free.shape[1:]))
    x = free + answer[0].item() * np.cumsum(found, axis=0)
    assert (np.abs(x) < 5 * bend).any()
    assert (np.abs(x) > 50 * bend).any()
    wanted = -(one.law(x) - one.linearised(0.01).slope * x)
    # rounding of motions of 1e-2 m, times the slope of the law; and the tolerance of the iterations
    assert_allclose(found, wanted, rtol=0, atol=2e-18 * 5.0 / bend + 1e-5)


def test_the_last_steps_of_a_record_may_be_fewer_than_a_block() -> None:
    one, answer = law(3e3, 0.004), response(1, 1, 0.01)
    runs, free = linearised(one, 1, 1), motions(1, 1)
    none = np.zeros(free.shape[1:])
    whole = ForceEquilibrium(runs, answer).forces(free, none)
    first = ForceEquilibrium(runs, answer).forces(free[:7], none)
    assert_allclose(first, whole[:7], rtol=0, atol=1e-8 * np.abs(whole).max())
