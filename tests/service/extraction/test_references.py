"""Modes of FRFs from several drive points, whole: what one reference cannot see, two can."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.extraction.options import Damping, ExtractionOptions
from tests.service.extraction.several_references import (
    AVERAGES,
    DOFS,
    FREQ,
    LOSS,
    PAIR,
    SHAPES,
    Driven,
    driven,
    exact,
)

MANY = tuple(Dof(node, "Y") for node in range(1, 13))
POLY = "poly_reference_lscf"


def modes_of(made: Driven, method: str = POLY, damping: Damping = Damping.STRUCTURAL) -> ModalModel:
    options = ExtractionOptions(damping=damping)
    return extract(made.frf, coherence=made.coherence, averages=AVERAGES, method=method, options=options)


def plane(shapes: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis of two shapes, (n_dof, 2)."""
    return np.asarray(np.linalg.qr(shapes)[0])


@pytest.mark.parametrize("turned", [False, True])
def test_two_references_see_both_modes_of_one_frequency_and_one_sees_one(turned: bool) -> None:
    one = modes_of(driven(0.0, (0,), turned=turned))
    assert len(one.modes) == 3
    model = modes_of(driven(0.0, turned=turned))
    assert len(model.modes) == 4
    assert model.references == DOFS[:2]
    # 60 dB: the peak's lines tell a frequency to some 1e-6
    np.testing.assert_allclose(model.frequencies, [30.0, 55.0, 55.0, 90.0], rtol=1e-5)
    np.testing.assert_allclose(model.loss_factors, LOSS, rtol=2e-3)
    # which shapes of the plane is anyone's choice, the plane is not: noise of 1e-3 leaves 1e-3 of an angle
    cosines = np.linalg.svd(plane(model.shapes[:, PAIR]).conj().T @ plane(SHAPES[PAIR].T))[1]
    assert cosines.min() > 1 - 1e-5
    assert not any("required by the fit in addition" in note for note in model.notes), (
        "a column of the chart speaks for each"
    )
    assert all(any(f.startswith("coincident: ") for f in mode.flags) for mode in model.modes[1:3])


def test_coincident_shapes_are_mass_normalised_and_real_as_those_of_the_structure() -> None:
    shapes = modes_of(driven(0.0)).shapes
    # the products that the FRFs are made of; errors of 1e-3 of the shapes
    np.testing.assert_allclose(
        shapes[:, PAIR] @ shapes[:, PAIR].T,
        SHAPES[PAIR].T @ SHAPES[PAIR],
        atol=5e-3 * np.abs(SHAPES).max() ** 2,
    )
    assert np.abs(shapes.imag).max() < 5e-3 * np.abs(shapes).max()


@pytest.mark.parametrize("gap", [0.05, 0.3])
def test_a_pair_a_small_part_of_a_bandwidth_apart_has_its_own_shapes(gap: float) -> None:
    made = driven(gap)
    model = modes_of(made)
    scores = (model.frequencies - made.frequencies) / [m.standard_errors["frequency"] for m in model.modes]
    assert np.abs(scores).max() < 4  # of four normal numbers one in 4,000 such lots
    sign = np.sign((model.shapes.real * SHAPES.T).sum(axis=0))
    errors = np.stack([np.asarray(mode.shape_errors) for mode in model.modes], axis=1)
    off = np.abs(model.shapes * sign - SHAPES.T)
    assert (off < 4 * errors).all()  # either part has that error; 24 of them
    assert (off[:, PAIR] < 0.02).all()
    assert not any("coincident" in flag for mode in model.modes for flag in mode.flags)


def test_products_place_a_close_pair_far_more_surely_than_constants_of_each_frf() -> None:
    made = driven(0.05, noise=1e-2)
    free, product = (
        np.array([mode.standard_errors["frequency"] for mode in modes_of(made, method).modes])
        for method in ("lscf", POLY)
    )
    assert (product[PAIR] < free[PAIR] / 5).all()  # a gap in frequency against a difference in shape
    np.testing.assert_allclose(product[[0, 3]], free[[0, 3]], rtol=0.1)  # modes apart gain nothing


