"""Slips that the service names become Python warnings at the line that sent them."""

import warnings
from pathlib import Path

import pytest

from modallab_client import ModalLab, PlausibilityWarning
from modallab_client.results import Rig, Structure
from tests.client.fake import FakeService, completed

SLIP = {"code": "modulus", "message": "209 N/m^2 is that of no solid", "field": "modulus"}


def test_a_slip_is_warned_of_where_it_was_sent(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/structures", completed(Structure, {"id": "s1"}) | {"warnings": [SLIP]})
    with pytest.warns(PlausibilityWarning, match="modulus: 209 N/m") as caught:
        beam = lab.structures.create(kind="beam")
    assert Path(caught[0].filename) == Path(__file__)
    assert beam.warnings[0].code == "modulus"


def test_what_is_plausible_or_of_an_earlier_service_is_silent(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/rigs", {**completed(Rig, {"id": "r1"}), "warnings": []})
    without = completed(Structure, {"id": "s1"})
    del without["warnings"]
    service.on("POST /v1/structures", without)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lab.rigs.create(drive="1:+Y", responses=["1:+Y"])
        assert lab.structures.catalogue("bay").warnings == ()
