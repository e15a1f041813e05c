from dataclasses import FrozenInstanceError, dataclass

import pytest

from modallab.core.settings import Settings, setting


@dataclass(frozen=True)
class PeakSettings(Settings):
    prominence: float = setting(3.0, unit="standard errors", doc="of a peak", derived="3 sigma")


def test_a_setting_says_unit_meaning_and_origin() -> None:
    spec = PeakSettings.specs()["prominence"]
    assert (spec.unit, spec.doc, spec.derived, spec.tuned) == ("standard errors", "of a peak", "3 sigma", "")
    assert PeakSettings().prominence == 3.0


def test_settings_cannot_be_changed_in_place() -> None:
    with pytest.raises(FrozenInstanceError):
        PeakSettings().prominence = 2.0  # type: ignore[misc]


@pytest.mark.parametrize("origin", [{}, {"derived": "a", "tuned": "b"}])
def test_a_setting_has_one_origin(origin: dict[str, str]) -> None:
    with pytest.raises(ValueError, match="derived or tuned"):
        setting(1.0, doc="of nothing", **origin)
