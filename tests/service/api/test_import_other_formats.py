"""Import over HTTP of files that other programs wrote, with what they do not say in the form."""

import json
from typing import Any

from benchmarks.strange_cases import curves, matlab, table


def imported(service: Any, files: Any, **form: Any) -> Any:
    """Return the reply to an import."""
    parts = [("file", (name, content)) for name, content in files]
    return service.request("POST", "/v1/measurements/import", files=parts, data=form)


def test_a_matlab_file_is_imported_without_a_rig(service: Any) -> None:
    f, h = curves(n_out=3)
    form = {"unit": "g/N", "variables": json.dumps({"freq": "f", "H": "frf"}), "exciter": "hammer"}
    outputs = ["1:+Z", "2:+Z", "7:-X"]
    reply = imported(service, matlab(f=f, frf=h), outputs=outputs, inputs=["1:+Z"], averages="5", **form)
    assert reply.status_code == 201, reply.text
    body = reply.json()
    assert (body["kind"], body["outputs"], body["averages"]) == ("inertance", outputs, 5.0)
    assert [a["quantity"] for a in body["assumed"]] == ["random_error", "window", "excitation"]
    assert service.request("GET", f"/v1/measurements/{body['id']}").json()["assumed"] == body["assumed"]


def test_several_texts_make_one_test(service: Any) -> None:
    f, h = curves(n_out=2)
    names = ("wing_tip", "tail")
    files = [(f"{n}.csv", table([f, h[:, j, 0].real, h[:, j, 0].imag])) for j, n in enumerate(names)]
    reply = imported(service, files, map=json.dumps({"wing_tip": "12:+Z", "tail": "3"}))
    assert reply.status_code == 201, reply.text
    assert reply.json()["outputs"] == ["12:+Z", "3:+Z"]


def test_another_word_for_inertance_is_taken(service: Any) -> None:
    f, h = curves()
    reply = imported(service, matlab(f=f, H=h), kind="accelerance")
    assert reply.status_code == 201, reply.text
    id = reply.json()["id"]
    assert service.request("GET", f"/v1/measurements/{id}/curves?kind=accelerance").status_code == 200


def test_a_field_that_cannot_be_read_is_named_with_an_example(service: Any) -> None:
    f, h = curves()
    for field, text in (("map", "wing"), ("scale", '{"up": 2}'), ("columns", "[]"), ("unit", "kelvin")):
        reply = imported(service, matlab(f=f, H=h), **{field: text})
        assert (reply.status_code, reply.json()["context"]["field"]) == (422, field)
        assert reply.json()["context"]["allowed"]


def test_the_end_of_an_exponential_window_is_declared_beside_a_file(service: Any) -> None:
    f, h = curves(n_out=2)
    declared = {"exciter": "hammer", "window": "exponential", "averages": "5"}
    assumed = imported(service, matlab(f=f, H=h), **declared).json()
    assert "window_end" in [a["quantity"] for a in assumed["assumed"]]
    reply = imported(service, matlab(f=f, H=h), window_end="0.3", **declared)
    assert reply.status_code == 201, reply.text
    assert "window_end" not in [a["quantity"] for a in reply.json()["assumed"]]
    rig = service.get(f"/v1/rigs/{reply.json()['rig_id']}")
    assert rig["analyser"]["window_end"] == 0.3
    for end, window in (("0.3", "hann"), ("1.5", "exponential")):
        refused = imported(service, matlab(f=f, H=h), window=window, window_end=end)
        assert refused.status_code == 422
        assert refused.json()["context"]["field"].endswith("window_end")
