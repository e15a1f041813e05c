"""Results stand for their ids."""

import pytest

from modallab_client import ModalLab
from modallab_client.results import Structure
from modallab_client.stored import id_of
from tests.client.fake import FakeService, completed


def test_a_result_goes_where_an_id_goes(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/structures", completed(Structure, {"id": "s1"}))
    service.on("POST /v1/structures/s1/changes", completed(Structure, {"id": "s2"}))
    service.on("POST /v1/measurements", {"id": "j1", "state": "queued"})
    beam = lab.structures.catalogue("bay")
    changed = lab.structures.change(beam, members=[7], property="modulus", factor=1.3)
    lab.measurements.start(changed, "r1", seed=1)
    assert service.body()["structure_id"] == "s2"
    assert service.body()["rig_id"] == "r1"


def test_anything_else_is_refused_by_name() -> None:
    assert id_of(None) is None
    with pytest.raises(TypeError, match="not int"):
        id_of(7)  # type: ignore[call-overload]
