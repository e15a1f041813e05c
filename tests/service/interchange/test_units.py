"""Units of FRFs in words: factors to SI, and what is no unit of an FRF."""

import pytest

from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind
from modallab.interchange.units import SI, frf_unit

GRAVITY, POUND_FORCE = 9.80665, 4.4482216152605  # exact by definition
INERTANCE, MOBILITY, RECEPTANCE = FrfKind.INERTANCE, FrfKind.MOBILITY, FrfKind.RECEPTANCE


@pytest.mark.parametrize(
    ("text", "kind", "factor"),
    [
        ("g/N", INERTANCE, GRAVITY),
        ("(m/s^2)/lbf", INERTANCE, 1 / POUND_FORCE),
        ("m/s²/N", INERTANCE, 1.0),
        ("m s^-2 / N", INERTANCE, 1.0),
        ("m*s**(-2)/kN", INERTANCE, 1e-3),
        ("(m/s2)/N", INERTANCE, 1.0),
        ("g/lbf", INERTANCE, GRAVITY / POUND_FORCE),
        ("1/kg", INERTANCE, 1.0),
        ("mm/s/N", MOBILITY, 1e-3),
        ("ips/lbf", MOBILITY, 0.0254 / POUND_FORCE),
        ("in/lbf", RECEPTANCE, 0.0254 / POUND_FORCE),
        ("µm/N", RECEPTANCE, 1e-6),
        *((text, kind, 1.0) for kind, text in SI.items()),
    ],
)
def test_a_motion_per_force_has_its_kind_and_factor(text: str, kind: FrfKind, factor: float) -> None:
    unit = frf_unit(text)
    assert unit.kind is kind
    assert unit.response / unit.force == pytest.approx(factor, rel=1e-12)  # a few products


@pytest.mark.parametrize(
    "text", ["", "g", "N/m", "m/s^2", "g/kelvin", "(g/N", "g/N)", "dB", "g//N", "m/s^2 N", "x" * 1000]
)
def test_what_is_no_motion_per_force_is_refused(text: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        frf_unit(text)
    assert caught.value.context["field"] == "unit"
