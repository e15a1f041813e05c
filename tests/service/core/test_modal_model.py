"""Modes: eigenvalues, and tables over a set of them."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel, Mode

MODES = tuple(Mode(f, eta, np.array([f, 1j])) for f, eta in ((10.0, 0.01), (20.0, 0.02), (40.0, 0.005)))


def test_an_eigenvalue_holds_frequency_and_loss_factor() -> None:
    value = MODES[1].eigenvalue
    assert np.sqrt(value.real) / (2 * np.pi) == pytest.approx(20.0)
    assert value.imag / value.real == pytest.approx(0.02)


def test_a_model_lists_its_modes_as_columns() -> None:
    model = ModalModel(MODES, (Dof(1, "Y"), Dof(2, "Y")))
    assert model.frequencies.tolist() == [10.0, 20.0, 40.0]
    assert model.loss_factors.tolist() == [0.01, 0.02, 0.005]
    assert model.shapes[:, 2].tolist() == [40.0, 1j]


def test_shape_errors_must_fit_their_shape() -> None:
    with pytest.raises(InvalidInputError) as caught:
        Mode(10.0, 0.01, np.array([1.0, 2.0 + 0j]), shape_errors=np.array([0.1]))
    assert caught.value.context["field"] == "shape_errors"
