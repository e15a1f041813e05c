"""A model at some coefficients: the same whatever was solved for before, and whatever shapes a pair has."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel
from modallab.fe.assembly import Assembly
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.plate import plate
from modallab.fe.settings import EIGENSOLUTION
from modallab.fe.structure import Material
from modallab.fe.synthetic_modes import ModeNoise
from modallab.updating.method import UPDATERS
from modallab.updating.modal_residuals import Balance, ModalResiduals
from modallab.updating.parameterisation import parameterise
from modallab.updating.target import real_modes
from tests.service.updating.cases import BEAM, BEAM_DOFS, WRONG_BEAM, long_cantilever, modes_of


def test_modes_begun_from_those_of_another_model_are_the_same_modes() -> None:
    structure = long_cantilever()
    assert len(structure.dofs) >= EIGENSOLUTION.dense_dofs
    dofs = tuple(Dof(node, "Y") for node in range(11, 132, 10))
    target = real_modes(modes_of(structure, 4, dofs))
    parameters = parameterise([tuple(range(1, 14)), tuple(range(60, 80))])
    far, near = np.array([1.5, 0.7, 0.6, 1.8]), np.array([1.05, 1.0, 0.95, 1.0])

    def fit() -> ModalResiduals:
        return ModalResiduals(Assembly(structure), parameters, target, 0.3)

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


def test_rows_divided_by_the_size_of_shapes_are_as_uncertain_as_they_are_large() -> None:
    noise = ModeNoise(eigenvalue=1e-3, eigenvector=1e-2)
    target = replace(real_modes(modes_of(WRONG_BEAM, 4, BEAM_DOFS, noise, 1)), n_shapes=2)
    parameters = parameterise([(1, 2), (11, 12)])
    plain, even = (ModalResiduals(Assembly(BEAM), parameters, target, 0.3, balance=one) for one in Balance)
    of_plain, of_even = plain.state(np.ones(4)), even.state(np.ones(4))
    np.testing.assert_array_equal(of_even.size[:4], of_plain.size[:4])
    own = of_plain.basis.shapes[[BEAM.index(dof) for dof in BEAM_DOFS]][:, of_plain.modes[:2]]
    # behind the four eigenvalues two shapes, DoF by DoF
    sizes = of_even.size[4:].reshape(len(BEAM_DOFS), 2)
    np.testing.assert_allclose(sizes, np.tile(np.linalg.norm(own, axis=0), (len(sizes), 1)), rtol=1e-9)
    errors, even_errors = plain.errors(of_plain), even.errors(of_even)
    assert errors is not None
    assert even_errors is not None
    # of a number and its error alike: what is missed is as many errors as before
    np.testing.assert_allclose(
        of_even.difference / of_even.size / even_errors, of_plain.difference / of_plain.size / errors
    )


SIDE, SPACE = 6, 2  # elements a side of a square plate, whose modes come in pairs; between sensors
SQUARE = plate(
    length=0.4, width=0.4, thickness=0.004, n_elements=(SIDE, SIDE), material=Material(2.09e11, 7800.0)
)
SENSORS = tuple(
    Dof(1 + row * (SIDE + 1) + column, "Z")
    for row in range(0, SIDE + 1, SPACE)
    for column in range(0, SIDE + 1, SPACE)
)
PATCHES = [
    tuple(1 + (SPACE * row + b) * SIDE + SPACE * column + a for b in range(SPACE) for a in range(SPACE))
    for row in range(3)
    for column in range(3)
]
PAIRS = (3, 6)  # first modes of two at one frequency


def turned(model: ModalModel, degrees: float) -> ModalModel:
    """Return the same modes, those at one frequency as other shapes of their planes."""
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    modes = list(model.modes)
    for i in PAIRS:
        one, other = modes[i], modes[i + 1]
        assert other.frequency == pytest.approx(one.frequency, rel=1e-9)
        modes[i] = replace(one, shape=cos * one.shape + sin * other.shape)
        modes[i + 1] = replace(other, shape=cos * other.shape - sin * one.shape)
    return replace(model, modes=tuple(modes))


@pytest.mark.parametrize("method", ["inverse_eigensensitivity", "one_shot"])
@pytest.mark.parametrize("degrees", [0.0, 20.0, 45.0])
def test_modes_at_one_frequency_are_the_same_as_any_shapes_of_their_plane(
    method: str, degrees: float
) -> None:
    stiffer = change(SQUARE, [MemberChange(tuple(range(1, 37)), MemberProperty.MODULUS, factor=1.2)])
    target = turned(modes_of(stiffer, 10, SENSORS), degrees)
    result = UPDATERS[method](SQUARE, parameterise(PATCHES, ["stiffness"]), target)
    assert result.converged, result.stopped_because
    assert sum(result.iterations.values()) <= 4, "a path that hops between planes takes dozens"
    # exact modes: quadratic convergence below the last step's tolerance of 1e-4
    np.testing.assert_allclose(list(result.coefficients["stiffness"].values()), 1.2, atol=1e-6)
    np.testing.assert_allclose(result.mac.after, 1.0, atol=1e-9)


def test_shapes_at_one_frequency_move_as_their_plane_does() -> None:
    target = real_modes(turned(modes_of(SQUARE, 10, SENSORS), 30.0))
    fit = ModalResiduals(Assembly(SQUARE), parameterise(PATCHES, ["stiffness", "mass"]), target, 0.3)
    rng = np.random.default_rng(1)
    start, way = np.ones(18), rng.normal(size=18)
    scale = np.ones((1 + len(SENSORS), 1))
    scale[0] = target.squares.mean()
    step, paired = 1e-4, [i + k for i in PAIRS for k in (0, 1)]
    ahead, back = (fit.state(start + sign * step * way).difference for sign in (1, -1))

    def of_pairs(rows: FloatArray) -> FloatArray:
        # eigenvalues first, as one row of the shapes' size
        return (rows.reshape(-1, len(target.squares)) / scale)[:, paired]

    expected = of_pairs(fit.sensitivity(fit.state(start)) @ way)
    # central differences are off by a part of about step^2 = 1e-8 times how steeply shapes bend: 1e3 of it
    np.testing.assert_allclose(
        of_pairs(back - ahead) / (2 * step), expected, atol=1e-5 * np.abs(expected).max()
    )


def test_of_modes_that_sensors_show_alike_the_nearer_one_pairs() -> None:
    # 4 x 4 sensors see one shape of the plate's first symmetry, whichever of its modes moves
    target = real_modes(modes_of(SQUARE, 10, SENSORS))
    fit = ModalResiduals(Assembly(SQUARE), parameterise([tuple(range(1, 37))], ["stiffness"]), target, 0.3)
    for factor in (1 - 1e-9, 1 - 1e-12, 1 + 1e-12, 1 + 1e-9):
        state = fit.state(np.array([factor]))
        assert state.distance < 1e-8  # of eigenvalues that are 1e-9 off, and rounding
