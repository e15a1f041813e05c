"""What a diagnosis located, as the client reads it."""

from typing import Any

from modallab_client._read import read_as
from modallab_client.results import Diagnosis
from tests.client.fake import completed

SHIFT = {
    "mode": 2,
    "frequency": 100.0,
    "frequency_shift": -0.004,
    "frequency_error": 2e-5,
    "loss_factor_shift": None,
    "loss_factor_error": None,
}
MISFIT = {
    "dof": "5:+Y",
    "drive": None,
    "gap": 176.0,
    "amplitude": 1.1,
    "amplitude_error": 1e-4,
    "phase": 0.0,
    "phase_error": 1e-4,
    "delay": 0.0,
    "delay_error": 1e-7,
    "course": "gain",
}
FOUND: dict[str, Any] = {
    "id": "d1",
    "verdict": "unexplained",
    "located": {
        "bands": [[22.0, 24.0]],
        "dofs": ["5:+Y"],
        "modes": [2],
        "words": ["only one response, 5:+Y, disagrees; all others agree within random error and tolerances"],
        "signs": ["one_response"],
        "mode_shifts": [SHIFT | {"of_a_later_version": 1.0}],
        "responses": [MISFIT],
        "level_dependence": 4.8,
    },
    "steps": [],
}


def test_shifts_misfits_and_signs_are_read() -> None:
    located = read_as(Diagnosis, completed(Diagnosis, FOUND)).located
    assert located.signs == ("one_response",)
    assert [vars(shift) for shift in located.mode_shifts] == [SHIFT]
    assert [vars(misfit) for misfit in located.responses] == [MISFIT]
    assert located.level_dependence == 4.8


def test_an_older_service_that_says_less_is_read_too() -> None:
    said = {"located": {"bands": [[22.0, 24.0]], "dofs": [], "modes": [1]}}
    located = read_as(Diagnosis, completed(Diagnosis, FOUND) | said).located
    assert (located.bands, located.modes) == (((22.0, 24.0),), (1,))
    assert (located.signs, located.mode_shifts, located.level_dependence) == ((), (), None)
