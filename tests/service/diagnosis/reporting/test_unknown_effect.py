"""An unknown effect in words and as a drawing."""

import pytest

from modallab.core.dof import Dof
from modallab.diagnosis.reporting.unknown_effect import MODELS, unknown_section
from modallab.diagnosis.result import CurveModelName, CurvePoint, Unknown, UnknownCause


def test_every_model_has_words() -> None:
    assert MODELS.keys() == set(CurveModelName)


@pytest.mark.parametrize(
    ("largest", "unit"), [(2e6, "MN/m"), (999.0, "N/m"), (4e4, "kN/m"), (3e-5, "µN/m"), (5e13, "GN/m")]
)
def test_axes_of_a_stiffness_have_a_prefix_that_keeps_numbers_short(largest: float, unit: str) -> None:
    unknown = Unknown(
        cause=UnknownCause.INTERNAL_FORCE,
        at=Dof(5, "Y"),
        curve=tuple(CurvePoint(f, largest * f / 20.0, 0.0, 0.01 * largest) for f in (5.0, 10.0, 20.0)),
        unit="N/m",
        curve_model=None,
        source=None,
        parameters={},
        gap_before=30.0,
        gap_after=1.1,
        held_out_gap_before=20.0,
        held_out_gap_after=1.2,
        beside_steps=False,
        rivals_alike=(),
    )
    section = unknown_section(unknown)
    assert f"real part, {unit}<" in section
    assert f"imaginary part, {unit}<" in section
