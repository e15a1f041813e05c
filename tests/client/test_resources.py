"""Keywords in, typed results out, one resource after the other."""

import io
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from modallab_client import ModalLab
from modallab_client.errors import UnexpectedReplyError
from modallab_client.results import (
    CatalogueEntry,
    DiscardedEntry,
    EffectSpec,
    Exciter,
    FollowUpTest,
    IterativeUpdate,
    StoredEntry,
)
from tests.client.fake import DIAGNOSIS, MEASUREMENT, MODE, UPDATE, FakeService, completed, events, npz

STRUCTURE = {"id": "s1", "n_nodes": 21, "n_dofs": 42, "members": 20, "created_at": "later"}
EXCITER: dict[str, Any] = {
    "kind": "shaker",
    "armature_mass": 0.02,
    "suspension_stiffness": 0.0,
    "suspension_damping": 0.0,
    "coil": None,
    "amplifier": "current",
}
ACCEPTED = httpx.Response(202, json={"id": "j1", "state": "queued"})


def finish(service: FakeService, result_id: str) -> None:
    service.on(
        "GET /v1/jobs/j1/events", events({"state": "succeeded", "fraction": 1, "result_id": result_id})
    )


def test_what_described_a_thing_is_sent_again(lab: ModalLab, service: FakeService) -> None:
    service.on("GET /v1/structures/s1/body", {"kind": "catalogue", "name": "bay"})
    service.on("POST /v1/structures", STRUCTURE)
    assert lab.structures.create(**lab.structures.body("s1")).id == "s1"
    assert service.body() == {"kind": "catalogue", "name": "bay"}
    service.on("GET /v1/rigs/r1/body", {"drives": ["1:+Y"], "responses": ["1:+Y"]})
    assert lab.rigs.body("r1") == {"drives": ["1:+Y"], "responses": ["1:+Y"]}


