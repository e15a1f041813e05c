from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.modal_model import ModalModel
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.expansion import expand
from modallab.fe.reduction import reduction_of
from modallab.fe.synthetic_modes import ModeNoise, exact_modes, synthetic_modes

BEAM = STRUCTURES["chapter-5-beam"]()
SYSTEM = assemble(BEAM)
SENSORS = tuple(Dof(node, "Y", -1 if node % 3 else 1) for node in range(21, 0, -2))
EXACT = exact_modes(SYSTEM, 5)


def measured(noise: float = 0.0) -> ModalModel:
    rng = np.random.default_rng(4)
    return synthetic_modes(SYSTEM, 5, SENSORS, noise=ModeNoise(eigenvector=noise), rng=rng)


def worst(kind: str, model: ModalModel, **parameters: float) -> np.ndarray:
    """Largest error of each expanded shape over its largest entry."""
    found = expand(SYSTEM, model, reduction_of(kind, parameters)).model.shapes
    size = np.abs(EXACT.shapes).max(axis=0)
    return np.asarray(np.abs(found - EXACT.shapes).max(axis=0) / size)


@pytest.mark.parametrize("kind", ["dynamic", "serep"])
def test_shapes_of_the_model_come_back_whole_from_some_dofs_in_any_sense(kind: str) -> None:
    found = expand(SYSTEM, measured(), reduction_of(kind))
    assert found.model.dofs == SYSTEM.dofs
    np.testing.assert_array_equal(found.model.frequencies, EXACT.frequencies)
    assert (worst(kind, measured()) < 1e-7).all()  # rounding
    assert (found.residual < 1e-9).all()
    np.testing.assert_allclose(found.rayleigh, EXACT.frequencies, rtol=1e-7)


def test_slopes_by_static_curves_are_right_for_long_waves_only() -> None:
    static, improved = worst("guyan", measured()), worst("irs", measured())
    assert (np.diff(static) > 0).all()
    assert static[0] < 0.003
    assert (improved < 0.1 * static).all()
    # strain and kinetic energy of a static curve: a Rayleigh quotient lies above the frequency
    rayleigh = expand(SYSTEM, measured(), reduction_of("guyan")).rayleigh
    assert (rayleigh > EXACT.frequencies).all()


def test_a_frequency_of_its_own_is_used_for_every_mode() -> None:
    at_third = worst("dynamic", measured(), frequency=float(EXACT.frequencies[2]))
    assert at_third[2] < 1e-7  # rounding
    assert (at_third[[0, 1, 3, 4]] > 1e-4).all()


def test_complex_shapes_keep_their_phase() -> None:
    turned = replace(measured(), modes=tuple(replace(m, shape=(1 + 2j) * m.shape) for m in measured().modes))
    found = expand(SYSTEM, turned, reduction_of("serep")).model.shapes
    np.testing.assert_allclose(found, (1 + 2j) * EXACT.shapes, atol=1e-6 * np.abs(EXACT.shapes).max())


def test_what_no_mode_has_is_taken_out_and_said() -> None:
    noisy = measured(noise=0.05)
    found = expand(SYSTEM, noisy, reduction_of("serep", {"modes": 5}))
    assert (found.residual > 0.003).all()
    assert (found.residual < 0.05).all()  # the noise is uniform up to 0.05, rms 0.029
    np.testing.assert_allclose(expand(SYSTEM, noisy, reduction_of("guyan")).residual, 0.0, atol=1e-12)
    # 7 of 11 freedoms of the noise stay: the error of the sensors falls to about sqrt(7/11)
    rows = [SYSTEM.index(dof) for dof in SENSORS]
    signs = np.array([[dof.sign] for dof in SENSORS])
    after = np.linalg.norm(found.model.shapes[rows] - EXACT.shapes[rows])
    assert after < np.linalg.norm(signs * noisy.shapes - EXACT.shapes[rows])


def test_a_wrong_model_shows_in_the_residual() -> None:
    wrong = change(BEAM, [MemberChange((9, 10, 11), MemberProperty.MODULUS, factor=0.2)])
    right = expand(SYSTEM, measured(), reduction_of("serep", {"modes": 5}))
    other = expand(assemble(wrong), measured(), reduction_of("serep", {"modes": 5}))
    assert (other.residual > 1e3 * right.residual).all()
    assert other.rayleigh[0] < 0.95 * EXACT.frequencies[0]  # softer where the first mode bends most


def test_errors_of_shapes_go_along() -> None:
    noisy = measured(noise=0.05)
    found = expand(SYSTEM, noisy, reduction_of("guyan")).model.modes[1]
    row, sensor = SYSTEM.index(SENSORS[3]), 3
    assert found.shape_errors is not None
    errors = noisy.modes[1].shape_errors
    assert errors is not None
    assert found.shape_errors[row] == pytest.approx(errors[sensor])  # a master follows itself
    assert found.standard_errors == noisy.modes[1].standard_errors


def test_dofs_that_the_model_lacks_are_left_out_and_counted() -> None:
    stray = (*SENSORS[:-1], Dof(99, "Z"))
    found = expand(SYSTEM, replace(measured(), dofs=stray), reduction_of("serep")).model
    assert "1 measured degrees of freedom are none of the model's" in found.notes
    np.testing.assert_allclose(found.shapes, EXACT.shapes, atol=1e-6 * np.abs(EXACT.shapes).max())
    with pytest.raises(InvalidInputError, match="nothing was measured") as caught:
        expand(SYSTEM, replace(measured(), dofs=tuple(Dof(n, "Z") for n in range(11))), reduction_of("guyan"))
    assert caught.value.context["field"] == "dofs"
