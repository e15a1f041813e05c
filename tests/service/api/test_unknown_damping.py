"""A structure whose damping is unknown, over HTTP."""

from typing import Any

import pytest

from tests.bodies import free_beam


@pytest.mark.parametrize("damping", ["unknown", {"law": "unknown"}])
def test_unknown_damping_is_one_percent_where_a_number_is_needed(service: Any, damping: Any) -> None:
    unknown = service.post("/v1/structures", free_beam(6) | {"damping": damping})["id"]
    stated = {"law": "structural", "stiffness_coefficient": 0.01}
    known = service.post("/v1/structures", free_beam(6) | {"damping": stated})["id"]
    first, second = (service.get(f"/v1/structures/{id}/modes?count=5") for id in (unknown, known))
    assert first["loss_factors"] == second["loss_factors"]
