"""Model and measurement at the same degrees of freedom."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnderdeterminedError, UnknownDofError
from modallab.core.modal_model import ModalModel
from modallab.fe.reduction import REDUCTIONS
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes
from modallab.updating.direct.completion import complete
from modallab.updating.direct.method import DirectOptions
from tests.service.updating.direct.cases import BEAM, SYSTEM, measured

SENSORS = tuple(Dof(node, "Y", -1 if node % 3 else 1) for node in range(21, 2, -2))
EXACT = measured(BEAM, 5)
AT_SENSORS = synthetic_modes(SYSTEM, 5, SENSORS, noise=ModeNoise(), rng=np.random.default_rng(0))


@pytest.mark.parametrize("completion", ["expansion", *REDUCTIONS])
def test_modes_measured_everywhere_are_taken_as_they_are(completion: str) -> None:
    order = np.random.default_rng(1).permutation(len(SYSTEM.dofs))
    turned = tuple(replace(SYSTEM.dofs[i], sign=-1) for i in order)
    modes = tuple(replace(mode, shape=-mode.shape[order]) for mode in EXACT.modes[::-1])
    found = complete(SYSTEM, replace(EXACT, modes=modes, dofs=turned), DirectOptions(completion))
    assert found.dofs == SYSTEM.dofs
    np.testing.assert_array_equal(found.shapes, EXACT.shapes.real)
    np.testing.assert_allclose(found.squares, (2 * np.pi * EXACT.frequencies) ** 2)
    np.testing.assert_array_equal(found.stiffness, SYSTEM.stiffness.toarray())


def test_shapes_are_expanded_to_all_dofs() -> None:
    found = complete(SYSTEM, AT_SENSORS, DirectOptions())
    assert found.description.startswith("expanded: dynamic")
    # the model's own modes, so that the expansion at their frequencies is exact but for rounding
    np.testing.assert_allclose(found.shapes, EXACT.shapes.real, atol=1e-6 * np.abs(EXACT.shapes).max())
    assert found.notes == ()


@pytest.mark.parametrize("kind", REDUCTIONS)
def test_or_the_model_is_reduced_to_measured_dofs(kind: str) -> None:
    found = complete(SYSTEM, AT_SENSORS, DirectOptions(kind))
    assert kind in found.description
    assert found.mass.shape == (len(SENSORS), len(SENSORS))
    assert found.pattern is None
    rows = [SYSTEM.index(dof) for dof in found.dofs]
    np.testing.assert_allclose(found.shapes, EXACT.shapes.real[rows])
    given = found.problem(3)
    own = np.sqrt(given.model_squares[given.partners] / given.squares)
    exact = [2] if kind == "dynamic" else [0, 1, 2]  # the one whose frequency was taken, or all that are low
    assert given.mac[exact].min() > 0.9999
    np.testing.assert_allclose(own[exact], 1.0, atol=2e-3)


def test_the_pattern_is_where_members_connect() -> None:
    found = complete(SYSTEM, EXACT, DirectOptions())
    assert found.pattern is not None
    nodes = np.array([dof.node for dof in SYSTEM.dofs])
    np.testing.assert_array_equal(found.pattern, np.abs(nodes[:, None] - nodes) <= 1)


def test_shapes_without_a_scale_are_given_that_of_the_models_mass() -> None:
    modes = tuple(replace(mode, shape=7.0 * mode.shape) for mode in EXACT.modes)
    found = complete(SYSTEM, replace(EXACT, modes=modes, normalisation="none"), DirectOptions())
    np.testing.assert_allclose(found.shapes, EXACT.shapes.real, rtol=1e-9)  # rounding
    assert "no scale" in found.notes[-1]


def test_an_expansion_that_the_model_would_not_follow_is_told() -> None:
    jagged = np.array([(-1.0) ** i for i in range(len(SENSORS))], complex)
    modes = (replace(AT_SENSORS.modes[0], shape=jagged), *AT_SENSORS.modes[1:])
    found = complete(SYSTEM, replace(AT_SENSORS, modes=modes), DirectOptions(expansion="guyan"))
    assert found.notes[0].startswith("the model would not move as expanded in modes 1")


def rotated(model: ModalModel, angle: float) -> ModalModel:
    """Let the outer half of the second mode lag."""
    lag = np.where(np.arange(len(model.dofs)) % 2, 1.0, np.exp(1j * angle))
    second = replace(model.modes[1], shape=model.modes[1].shape * lag)
    return replace(model, modes=(model.modes[0], second, *model.modes[2:]))


@pytest.mark.parametrize(
    ("model", "options", "error", "field"),
    [
        (rotated(AT_SENSORS, 0.8), {}, InvalidInputError, "modes"),
        (replace(AT_SENSORS, dofs=(Dof(99, "Y"), *SENSORS[1:])), {}, UnknownDofError, "dof"),
        (replace(AT_SENSORS, dofs=(SENSORS[1], *SENSORS[1:])), {}, InvalidInputError, "dofs"),
        (AT_SENSORS, {"completion": "guess"}, InvalidInputError, "completion"),
        (AT_SENSORS, {"expansion": "guess"}, InvalidInputError, "expansion"),
        (AT_SENSORS, {"reduction_parameters": {"modes": 3.0}}, InvalidInputError, "reduction"),
        (replace(AT_SENSORS, modes=()), {}, InvalidInputError, "modal_model"),
    ],
)
def test_what_does_not_fit_is_refused(
    model: ModalModel, options: dict[str, Any], error: type[Exception], field: str
) -> None:
    with pytest.raises(error) as caught:
        complete(SYSTEM, model, DirectOptions(**options))
    assert getattr(caught.value, "context")["field"] == field  # noqa: B009


def test_a_little_phase_is_no_complex_mode() -> None:
    found = complete(SYSTEM, rotated(AT_SENSORS, 0.1), DirectOptions("guyan"))
    assert np.isfinite(found.shapes).all()


def test_more_modes_than_the_reduced_model_has_are_refused() -> None:
    with pytest.raises(UnderdeterminedError) as caught:
        complete(SYSTEM, AT_SENSORS, DirectOptions("serep", reduction_parameters={"modes": 3.0})).problem(5)
    assert caught.value.context == {"field": "n_modes", "value": 5, "allowed": {"maximum": 3}}


def test_what_hangs_on_a_structure_goes_along() -> None:
    heavier = SYSTEM.add_mass(7, 0.5)
    found = complete(heavier, EXACT, DirectOptions())
    row = SYSTEM.index(Dof(7, "Y"))
    assert found.mass[row, row] - SYSTEM.mass.toarray()[row, row] == pytest.approx(0.5)
    with pytest.raises(InvalidInputError, match="no shape is known") as caught:
        complete(SYSTEM.add_oscillator(Dof(7, "Y"), 0.1, 30.0, 0.0), EXACT, DirectOptions())
    assert caught.value.context["field"] == "completion"
