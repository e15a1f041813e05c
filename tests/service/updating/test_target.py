"""Measured modes as real modes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel, Mode
from modallab.updating.target import as_real, real_modes

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
def test_modes_that_no_model_can_have_are_refused(model: ModalModel, field: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        real_modes(model)
    assert caught.value.context["field"] == field
