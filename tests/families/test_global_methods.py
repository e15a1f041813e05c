"""What every global method must do."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import InvalidInputError
from modallab.extraction.multi_mode.global_method import GLOBAL_METHODS, Poles

KINDS = sorted(GLOBAL_METHODS)
FREQ = np.arange(10.0, 110.0, 0.5)
ORDERS = np.arange(2, 17)
POLE = 2 * np.pi * np.array([-0.2 + 30j, -0.3 + 52j, -0.4 + 53j, -1.5 + 90j])  # rad/s
RNG = np.random.default_rng(8)
RESIDUE = RNG.standard_normal((4, 6)) + 1j * RNG.standard_normal((4, 6))
CLEAN = 1e12  # weight, of a variance as small as no measurement has


def response(freq: FloatArray) -> ComplexArray:
    """(n_freq, 6, 1): four poles and their conjugates."""
    s = 2j * np.pi * freq[:, None, None]
    pairs = RESIDUE / (s - POLE[:, None]) + RESIDUE.conj() / (s - POLE[:, None].conj())
    return np.asarray(pairs.sum(axis=1)[:, :, None])


def found(kind: str, frf: ComplexArray, weight: FloatArray | float = CLEAN) -> Poles:
    return GLOBAL_METHODS[kind](FREQ, frf, np.broadcast_to(weight, frf.shape), ORDERS)


def nearest(poles: Poles, order: int) -> tuple[ComplexArray, ComplexArray]:
    """Return, of the poles of an order, those nearest to the true ones, and their residues."""
    some = np.flatnonzero(poles.order == order)
    index = some[np.abs(poles.pole[some] - POLE[:, None]).argmin(axis=1)]
    return poles.pole[index], poles.vector[index]


@pytest.mark.parametrize("kind", KINDS)
def test_poles_and_residues_of_clean_data_are_the_exact_ones(kind: str) -> None:
    pole, residue = nearest(found(kind, response(FREQ)), 16)
    # of the conjugate poles, far outside the band, a polynomial of order 16 leaves some 1e-6
    np.testing.assert_allclose(pole, POLE, atol=1e-3 * np.abs(POLE.real).min())
    np.testing.assert_allclose(residue, RESIDUE, atol=1e-3 * np.abs(RESIDUE).max())


@pytest.mark.parametrize("kind", KINDS)
def test_poles_come_in_rising_order_then_frequency_and_lie_inside_the_band(kind: str) -> None:
    poles = found(kind, response(FREQ))
    assert set(poles.order.tolist()) <= set(ORDERS.tolist())
    assert (np.lexsort((poles.frequency, poles.order)) == np.arange(len(poles.order))).all()
    assert (poles.pole.real < 0).all()
    assert (poles.pole.imag >= 2 * np.pi * FREQ[0]).all()
    assert (poles.pole.imag <= 2 * np.pi * FREQ[-1]).all()
    assert poles.vector.shape == (len(poles.pole), 6)
    assert (poles.strength >= 0).all()


@pytest.mark.parametrize("kind", KINDS)
def test_units_and_gains_of_the_frfs_change_nothing_but_the_residues(kind: str) -> None:
    gain = np.array([1e-9, 3e-9, 1e-8, 2e-9, 5e-10, 1e-9])[:, None]
    as_it_is = found(kind, response(FREQ))
    scaled = found(kind, gain * response(FREQ), CLEAN / gain**2)
    some = as_it_is.strength > 100  # what fits rounding is not the same twice
    theirs = np.abs(scaled.pole - as_it_is.pole[some][:, None]).argmin(axis=1)
    # rounding of sums, in a pole whose decay rate is 1/s and more
    np.testing.assert_allclose(scaled.pole[theirs], as_it_is.pole[some], atol=1e-2)


@pytest.mark.parametrize("kind", KINDS)
def test_lines_without_weight_do_not_count(kind: str) -> None:
    frf, weight = response(FREQ), np.full((len(FREQ), 6, 1), CLEAN)
    hum = np.abs(FREQ - 50) < 0.1
    frf[hum], weight[hum] = 1e6, 0
    pole, _ = nearest(found(kind, frf, weight), 16)
    np.testing.assert_allclose(pole, POLE, atol=1e-2 * np.abs(POLE.real).min())


@pytest.mark.parametrize("kind", KINDS)
def test_an_frf_of_zeros_and_one_without_weight_do_no_harm(kind: str) -> None:
    frf, weight = response(FREQ), np.full((len(FREQ), 6, 1), CLEAN)
    frf[:, 0], weight[:, 1] = 0, 0
    pole, residue = nearest(found(kind, frf, weight), 16)
    np.testing.assert_allclose(pole, POLE, atol=1e-2 * np.abs(POLE.real).min())
    assert np.abs(residue[:, 0]).max() < 1e-6 * np.abs(residue).max()


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_at_all_has_no_poles_of_any_strength(kind: str) -> None:
    assert not (found(kind, np.zeros((len(FREQ), 6, 1), complex)).strength > 0).any()


@pytest.mark.parametrize("kind", KINDS)
def test_orders_are_of_one_set_of_sums(kind: str) -> None:
    # at one order the same, whatever others are asked for below the highest
    frf, weight = response(FREQ), np.full((len(FREQ), 6, 1), CLEAN)
    few = GLOBAL_METHODS[kind](FREQ, frf, weight, np.array([10, 16]))
    many = found(kind, frf)
    # clean data: their normal equations are exact to 1e-14 and of condition 1e6
    np.testing.assert_allclose(few.pole[few.order == 10], many.pole[many.order == 10], rtol=1e-7)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("orders", [[2, 101], [0, 4], [4, 4], []])
def test_orders_that_the_lines_cannot_tell_are_refused(kind: str, orders: list[int]) -> None:
    frf = response(FREQ)
    with pytest.raises(InvalidInputError, match="200 lines") as refused:
        GLOBAL_METHODS[kind](FREQ, frf, np.ones(frf.shape), np.array(orders, int))
    assert refused.value.context["field"] == "max_order"
