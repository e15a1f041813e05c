"""A large model at some coefficients is the same whatever it was solved for before."""

import numpy as np

from modallab.core.dof import Dof
from modallab.fe.assembly import Assembly
from modallab.fe.system import SMALL
from modallab.updating.fit import Fit
from modallab.updating.parameterisation import parameterise
from modallab.updating.target import real_modes
from tests.service.updating.cases import long_cantilever, modes_of


def test_modes_begun_from_those_of_another_model_are_the_same_modes() -> None:
    structure = long_cantilever()
    assert len(structure.dofs) >= SMALL
    dofs = tuple(Dof(node, "Y") for node in range(11, 132, 10))
    target = real_modes(modes_of(structure, 4, dofs))
    parameters = parameterise([tuple(range(1, 14)), tuple(range(60, 80))])
    far, near = np.array([1.5, 0.7, 0.6, 1.8]), np.array([1.05, 1.0, 0.95, 1.0])

    def fit() -> Fit:
        return Fit(Assembly(structure), parameters, target, 0.3)

    fresh, used = fit(), fit()
    used.state(far)
    once, again = fresh.state(near), used.state(near)
    # iterated for to 1e-12 of an eigenvalue of the inverse, and rounding of its factors
    np.testing.assert_allclose(again.frequencies, once.frequencies, rtol=1e-9)
    # either solution may hold a mode upside down
    differences, again_differences = np.abs(once.difference), np.abs(again.difference)
    np.testing.assert_allclose(again_differences / again.size, differences / once.size, atol=1e-8)
    slopes = np.abs(fresh.sensitivity(once)) / once.size[:, None]
    again_slopes = np.abs(used.sensitivity(again)) / again.size[:, None]
    np.testing.assert_allclose(again_slopes, slopes, atol=1e-7 * slopes.max())