def test_a_beam_is_sent_with_the_names_of_the_contract(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/structures", STRUCTURE)
    section, material = {"area": 5e-4, "second_moment": 4.1667e-9}, {"modulus": 2.09e11, "density": 7800.0}
    beam = lab.structures.beam(length=1.5, n_elements=20, section=section, material=material)
    assert (beam.id, beam.n_nodes, beam.n_dofs, beam.members) == ("s1", 21, 42, 20)
    wanted = {"kind": "beam", "length": 1.5, "n_elements": 20, "section": section, "material": material}
    assert service.body() == wanted, "what was left out is the service's to choose"
    lab.structures.frame(nodes={"1": [0, 0]}, sections={}, materials={}, members=[], supports=[])
    assert service.body()["kind"] == "frame"
    assert service.body()["supports"] == []


def test_one_change_goes_by_keywords_and_several_as_a_list(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/structures/s1/changes", STRUCTURE)
    lab.structures.change("s1", members=[7], property="modulus", factor=1.3)
    assert service.body() == {"changes": [{"members": [7], "property": "modulus", "factor": 1.3}]}
    several = [
        {"node": 7, "property": "mass", "value": 0.05},
        {"members": [1], "property": "density", "factor": 2},
    ]
    lab.structures.change("s1", changes=several)
    assert service.body() == {"changes": several}


def test_computed_modes_come_as_arrays(lab: ModalLab, service: FakeService) -> None:
    modes = {"frequencies": [22.9, 63.2], "loss_factors": [0.0052, None], "n_rigid_body": 2}
    service.on("GET /v1/structures/s1/modes", modes)
    found = lab.structures.modes("s1", count=2)
    assert service.requests[-1].url.query == b"count=2"
    np.testing.assert_array_equal(found.frequencies, [22.9, 63.2])
    assert np.isnan(found.loss_factors[1]), "null stands for a number that is none"
    assert found.n_rigid_body == 2
    assert "22.9" in found.table()
    shapes = npz(frequencies=np.ones(2), shapes=np.ones((3, 2)), dofs=np.array(["1:+Y", "1:+RZ", "2:+Y"]))
    service.on("GET /v1/structures/s1/modes/arrays", shapes)
    assert lab.structures.mode_shapes("s1").dofs == ("1:+Y", "1:+RZ", "2:+Y")


def test_a_measurement_is_frozen_and_its_arrays_read_only(lab: ModalLab, service: FakeService) -> None:
    service.on("GET /v1/measurements/m1", {"id": "m1", "rig_id": "r1", "unheard_of": {}})
    service.on("GET /v1/measurements/m1/arrays", npz(**MEASUREMENT, unheard_of=np.ones(2)))
    test = lab.measurements.get("m1")
    assert test.values.shape == (3, 2, 1)
    assert test.outputs == ("1:+Y", "3:+Y")
    assert (test.kind, test.averages, test.rig_id) == ("inertance", 100.0, "r1")
    with pytest.raises(ValueError, match="read-only"):
        test.values[0, 0, 0] = 0
    with pytest.raises(AttributeError):
        test.kind = "mobility"  # type: ignore[misc]


def test_arrays_and_files_are_brought_in(lab: ModalLab, service: FakeService, tmp_path: Path) -> None:
    service.on("POST /v1/measurements/import", {"id": "m1"})
    service.on("GET /v1/measurements/m1", {"id": "m1"})
    service.on("GET /v1/measurements/m1/arrays", npz(**MEASUREMENT))
    lab.measurements.import_npz(
        "r1", freq=[2.0], values=[[[1j]]], outputs=["1:+Y"], inputs=["1:+Y"], kind="receptance"
    )
    sent = service.requests[0].content
    start = sent.index(b"PK\x03\x04")
    with np.load(io.BytesIO(sent[start:])) as archive:
        assert set(archive.files) == {"freq", "values", "outputs", "inputs", "kind"}
        assert archive["values"][0, 0, 0] == 1j
    (tmp_path / "frf.uff").write_bytes(b"    -1\n")
    lab.measurements.upload(tmp_path / "frf.uff", "r1")
    assert b'filename="frf.uff"' in service.requests[3].content
    assert b"averages" not in service.requests[3].content
    lab.measurements.upload(b"    -1\n", "r1", averages=94.8)
    assert b'name="averages"\r\n\r\n94.8\r\n' in service.requests[6].content
    lab.measurements.upload(b"    -1\n", window="exponential", window_end=0.3, outputs=["1:+Y", "2:+Y"])
    assert b'name="window_end"\r\n\r\n0.3\r\n' in service.requests[9].content
    assert service.requests[9].content.count(b'name="outputs"') == 2


def test_a_universal_file_comes_as_its_bytes(lab: ModalLab, service: FakeService) -> None:
    kind = {"content-type": "application/octet-stream"}
    service.on("GET /v1/measurements/m1/frf.uff", httpx.Response(200, content=b"    -1\n", headers=kind))
    assert lab.measurements.uff("m1") == b"    -1\n"
    service.on("GET /v1/modal-models/o1/modes.uff", httpx.Response(200, content=b"    -1\n", headers=kind))
    assert lab.modal_models.uff("o1") == b"    -1\n"
    service.on("GET /v1/structures/s1/geometry.uff", httpx.Response(200, content=b"    -1\n", headers=kind))
    assert lab.structures.geometry("s1") == b"    -1\n"


def test_hdf5_and_text_come_as_their_bytes(lab: ModalLab, service: FakeService) -> None:
    content, kind = b"\x89HDF\r\n\x1a\n", {"content-type": "application/octet-stream"}
    service.on("GET /v1/measurements/m1/arrays.h5", httpx.Response(200, content=content, headers=kind))
    assert lab.measurements.hdf5("m1") == content
    text = {"content-type": "text/plain; charset=utf-8"}
    service.on("GET /v1/measurements/m1/thesis.frf", httpx.Response(200, content=b"title\n", headers=text))
    assert lab.measurements.thesis("m1", decimals=16) == b"title\n"
    assert service.requests[-1].url.query == b"decimals=16"


def test_modes_are_brought_in_as_a_file(lab: ModalLab, service: FakeService, tmp_path: Path) -> None:
    about = {"id": "o1", "modes": [MODE], "method": "imported", "dofs": ["1:+Y", "2:+Y"]}
    service.on("POST /v1/modal-models/import", {"id": "o1"})
    service.on("GET /v1/modal-models/o1", about)
    arrays = npz(shapes=np.ones((2, 1), complex))
    service.on("GET /v1/modal-models/o1/arrays", arrays)
    (tmp_path / "modes.uff").write_bytes(b"    -1\n")
    modes = lab.modal_models.upload(tmp_path / "modes.uff")
    assert (modes.id, modes.dofs) == ("o1", ("1:+Y", "2:+Y"))
    assert b'filename="modes.uff"' in service.requests[0].content
    lab.modal_models.upload(b"    -1\n")
    assert b'filename="modes"' in service.requests[3].content


def test_curves_and_truth_are_read(lab: ModalLab, service: FakeService) -> None:
    one = {"output": "3:+Y", "input": "1:+Y", "values": [[1.0, 2.0], [3.0, 4.0]], "coherence": [1.0, 0.9]}
    service.on("GET /v1/measurements/m1/curves", {"freq": [2.0, 4.0], "kind": "inertance", "curves": [one]})
    curves = lab.measurements.curves("m1", points=2)
    np.testing.assert_array_equal(curves.curves[0].values, [1 + 2j, 3 + 4j])
    effect: dict[str, Any] = {"kind": "extra_mass", "at": "7:+Y", "parameters": {"mass": 0.05}}
    service.on("GET /v1/measurements/m1/truth", {"structure_id": "s1", "effects": [effect]})
    assert lab.measurements.truth("m1").effects == (EffectSpec(**effect),)


def test_a_log_is_read(lab: ModalLab, service: FakeService) -> None:
    rig = {"drives": ["1:+Y"], "responses": ["3:+Y"]}
    log = {
        "id": "m1",
        "created": "2026-01-01",
        "version": "0.1.0",
        "rig_id": "r1",
        "rig": rig,
        "averages": 100,
    }
    service.on(
        "GET /v1/measurements/m1/log", log | {"route": "drawn", "seed": 5, "libraries": {"numpy": "2"}}
    )
    read = lab.measurements.log("m1")
    assert (read.route, read.seed, read.version, read.libraries) == ("drawn", 5, "0.1.0", {"numpy": "2"})
    assert (read.rig_id, read.rig, read.averages, read.notes) == ("r1", rig, 100.0, ())


def test_a_rig_comes_back_as_declared(lab: ModalLab, service: FakeService) -> None:
    declared = {
        "drive": "1:+Y",
        "responses": ["1:+Y"],
        "exciter": EXCITER,
    }
    service.on("GET /v1/rigs/r1", {"id": "r1", **declared, "stinger": None})
    rig = lab.rigs.get("r1")
    assert (rig.drive, rig.responses) == ("1:+Y", ("1:+Y",))
    assert (rig.exciter, rig.stinger) == (Exciter(**EXCITER), None)
    service.on("POST /v1/rigs", {"id": "r2", **declared})
    lab.rigs.create(responses=rig.responses, exciter=rig.exciter)
    assert service.body()["exciter"] == EXCITER, "a part of a result may be sent"


def test_an_answer_that_is_no_npz_is_refused(lab: ModalLab, service: FakeService) -> None:
    service.on("GET /v1/measurements/m1", {"id": "m1"})
    page = httpx.Response(200, content=b"<html>", headers={"content-type": "text/html"})
    service.on("GET /v1/measurements/m1/arrays", page)
    with pytest.raises(UnexpectedReplyError, match="npz"):
        lab.measurements.get("m1")


def test_a_modal_model_tabulates_its_scatter(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/modal-models", ACCEPTED)
    finish(service, "mm1")
    model = {
        "id": "mm1",
        "modes": [MODE, {**MODE, "frequency_spread": None}],
        "method": "dobson",
        "dofs": ["1:+Y", "3:+Y"],
    }
    service.on("GET /v1/modal-models/mm1", {**model, "measurement_id": "m1"})
    service.on("GET /v1/modal-models/mm1/arrays", npz(shapes=np.ones((2, 2))))
    found = lab.modal_models.start("m1", method="dobson", bands=[(20, 26)], n_modes=1).result()
    assert service.body(0) == {"measurement_id": "m1", "method": "dobson", "bands": [[20, 26]], "n_modes": 1}
    assert found.modes[0].frequency_spread is not None
    assert found.modes[0].frequency_spread.sd == 0.05
    assert found.dofs == ("1:+Y", "3:+Y")
    head, first, *_ = found.table().splitlines()
    assert head.split() == [
        *("mode", "quantity", "value", "std", "error", "min", "max", "mean", "sd", "flags")
    ]
    assert first.split() == ["1", "frequency", "Hz", "23.610", "0.015", "23.5", "23.7", "23.61", "0.05"]


def test_known_modes_are_brought_in_with_complex_pairs(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/modal-models/import", {"id": "mm1"})
    service.on("GET /v1/modal-models/mm1", {"id": "mm1", "modes": [MODE], "dofs": ["1:+Y", "3:+Y"]})
    service.on("GET /v1/modal-models/mm1/arrays", npz(shapes=np.ones((2, 1))))
    lab.modal_models.import_(
        frequencies=[23.6], loss_factors=[0.005], shapes=[[1j], [2.0 + 0j]], dofs=["1:+Y", "3:+Y"]
    )
    mode = {"frequency": 23.6, "loss_factor": 0.005, "shape": [[0.0, 1.0], [2.0, 0.0]]}
    assert service.body(0) == {"modes": [mode], "dofs": ["1:+Y", "3:+Y"], "normalisation": "mass"}


def test_an_update_is_asked_by_keywords_and_read_by_member(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/updates", ACCEPTED)
    finish(service, "u1")
    service.on("GET /v1/updates/u1", UPDATE)
    update = lab.updates.start("s1", "mm1", macros=[[1, 2], [3]], parts=["mass"], max_iterations=30).result()
    sent = service.body(0)
    assert sent["parameterisation"] == {"macros": [[1, 2], [3]], "parts": ["mass"]}
    assert sent["options"] == {"max_iterations": 30}
    assert isinstance(update, IterativeUpdate)
    assert update.converged
    assert update.coefficients["stiffness"][11] == 2.0
    assert update.standard_errors["stiffness"][12] is None
    assert update.suspected["mass"] == (1, 2)
    np.testing.assert_array_equal(update.frequencies["measured"], [22.1, 61.0])
    assert "1.99" in update.table()
    assert update.history[0].macros[0].members == (1, 2)
    np.testing.assert_array_equal(update.history[0].coefficients, [1.6])
    lab.updates.start("s1", "mm1")
    assert set(service.body()) == {"structure_id", "modal_model_id", "method"}


def test_a_correlation_comes_at_once(lab: ModalLab, service: FakeService) -> None:
    reply = {"mac": [[1.0, 0.1]], "pairs": [[1, 1]], "frequency_differences": [0.01], "comac": [0.9]}
    service.on("POST /v1/correlations", reply)
    found = lab.correlations.create("mm1", "s1")
    assert found.mac.shape == (1, 2)
    assert found.pairs == ((1, 1),)


def test_a_diagnosis_reads_as_it_is_written_in_the_contract(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/diagnoses", ACCEPTED)
    finish(service, "d1")
    service.on("GET /v1/diagnoses/d1", DIAGNOSIS)
    frf = np.ones((3, 1, 1)) + 0j
    curves = {"freq": np.arange(3.0), "measured": frf, "before": 2 * frf, "after": frf}
    names = {"outputs": np.array(["7:+Y"]), "inputs": np.array(["1:+Y"])}
    service.on(
        "GET /v1/diagnoses/d1/arrays",
        npz(**curves, **names, random_error=frf.real, held_out=np.array([True])),
    )
    found = lab.diagnoses.start("s1", "m1", hold_out={"fraction": 0.25}, max_effects=2).result()
    assert service.body(0) == {
        "structure_id": "s1",
        "measurement_id": "m1",
        "suspects": "all",
        "hold_out": {"fraction": 0.25},
        "max_effects": 2,
        "seed": 0,
    }
    step = found.steps[0]
    assert (found.verdict, step.effect.kind, step.effect.at) == ("explained", "extra_mass", "7:+Y")
    mass = step.effect.parameters["mass"]
    assert (mass.value, mass.standard_error, mass.unit) == (0.05, 0.0004, "kg")
    assert (step.gap_before, step.gap_after) == (812.0, 1.04)
    assert step.rivals[0].at == {"members": [3]}
    assert step.rivals_alike[0].kind == "force_transducer_mass"
    assert found.located.bands == ((22.0, 24.0),)
    assert (found.remaining_gap, found.remaining_scatter, found.notes) == (1.06, 0.02, ("n",))
    assert found.next_test is not None
    assert (found.next_test.separates, found.next_test.expected_separation) == (("a", "b"), 12.5)
    assert found.follow_ups == (FollowUpTest(measurement_id="m2", changed={"drive": "5:+Y"}),)
    assert "extra mass at 7:+Y: mass 0.05000 ± 0.00040 kg" in found.table()
    assert found.curves is not None
    np.testing.assert_array_equal(found.curves.before, 2 * frf)


def test_the_catalogue_lists_what_can_be_chosen(lab: ModalLab, service: FakeService) -> None:
    mass = {"kind": "parameter", "unit": "kg", "lower": 0, "upper": 1.0, "absent": 0.0, "doc": "mass"}
    mass |= {"chosen": False}
    entry = {"kind": "extra_mass", "summary": "s", "parameters": {"mass": mass}}
    effect, method = (completed(CatalogueEntry, given) for given in (entry, {"kind": "dobson"}))
    service.on("GET /v1/catalog/effects", httpx.Response(200, json=[effect]))
    service.on("GET /v1/catalog/extraction-methods", httpx.Response(200, json=[method]))
    assert lab.catalog.effects()[0].parameters["mass"].unit == "kg"
    assert lab.catalog.extraction_methods()[0].kind == "dobson"


def test_a_list_goes_on_over_its_pages(lab: ModalLab, service: FakeService) -> None:
    first = {"id": "s2", "created": "2026-01-02", "seed": None, "made_from": {"structure_id": "s1"}}
    second = {"id": "s1", "created": "2026-01-01", "seed": 3, "made_from": {}}
    service.on("GET /v1/structures", {"items": [first], "next": "s2"}, {"items": [second], "next": None})
    service.on("DELETE /v1/structures/s1", httpx.Response(204))
    assert [entry.id for entry in lab.structures.list()] == ["s2", "s1"]
    assert service.requests[1].url.query == b"after=s2"
    lab.structures.delete("s1")


def test_what_was_deleted_is_listed_and_restored(lab: ModalLab, service: FakeService) -> None:
    entry = completed(DiscardedEntry, {"id": "s1", "kind": "structure", "until": "2026-01-02"})
    service.on("GET /v1/trash", {"items": [entry], "next": "s1"}, {"items": [], "next": None})
    service.on("POST /v1/trash/s1/restore", completed(StoredEntry, {"id": "s1"}))
    service.on("DELETE /v1/trash/s1", httpx.Response(204))
    (thing,) = lab.trash.list(owner="k1")
    assert (thing.id, thing.kind, thing.until) == ("s1", "structure", "2026-01-02")
    assert service.requests[1].url.query == b"after=s1&owner=k1"
    assert lab.trash.restore(thing).id == "s1"
    lab.trash.remove("s1")


def test_a_project_goes_through_a_file(lab: ModalLab, service: FakeService, tmp_path: Path) -> None:
    file = httpx.Response(200, content=b"PK", headers={"content-type": "application/octet-stream"})
    service.on("GET /v1/projects/export", file)
    service.on("POST /v1/projects/import", {"ids": {"s1": "s2"}, "counts": {"structure": 1}})
    path = lab.projects.download(tmp_path / "project.zip", label="autumn")
    assert (path, path.read_bytes()) == (tmp_path / "project.zip", b"PK")
    assert service.requests[0].url.query == b"label=autumn"
    stored = lab.projects.upload(path)
    assert (stored.ids, stored.counts) == ({"s1": "s2"}, {"structure": 1})
    assert b"PK" in service.requests[1].content


def test_a_description_goes_by_keywords_and_filters_lists(lab: ModalLab, service: FakeService) -> None:
    entry = completed(StoredEntry, {"id": "s1", "name": "first", "labels": ["autumn"]})
    service.on("PATCH /v1/structures/s1", entry)
    service.on("GET /v1/structures", {"items": [entry], "next": None})
    described = lab.structures.describe("s1", name="first", labels=("autumn",))
    assert (described.name, described.labels) == ("first", ("autumn",))
    assert service.body() == {"name": "first", "labels": ["autumn"]}
    assert lab.structures.list(label="autumn", name="fir") == (described,)
    assert dict(service.requests[-1].url.params) == {"label": "autumn", "name": "fir"}
