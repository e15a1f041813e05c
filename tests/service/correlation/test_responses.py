from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.correlation.responses import compare_responses
from modallab.correlation.settings import RESPONSES
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.rig.exact import exact_frf

BEAM = STRUCTURES["chapter-5-beam"]()
SYSTEM = assemble(BEAM)
DRIVE = Dof(1, "Y")
SENSORS = tuple(Dof(node, "Y", -1 if node % 3 else 1) for node in range(1, 22, 2))


def measured(
    modulus: float = 1.0, members: tuple[int, ...] = tuple(range(1, 21)), n_lines: int = 401
) -> FrfSet:
    """Return inertances of the beam with some members' modulus multiplied, 0 Hz first."""
    other = change(BEAM, [MemberChange(members, MemberProperty.MODULUS, factor=modulus)])
    return exact_frf(other, DRIVE, SENSORS, frequency_max=800.0, n_lines=n_lines)


def test_the_models_own_frfs_agree_at_every_point_and_line() -> None:
    found = compare_responses(measured(), SYSTEM)
    np.testing.assert_allclose(found.frac, 1.0, rtol=1e-9)
    np.testing.assert_allclose(np.diag(found.fdac[0]), 1.0, rtol=1e-9)
    assert (found.outputs, found.inputs) == (SENSORS, (DRIVE,))
    assert len(found.freq) == RESPONSES.plotted_lines
    assert found.freq[0] > 0
    assert found.frequency_scale == pytest.approx(1.0, abs=5e-4)  # lines 0.65 % apart, a tenth of that
    assert found.notes == ()


@pytest.mark.parametrize("kind", list(FrfKind))
def test_the_kind_of_frf_does_not_matter(kind: FrfKind) -> None:
    frf = measured().between(0.0, 800.0).to(kind)
    np.testing.assert_allclose(compare_responses(frf, SYSTEM).frac, 1.0, rtol=1e-9)


@pytest.mark.parametrize("factor", [1.44, 1.21, 0.81])
def test_the_ridge_leaves_the_diagonal_by_the_root_of_a_global_stiffness_factor(factor: float) -> None:
    found = compare_responses(measured(factor), SYSTEM)
    assert found.frequency_scale == pytest.approx(
        np.sqrt(factor), rel=1e-3
    )  # a sixth of a line of the search
    assert found.fdac_on_ridge is not None
    assert found.fdac_unscaled is not None
    assert found.fdac_on_ridge > 0.99
    assert found.fdac_unscaled < 0.9
    assert (found.frac < 0.1).all()  # no resonance is where it was, and none is wider than its shift
    # and in the picture: along that line and not along the diagonal
    lines = np.arange(50, 120)
    beside = np.abs(found.freq[lines, None] / np.sqrt(factor) - found.freq).argmin(axis=1)
    assert found.fdac[0, lines, beside].mean() > 0.97
    assert found.fdac[0, lines, lines].mean() < 0.9


def test_a_local_change_has_no_ridge_elsewhere_as_good() -> None:
    found = compare_responses(measured(0.3, (10, 11)), SYSTEM)
    assert found.fdac_on_ridge is not None
    assert found.fdac_on_ridge < 0.99
    assert found.frac.max() < 0.9


def test_points_that_the_model_lacks_are_left_out_and_counted() -> None:
    frf = measured()
    stray = replace(frf, outputs=(*SENSORS[:-1], Dof(99, "Y")))
    found = compare_responses(stray, SYSTEM)
    assert found.outputs == SENSORS[:-1]
    assert found.frac.shape == (10, 1)
    assert found.notes == ("1 measured points are none of the model's",)
    np.testing.assert_allclose(found.frac, 1.0, rtol=1e-9)


def test_every_input_has_lines_of_its_own() -> None:
    other = exact_frf(BEAM, Dof(5, "Y"), SENSORS, frequency_max=800.0, n_lines=401)
    both = replace(
        measured(),
        values=np.concatenate([measured().values, other.values], axis=2),
        inputs=(DRIVE, Dof(5, "Y")),
    )
    found = compare_responses(both, SYSTEM)
    assert found.inputs == (DRIVE, Dof(5, "Y"))
    assert found.fdac.shape == (2, RESPONSES.plotted_lines, RESPONSES.plotted_lines)
    np.testing.assert_allclose(found.frac, 1.0, rtol=1e-9)
    np.testing.assert_allclose(found.fdac[1], compare_responses(other, SYSTEM).fdac[0], rtol=1e-9)


def test_one_response_has_frac_but_no_ridge() -> None:
    frf = measured()
    alone = replace(frf, values=frf.values[:, :1], outputs=SENSORS[:1])
    found = compare_responses(alone, SYSTEM)
    assert found.frac.shape == (1, 1)
    assert found.frequency_scale is None


def test_what_cannot_be_compared_is_named() -> None:
    frf = measured()
    elsewhere = {
        "outputs": replace(frf, outputs=tuple(Dof(node, "Z") for node in range(len(SENSORS)))),
        "inputs": replace(frf, inputs=(Dof(50, "Y"),)),
        "freq": replace(frf, freq=frf.freq[:1], values=frf.values[:1]),
    }
    for field, given in elsewhere.items():
        with pytest.raises(InvalidInputError) as caught:
            compare_responses(given, SYSTEM)
        assert caught.value.context["field"] == field
