"""Where a model parts from a measurement, as the contract shows it."""

import math
from dataclasses import asdict
from typing import Any

from modallab.diagnosis.result import Localisation


def located_out(located: Localisation) -> dict[str, Any]:
    """Return plain values; numbers that the test does not tell are null."""
    return {
        "bands": [list(band) for band in located.bands],
        "dofs": [str(dof) for dof in located.dofs],
        "modes": list(located.modes),
        "words": list(located.words),
        "signs": [sign.value for sign in located.signs],
        "mode_shifts": [_plain(asdict(one)) for one in located.mode_shifts],
        "responses": [
            _plain(asdict(one) | {"dof": str(one.dof), "course": one.course and one.course.value})
            for one in located.responses
        ],
        "level_dependence": located.level_dependence,
    }


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in values.items()
    }
