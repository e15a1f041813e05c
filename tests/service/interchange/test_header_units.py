"""Units that the header of a text states."""

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.interchange.header_units import header_unit, hertz
from tests.reading import content_here

GRAVITY = 9.80665


def text(*names: str, rows: int = 6) -> bytes:
    lines = [",".join(str(f + 0.5 * column) for column in range(len(names))) for f in range(1, rows)]
    return "\n".join([",".join(names), *lines]).encode()


@pytest.mark.parametrize(
    ("name", "kind", "response", "force"),
    [
        ("Real [g/N]", FrfKind.INERTANCE, GRAVITY, 1.0),
        ("Real[g/N]", FrfKind.INERTANCE, GRAVITY, 1.0),
        ("Real (m/s^2)/lbf", FrfKind.INERTANCE, 1.0, 4.4482216152605),
        ("Real part ((mm/s)/N)", FrfKind.MOBILITY, 1e-3, 1.0),
        ("Magnitude, µm/N", FrfKind.RECEPTANCE, 1e-6, 1.0),
        ("Magnitude dB re 1 g/N", FrfKind.INERTANCE, GRAVITY, 1.0),
        ("H 5:+Y / 1:+Y [1/kg]", FrfKind.INERTANCE, 1.0, 1.0),
    ],
)
def test_a_unit_at_the_end_of_a_name_is_read(name: str, kind: FrfKind, response: float, force: float) -> None:
    found = header_unit([name, name]).unit
    assert found is not None
    assert found.kind is kind
    assert (found.response, found.force) == pytest.approx((response, force))


@pytest.mark.parametrize("name", ["Real", "Re(H)", "Real [dB]", "H(1,1)", "real 5:+Y/1:+Y", "Phase [deg]"])
def test_other_words_are_no_unit(name: str) -> None:
    found = header_unit([name])
    assert (found.unit, found.unclear) == (None, "")


def test_numbers_in_the_unit_of_the_header_become_si() -> None:
    read = content_here(text("f [Hz]", "Real [g/N]", "Imag [g/N]"))
    plain = content_here(text("f [Hz]", "Real", "Imag"))
    np.testing.assert_allclose(read.frf.values, GRAVITY * plain.frf.values, rtol=1e-12)  # a product
    assert "unit" in [assumption.quantity for assumption in plain.assumed]
    assert "unit" not in [assumption.quantity for assumption in read.assumed]


def test_a_line_of_units_below_the_names_is_read_too() -> None:
    names, *rows = text("freq", "re", "im").decode().splitlines()
    read = content_here("\n".join([names, "kHz,mm/N,mm/N", *rows]).encode())
    assert read.frf.kind is FrfKind.RECEPTANCE
    np.testing.assert_allclose(read.frf.freq, 1e3 * np.arange(1, 6), rtol=1e-12)
    np.testing.assert_allclose(read.frf.values[0].real, 1.5e-3, rtol=1e-12)


def test_what_the_sender_states_counts_more_than_the_header() -> None:
    given = text("f", "Real [g/N]", "Imag [g/N]")
    stated = content_here(given, unit="mm/s/N")
    assert stated.frf.kind is FrfKind.MOBILITY
    np.testing.assert_allclose(stated.frf.values[0].real, 1.5e-3, rtol=1e-12)
    # a factor to SI was meant for the numbers as they are
    scaled = content_here(given, scale=9.81)
    np.testing.assert_allclose(scaled.frf.values[0].real, 1.5 * 9.81, rtol=1e-12)
    assert scaled.frf.kind is FrfKind.INERTANCE


def test_a_unit_that_is_not_understood_is_told() -> None:
    read = content_here(text("f", "Real [V/V]", "Imag [V/V]"))
    (reason,) = [assumption.reason for assumption in read.assumed if assumption.quantity == "unit"]
    assert "[V/V]" in reason


def test_several_units_are_refused() -> None:
    given = text("f", "Real 1 [g/N]", "Imag 1", "Real 2 [m/s^2/N]", "Imag 2")
    with pytest.raises(InvalidInputError) as caught:
        content_here(given)
    assert caught.value.context["field"] == "unit"


def test_a_kind_that_contradicts_the_header_is_refused() -> None:
    with pytest.raises(InvalidInputError) as caught:
        content_here(text("f", "Real [g/N]", "Imag [g/N]"), kind=FrfKind.MOBILITY)
    assert caught.value.context["field"] == "unit"


def test_frequencies_may_be_in_other_units_than_hertz() -> None:
    assert (hertz("Frequency (kHz)"), hertz("f [Hz]"), hertz("")) == (1e3, 1.0, 1.0)
    assert hertz("omega, rad/s") == pytest.approx(1 / (2 * np.pi))
