"""Measured modes as those of a model, undamped or damped."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel, Mode
from modallab.updating.target import TargetModes, as_real, complex_modes, real_modes

DOFS = (Dof(1, "Y"), Dof(2, "Y"), Dof(3, "Y"))
SHAPE = np.array([1.0, -0.4, 0.2])
MODEL = ModalModel((Mode(20.0, 0.01, SHAPE.astype(complex)),), DOFS)


@settings(max_examples=40, deadline=None)
@given(angle=st.floats(-np.pi, np.pi), bend=st.floats(0, 0.05))
def test_a_shape_turned_in_the_complex_plane_is_turned_back(angle: float, bend: float) -> None:
    complex_shape = (SHAPE + 1j * bend * np.array([0.0, 1.0, 2.0])) * np.exp(1j * angle)
    found = as_real(complex_shape[:, None])[:, 0]
    found = found * np.sign(found[0])
    # what is truly complex tilts the line through the components, and bends the real part by little
    np.testing.assert_allclose(found, SHAPE, atol=0.2 * bend + 1e-9)


def test_errors_go_along_only_if_every_mode_states_them() -> None:
    sure = replace(
        MODEL.modes[0], standard_errors={"frequency": 0.1}, shape_errors=np.array([0.01, 0.02, 0.03])
    )
    errors = real_modes(replace(MODEL, modes=(sure,))).errors
    assert errors is not None
    np.testing.assert_allclose(errors, [2 * 0.1 / 20.0, 0.01, 0.02, 0.03])
    assert real_modes(MODEL).errors is None
    assert real_modes(replace(MODEL, modes=(sure,), normalisation="none")).errors is None


@pytest.mark.parametrize(
    ("model", "field"),
    [
        (replace(MODEL, modes=()), "modal_model"),
        (replace(MODEL, modes=(Mode(0.0, 0.0, SHAPE.astype(complex)),)), "frequencies"),
        (replace(MODEL, modes=(Mode(20.0, 0.0, np.zeros(3, complex)),)), "shapes"),
        (replace(MODEL, dofs=DOFS[:2]), "shapes"),
    ],
)
@pytest.mark.parametrize("read", [real_modes, complex_modes])
def test_modes_that_no_model_can_have_are_refused(
    read: Callable[[ModalModel], TargetModes], model: ModalModel, field: str
) -> None:
    with pytest.raises(InvalidInputError) as caught:
        read(model)
    assert caught.value.context["field"] == field


def lagging(share: float, errors: float | None = None) -> ModalModel:
    """A shape of which a share is out of phase, its errors as large as told."""
    aside = np.array([0.0, 1.0, 2.0]) / np.sqrt(5)  # at right angles to the shape: no turn takes any of it
    shape = SHAPE + 1j * share / np.sqrt(1 - share**2) * np.linalg.norm(SHAPE) * aside
    stated = None if errors is None else np.full(3, errors)
    return replace(MODEL, modes=(replace(MODEL.modes[0], shape=shape, shape_errors=stated),))


def test_complex_modes_are_no_real_ones() -> None:
    real_modes(lagging(0.05))
    with pytest.raises(InvalidInputError, match="mode 1 is complex: 30% of it moves out of phase") as caught:
        real_modes(lagging(0.3))
    assert caught.value.context["field"] == "modes"


def test_what_its_own_errors_turn_a_shape_by_is_no_damping() -> None:
    # 0.2 at each of three DoFs is as much as the imaginary part, 0.34 of a shape of length 1.1
    real_modes(lagging(0.3, errors=0.2))


def test_real_modes_are_no_complex_ones() -> None:
    undamped = replace(MODEL, modes=(replace(MODEL.modes[0], loss_factor=0.0),))
    with pytest.raises(InvalidInputError, match="the modes are real") as caught:
        complex_modes(undamped)
    assert caught.value.context["field"] == "loss_factors"
    assert complex_modes(MODEL).damped  # a loss factor alone is damping too: in proportion to stiffness
    assert not real_modes(undamped).damped


def test_damped_modes_are_read_as_they_are() -> None:
    found = complex_modes(lagging(0.3))
    np.testing.assert_allclose(found.squares, (2 * np.pi * 20.0) ** 2 * (1 + 0.01j))
    np.testing.assert_array_equal(found.shapes, lagging(0.3).shapes)
    np.testing.assert_allclose(found.frequencies, [20.0])
    assert found.n_rows == 2 * (1 + 3)


def test_errors_of_damped_modes_need_those_of_loss_factors() -> None:
    known = {"frequency": 0.1, "loss_factor": 0.002}
    sure = replace(MODEL.modes[0], standard_errors=known, shape_errors=np.array([0.01, 0.02, 0.03]))
    errors = complex_modes(replace(MODEL, modes=(sure,))).errors
    assert errors is not None
    # Im lambda / omega^2 = eta: its own error, and what eta = 0.01 makes of that of omega^2, 1 %
    imaginary = np.hypot(0.002, 0.01 * 0.01)
    np.testing.assert_allclose(errors, [0.01, 0.01, 0.02, 0.03, imaginary, 0.01, 0.02, 0.03])
    unsure = replace(sure, standard_errors={"frequency": 0.1})
    assert complex_modes(replace(MODEL, modes=(unsure,))).errors is None


def test_rows_of_the_lowest_shapes_alone_are_held_dof_by_dof() -> None:
    high, low = (replace(MODEL.modes[0], frequency=f) for f in (30.0, 20.0))
    measured = replace(real_modes(replace(MODEL, modes=(high, low))), n_shapes=1)
    # two eigenvalues, then at each of three DoFs the higher mode and the lower one
    assert measured.row_mask.tolist() == [True, True, *[False, True] * 3]
    assert measured.n_rows == 5
    complex_ones = replace(complex_modes(replace(MODEL, modes=(high, low))), n_shapes=0)
    assert complex_ones.row_mask.tolist() == [True, True, *[False] * 6] * 2
    assert real_modes(MODEL).n_rows == 4