def test_viscous_modes_of_one_frequency_are_told_apart_too() -> None:
    made = driven(0.05)
    omega = 2 * np.pi * FREQ
    own = 2 * np.pi * made.frequencies
    poles = -(omega[:, None] ** 2) / (own**2 - omega[:, None] ** 2 + 1j * LOSS * own * omega[:, None])
    values = np.einsum("fr,rj,rk->fjk", poles, SHAPES, SHAPES[:, :2])
    noise = made.frf.values - exact(0.05, (0, 1))
    frf = replace(made.frf, values=values + noise)
    model = modes_of(replace(made, frf=frf), damping=Damping.VISCOUS)
    np.testing.assert_allclose(model.frequencies, made.frequencies, rtol=1e-5)
    np.testing.assert_allclose(model.loss_factors, LOSS, rtol=2e-3)


def test_standard_errors_of_a_close_pair_are_its_scatter_over_repeated_tests() -> None:
    scores = []
    for seed in range(8):
        made = driven(0.1, noise=1e-2, seed=seed)
        model = modes_of(made)
        assert len(model.modes) == 4
        errors = [[m.standard_errors["frequency"], m.standard_errors["loss_factor"]] for m in model.modes]
        off = [model.frequencies - made.frequencies, model.loss_factors - LOSS]
        scores.append(np.array(off).T / errors)
    # 64 normal numbers: rms 1 within 0.09; a pair of 20 dB less would bring in what linear errors miss
    assert np.sqrt(np.mean(np.square(scores))) == pytest.approx(1.0, abs=0.3)


@pytest.mark.parametrize("method", ["dobson", "line_fit", "linear_fit", "circle_fit", "lscf"])
def test_other_methods_take_all_references_and_tell_how_far_their_shapes_agree(method: str) -> None:
    made = driven(12.0)  # bandwidths: two peaks
    model = modes_of(made, method)
    assert model.frfs[:3] == ("1:+Y / 1:+Y", "1:+Y / 2:+Y", "2:+Y / 1:+Y")
    assert model.modal_constant is not None
    assert model.modal_constant.shape == (4, 12)
    np.testing.assert_allclose(model.frequencies, made.frequencies, rtol=1e-3)
    sign = np.sign((model.shapes.real * SHAPES.T).sum(axis=0))
    np.testing.assert_allclose(model.shapes * sign, SHAPES.T, atol=0.05 * np.abs(SHAPES).max())
    assert model.choices["references"].startswith("1:+Y, 2:+Y: modal constants agree with one shape to ")


def test_references_that_see_two_modes_as_one_are_said_to_differ() -> None:
    model = modes_of(driven(0.0), "lscf")
    assert len(model.modes) == 3
    assert any(flag.startswith("references differ: ") for flag in model.modes[1].flags)
    assert not any("references differ" in flag for mode in model.modes[::2] for flag in mode.flags)


def test_without_noise_told_the_pair_is_found_all_the_same() -> None:
    made = driven(0.0)
    model = extract(made.frf, coherence=None, averages=1.0, method=POLY)
    np.testing.assert_allclose(model.frequencies, [30.0, 55.0, 55.0, 90.0], rtol=1e-5)


def test_more_references_than_can_be_fitted_together_are_refused_by_number() -> None:
    one = driven(0.3, (0,))
    frf = FrfSet(FREQ, one.frf.values.repeat(7, axis=2).repeat(2, axis=1), MANY, MANY[:7], one.frf.kind)
    with pytest.raises(InvalidInputError, match="few references") as refused:
        extract(frf, coherence=None, averages=1.0, method=POLY)
    assert refused.value.context["value"] == 7


def test_without_a_drive_point_among_the_responses_there_is_no_scale() -> None:
    made = driven(0.3)
    frf = replace(made.frf, values=made.frf.values[:, 2:], outputs=DOFS[2:])
    model = modes_of(replace(made, frf=frf, coherence=made.coherence[:, 2:]))
    assert model.normalisation == "none"
    assert "no response at any of the drive points 1:+Y, 2:+Y: shapes are not mass-normalised" in model.notes
