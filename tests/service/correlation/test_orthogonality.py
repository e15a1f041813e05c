import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.correlation.mac import mac
from modallab.correlation.orthogonality import Orthogonality, orthogonality
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.reduction import reduce, reduction_of
from modallab.fe.synthetic_modes import exact_modes
from tests.service.correlation.cases import shapes

SYSTEM = assemble(STRUCTURES["chapter-5-beam"]())
MODEL = exact_modes(SYSTEM, 6)
SENSORS = tuple(Dof(node, "Y") for node in range(1, 22, 2))
SEEN = MODEL.shapes[[SYSTEM.index(dof) for dof in SENSORS]]


@given(seed=st.integers(0, 1000), scale=st.complex_numbers(min_magnitude=1e-6, max_magnitude=1e6))
@settings(max_examples=50, deadline=None)
def test_it_does_not_see_a_complex_scale_and_never_leaves_0_to_1(seed: int, scale: complex) -> None:
    root = np.random.default_rng(seed).standard_normal((8, 8))
    mass = root @ root.T
    one, other = shapes(seed), shapes(seed + 1)
    values = orthogonality(one, other, mass)
    assert (values >= 0).all()
    assert (values <= 1).all()
    np.testing.assert_allclose(
        orthogonality(scale * one, other, mass), values, rtol=1e-9, atol=1e-12
    )  # rounding
    np.testing.assert_allclose(np.diag(orthogonality(one, scale * one, mass)), 1.0, rtol=1e-9)


def test_with_equal_masses_its_square_is_the_mac() -> None:
    one, other = shapes(3), shapes(4)
    np.testing.assert_allclose(orthogonality(one, other, 7 * np.eye(8)) ** 2, mac(one, other), rtol=1e-9)


def test_a_shape_without_mass_is_like_nothing() -> None:
    mass = np.diag([1.0, 0.0])
    assert orthogonality(np.array([[0j], [1]]), np.eye(2).astype(complex), mass).tolist() == [[0.0, 0.0]]


def test_all_dofs_and_the_whole_mass_make_modes_orthogonal() -> None:
    found = orthogonality(MODEL.shapes, MODEL.shapes, SYSTEM.mass.toarray())
    np.testing.assert_allclose(found, np.eye(6), atol=1e-9)  # rounding


@pytest.mark.parametrize(
    ("kind", "least", "most"), [("serep", 0.0, 1e-9), ("irs", 1e-5, 2e-3), ("guyan", 1e-3, 0.05)]
)
def test_the_better_the_reduction_the_nearer_its_mass_is_to_orthogonal(
    kind: str, least: float, most: float
) -> None:
    found = Orthogonality.of(reduce(SYSTEM, SENSORS, reduction_of(kind)), SEEN, SEEN, MODEL)
    # of the sixth mode, whose frequency Guyan misses by 2.6 % and IRS by 0.014 %; serep: rounding
    assert least <= np.abs(found.cross - np.eye(6)).max() < most
    np.testing.assert_allclose(found.auto, found.cross, atol=1e-12)
    assert least / 10 <= found.frequency_errors.max() < most


def test_modes_that_are_not_the_models_are_not_orthogonal_to_one_another() -> None:
    reduced = reduce(SYSTEM, SENSORS, reduction_of("serep"))
    mixed = SEEN.copy()
    mixed[:, 0] += 0.2 * SEEN[:, 1]
    found = Orthogonality.of(reduced, mixed, SEEN, MODEL)
    # of mass-normalised modes: 0.2 of the second in a shape of size sqrt(1 + 0.2^2)
    assert found.auto[0, 1] == pytest.approx(0.2 / np.sqrt(1.04), rel=1e-9)
    assert found.cross[0, 1] == pytest.approx(0.2 / np.sqrt(1.04), rel=1e-9)
    assert found.cross[0, 0] == pytest.approx(1 / np.sqrt(1.04), rel=1e-9)


def test_shapes_elsewhere_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="masters"):
        Orthogonality.of(reduce(SYSTEM, SENSORS, reduction_of("guyan")), SEEN[:5], SEEN[:5], MODEL)
