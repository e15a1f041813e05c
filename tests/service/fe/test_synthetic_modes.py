"""A few modes of a structure, and measured sets made of them."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnknownDofError
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.structure import Material, Section
from modallab.fe.synthetic_modes import Distribution, ModeNoise, lowest_modes, synthetic_modes

BAY = STRUCTURES["bay"]()
DOFS = (Dof(1, "X"), Dof(5, "Y", -1), Dof(13, "X"))


def draw(noise: ModeNoise, seed: int = 0, count: int = 10) -> np.ndarray:
    return synthetic_modes(assemble(BAY), count, DOFS, noise=noise, rng=np.random.default_rng(seed)).shapes


def test_modes_without_noise_are_those_of_the_structure_in_the_sensors_sense() -> None:
    model = synthetic_modes(assemble(BAY), 5, DOFS, noise=ModeNoise(), rng=np.random.default_rng(0))
    basis, n_rigid = lowest_modes(assemble(BAY), 5)
    np.testing.assert_allclose(model.frequencies, basis.frequencies, rtol=1e-12)
    np.testing.assert_allclose(model.shapes[1], -basis.shapes[BAY.index(DOFS[1])], rtol=1e-12)
    assert n_rigid == 3
    assert model.modes[0].standard_errors == {}


@pytest.mark.parametrize("distribution", Distribution)
def test_noise_scatters_as_its_standard_error_says(distribution: Distribution) -> None:
    noise = ModeNoise(eigenvalue=0.01, eigenvector=0.05, distribution=distribution)
    exact = draw(ModeNoise())
    ratios = np.concatenate([(draw(noise, seed) / exact).real.ravel() - 1 for seed in range(40)])
    # 1200 draws: their scatter is known to 1/sqrt(2400) = 2 %, three of these
    assert ratios.std() == pytest.approx(noise.standard_error(0.05), rel=0.06)
    if distribution is Distribution.UNIFORM:
        assert np.abs(ratios).max() <= 0.05 * (1 + 1e-9)
    mode = synthetic_modes(assemble(BAY), 2, DOFS, noise=noise, rng=np.random.default_rng(1)).modes[0]
    assert mode.standard_errors["frequency"] == pytest.approx(noise.standard_error(0.01) / 2 * mode.frequency)


def test_the_same_seed_is_the_same_test() -> None:
    noise = ModeNoise(0.01, 0.05)
    np.testing.assert_array_equal(draw(noise, 3), draw(noise, 3))
    assert (draw(noise, 3) != draw(noise, 4)).any()


def test_a_large_structure_is_solved_until_there_are_enough_modes() -> None:
    fine = beam(
        length=1.5,
        n_elements=EIGENSOLUTION.dense_dofs,
        section=Section(5e-4, 4.1667e-9),
        material=Material(2.09e11, 7800.0),
    )
    coarse = lowest_modes(assemble(STRUCTURES["chapter-5-beam"]()), 8)[0].frequencies
    # twenty elements are right to (beta h)^4/1440, at mode 8 (26.7/20)^4/1440 = 2.2e-3
    np.testing.assert_allclose(lowest_modes(assemble(fine), 8)[0].frequencies, coarse, rtol=2.5e-3)


def test_what_cannot_be_drawn_is_refused() -> None:
    with pytest.raises(InvalidInputError):
        ModeNoise(eigenvalue=-0.1)
    with pytest.raises(InvalidInputError):
        lowest_modes(assemble(BAY), 0)
    with pytest.raises(UnknownDofError):
        synthetic_modes(assemble(BAY), 2, (Dof(99, "X"),), noise=ModeNoise(), rng=np.random.default_rng(0))
