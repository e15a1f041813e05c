"""What makes no sense is refused by a problem that names it, and never by a fault of the service."""

import io
import json
import zipfile
from collections.abc import AsyncIterator
from typing import Any

import numpy as np
import pytest

BEAM = {
    "kind": "beam",
    "length": 1.5,
    "n_elements": 4,
    "section": {"area": 5e-4, "second_moment": 4.1667e-9},
    "material": {"modulus": 2.09e11, "density": 7800.0},
}
APART = {
    "kind": "frame",
    "nodes": {"1": [0, 0], "2": [1, 0], "3": [5, 0], "4": [6, 0]},
    "sections": {"bar": BEAM["section"]},
    "materials": {"steel": BEAM["material"]},
    "members": [
        {"number": 1, "nodes": [1, 2], "section": "bar", "material": "steel"},
        {"number": 2, "nodes": [3, 4], "section": "bar", "material": "steel"},
    ],
}
HELD = [{"node": n, "directions": ["Y", "RZ"]} for n in range(1, 6)]
RIG = {"drive": "1:+Y", "responses": ["1:+Y"]}


def refusal(reply: Any, status: int, code: str) -> Any:
    """Return the problem document, which must have this status and code."""
    problem = reply.json()
    assert reply.headers["content-type"] == "application/problem+json"
    assert (reply.status_code, problem["status"], problem["code"]) == (status, status, code), problem
    assert {"type", "title", "detail", "context"} <= set(problem)
    return problem


STRUCTURES = {
    "negative section": (BEAM | {"section": {"area": -5e-4, "second_moment": 1e-9}}, "structure", "area"),
    "disconnected frame": (APART, "structure", "members"),
    "supports hold every DoF": (BEAM | {"supports": HELD}, "structure", "supports"),
    "unknown section": (APART | {"sections": {}}, "structure", "members.section"),
    "support at no node": (BEAM | {"supports": [{"node": 99, "directions": ["Y"]}]}, "structure", "supports"),
    "spring at no DoF": (BEAM | {"springs": [{"dof": "9:+Y", "stiffness": 1.0}]}, "unknown_dof", "dof"),
    "no DoF at all": (BEAM | {"springs": [{"dof": "here", "stiffness": 1.0}]}, "invalid_input", "dof"),
    "unknown name": ({"kind": "catalogue", "name": "bridge"}, "invalid_input", "structure"),
    "unknown effect": (BEAM | {"effects": [{"kind": "ghost"}]}, "invalid_input", "effect"),
    "effect at no DoF": (BEAM | {"effects": [{"kind": "extra_mass", "at": "9:+Y"}]}, "unknown_dof", "dof"),
    "effect at no member": (
        BEAM | {"effects": [{"kind": "density_error", "at": {"members": [9]}}]},
        "invalid_input",
        "members",
    ),
    "a million elements": (BEAM | {"n_elements": 10**6}, "invalid_request", "body.beam.n_elements"),
    "unknown field": (BEAM | {"colour": "red"}, "invalid_request", "body.beam.colour"),
    "unknown kind": ({"kind": "shell"}, "invalid_request", "body"),
    "one node twice": (
        APART | {"nodes": {"1": [0, 0], "01": [1, 0]}},
        "invalid_request",
        "body.frame.nodes.01.[key]",
    ),
    "yes for a length": (BEAM | {"length": True}, "invalid_request", "body.beam.length"),
    "a word for a count": (BEAM | {"n_elements": "4"}, "invalid_request", "body.beam.n_elements"),
    "not finite": (BEAM | {"length": float("inf")}, "invalid_request", "body.beam.length"),
}


@pytest.mark.parametrize("case", STRUCTURES)
def test_a_structure_without_sense_is_refused(service: Any, case: str) -> None:
    body, code, field = STRUCTURES[case]
    reply = service.request("POST", "/v1/structures", content=_json(body), headers=_JSON)
    assert refusal(reply, 422, code)["context"]["field"] == field


RIGS: dict[str, tuple[dict[str, Any], str, str]] = {
    "zero averages": ({"analyser": {"averages": 0}}, "invalid_input", "averages"),
    "too many lines": ({"analyser": {"n_lines": 10**9}}, "invalid_input", "n_lines"),
    "lines beyond 64 bits": ({"analyser": {"n_lines": 10**30}}, "invalid_request", "body.analyser.n_lines"),
    "unknown window": ({"analyser": {"window": "round"}}, "invalid_input", "window"),
    "unknown estimator": ({"analyser": {"estimator": "h9"}}, "invalid_input", "estimator"),
    "unknown excitation": ({"analyser": {"excitation": {"kind": "whistle"}}}, "invalid_input", "excitation"),
    "drive without a form": ({"drive": "5"}, "invalid_input", "drive"),
    "digits of another script": ({"drive": "\u0661:+Y"}, "invalid_input", "drive"),
    "a force along a rotation": ({"drive": "1:+RZ"}, "invalid_input", "drive"),
    "negative mass": ({"accelerometers": {"mass": -0.1}}, "invalid_input", "accelerometers.mass"),
    "unknown mounting": (
        {"accelerometers": {"mounting": "glue"}},
        "invalid_request",
        "body.accelerometers.mounting",
    ),
    "an accelerometer that rings at once": (
        {"accelerometers": {"mounted_frequency": 0.0}},
        "invalid_input",
        "accelerometers.mounted_frequency",
    ),
    "a mass that is added instead": (
        {"analyser": {"mass_cancellation": -0.1}},
        "invalid_input",
        "mass_cancellation",
    ),
    "a high-pass of no frequency": (
        {"analyser": {"coupling_frequency": -1.0}},
        "invalid_input",
        "coupling_frequency",
    ),
    "no response": ({"responses": []}, "invalid_request", "body.responses"),
    "a window that cuts off a signal that goes on": (
        {"analyser": {"window": "force_exponential"}},
        "invalid_input",
        "analyser.window",
    ),
    "a window that never falls": ({"analyser": {"window_end": 1.0}}, "invalid_input", "window_end"),
    "a burst longer than the record": (
        {"analyser": {"excitation": {"kind": "burst_random", "burst": 1.5}}},
        "invalid_input",
        "excitation.burst",
    ),
    "a tip without stiffness": (
        {"analyser": {"excitation": {"kind": "impact", "tip_stiffness": 0}}},
        "invalid_input",
        "excitation.tip_stiffness",
    ),
    "a hammer that hums": (
        {"exciter": {"kind": "hammer"}, "analyser": {"excitation": {"kind": "random"}}},
        "invalid_input",
        "excitation.kind",
    ),
    "a hammer with an armature": (
        {"exciter": {"kind": "hammer", "armature_mass": 0.02}},
        "invalid_input",
        "exciter.armature_mass",
    ),
    "a hammer with a coil": (
        {"exciter": {"kind": "hammer", "coil": {"force_factor": 10.0, "resistance": 1.0}}},
        "invalid_input",
        "exciter.coil",
    ),
    "a hammer that leaves its gauge": (
        {"exciter": {"kind": "hammer"}, "force_transducer": {"mass_below": 0.01}},
        "invalid_input",
        "force_transducer",
    ),
    "a hammer on a stinger": (
        {"exciter": {"kind": "hammer"}, "stinger": {"axial_stiffness": 2e6}},
        "invalid_input",
        "stinger",
    ),
    "shakers that all play the same": (
        {"drive": None, "drives": ["1:+Y", "5:+Y"], "analyser": {"excitation": {"kind": "chirp"}}},
        "invalid_input",
        "excitation.kind",
    ),
}


@pytest.mark.parametrize("case", RIGS)
def test_a_rig_without_sense_is_refused(service: Any, case: str) -> None:
    body, code, field = RIGS[case]
    reply = service.request("POST", "/v1/rigs", json=RIG | body)
    assert refusal(reply, 422, code)["context"]["field"] == field


@pytest.mark.parametrize("where", [{"drive": "99:+Y"}, {"responses": ["1:+Y", "2:+X"]}])
def test_a_rig_that_does_not_fit_the_structure_is_refused_before_the_work(
    service: Any, beam: str, where: Any
) -> None:
    rig = service.post("/v1/rigs", RIG | where)["id"]
    reply = service.request("POST", "/v1/measurements", json={"structure_id": beam, "rig_id": rig})
    assert refusal(reply, 422, "unknown_dof")["context"]["value"] in ("99:+Y", "2:+X")


@pytest.mark.parametrize(
    "effect",
    [
        {"kind": "extra_mass", "at": "7:+Y", "parameters": {"mass": -1.0}},
        {"kind": "extra_mass", "at": "7:+Y", "parameters": {"weight": 1.0}},
        {"kind": "ghost"},
        {"kind": "extra_mass", "at": "somewhere"},
        {"kind": "extra_mass"},
        {"kind": "extra_mass", "at": {"members": [1]}},
        {"kind": "stiffness_error", "at": {"members": [99]}},
        {"kind": "response_noise", "at": {"channels": ["1:+Y"]}},
        {"kind": "exciter_armature", "at": "7:+Y"},
        {"kind": "gain_error", "at": "7:+Y"},
        {"kind": "polarity", "at": {"channels": ["20:+Y"]}},
        {"kind": "swapped_channels"},
        {"kind": "swapped_channels", "at": {"channels": ["1:+Y"]}},
        {"kind": "transverse_sensitivity", "at": {"channels": ["1:+Y"]}},
    ],
)
def test_an_effect_without_sense_is_refused_before_the_work(
    service: Any, beam: str, rig: str, effect: Any
) -> None:
    body = {"structure_id": beam, "rig_id": rig, "effects": [effect]}
    refusal(service.request("POST", "/v1/measurements", json=body), 422, "invalid_input")


@pytest.mark.parametrize("wrong", [{"modulus": -0.1}, {"modal_loss_factor": 2.0}, {"length": 0.1}])
def test_a_tolerance_without_sense_is_refused_by_name(service: Any, wrong: dict[str, float]) -> None:
    body = {"structure_id": "none", "measurement_id": "none", "tolerances": wrong}
    problem = refusal(service.request("POST", "/v1/diagnoses", json=body), 422, "invalid_request")
    (name,) = wrong
    assert problem["context"]["field"] == f"body.tolerances.{name}"


def test_a_preset_that_does_not_exist_is_refused_with_the_names_of_those_that_do(service: Any) -> None:
    body = {"structure_id": "none", "measurement_id": "none", "tolerances": "strict"}
    problem = refusal(service.request("POST", "/v1/diagnoses", json=body), 422, "invalid_request")
    assert problem["context"]["field"] == "body.tolerances"
    assert "ordinary" in str(problem["context"]["allowed"])


def test_a_band_without_a_mode_fails_the_job_by_name(service: Any, beam: str, rig: str) -> None:
    test = service.result_of("/v1/measurements", {"structure_id": beam, "rig_id": rig, "route": "expected"})
    body = {"measurement_id": test, "bands": [[90.0, 105.0]]}
    job = service.post("/v1/modal-models", body, status=202)
    assert job["state"] == "failed"
    assert (job["error"]["status"], job["error"]["code"]) == (422, "no_mode_in_band")
    assert job["result_id"] is None


EXTRACTIONS: dict[str, tuple[dict[str, Any], str, str]] = {
    "unknown method": ({"method": "guess"}, "invalid_input", "method"),
    "too many lines left out": ({"options": {"lines": 8, "leave_out": 5}}, "invalid_input", "leave_out"),
    "too few lines": ({"options": {"lines": 3}}, "invalid_input", "lines"),
    "lines left out by a method that needs them": (
        {"method": "circle_fit", "options": {"leave_out": 2}},
        "invalid_input",
        "leave_out",
    ),
    "order of a chart that is not drawn": ({"options": {"max_order": 20}}, "invalid_input", "max_order"),
    "lines of a fit of all": ({"method": "lscf", "options": {"lines": 12}}, "invalid_input", "lines"),
    "order beyond bounds": ({"method": "lscf", "options": {"max_order": 1000}}, "invalid_input", "max_order"),
    "unknown damping": ({"options": {"damping": "dry"}}, "invalid_input", "damping"),
    "unknown option": ({"options": {"order": 4}}, "invalid_request", "body.options.order"),
    "a word for a count": ({"options": {"lines": "8"}}, "invalid_request", "body.options.lines"),
}


@pytest.fixture(scope="module")
def tested(service: Any, beam: str, rig: str) -> str:
    """An exact test of the beam."""
    body = {"structure_id": beam, "rig_id": rig, "route": "expected"}
    return str(service.result_of("/v1/measurements", body))


@pytest.mark.parametrize("case", EXTRACTIONS)
def test_an_extraction_that_no_method_can_do_is_refused_at_once(service: Any, tested: str, case: str) -> None:
    wrong, code, field = EXTRACTIONS[case]
    reply = service.request("POST", "/v1/modal-models", json={"measurement_id": tested} | wrong)
    assert refusal(reply, 422, code)["context"]["field"] == field


UNKNOWN = [
    ("GET", "/v1/structures/none", None),
    ("GET", "/v1/structures/none/modes", None),
    ("POST", "/v1/structures/none/changes", {"changes": [{"node": 1, "property": "mass", "value": 1.0}]}),
    ("GET", "/v1/rigs/none", None),
    ("GET", "/v1/measurements/none/arrays", None),
    ("GET", "/v1/measurements/none/truth", None),
    ("POST", "/v1/measurements", {"structure_id": "none", "rig_id": "none"}),
    ("POST", "/v1/modal-models", {"measurement_id": "none"}),
    ("POST", "/v1/correlations", {"structure_id": "none", "modal_model_id": "none"}),
    ("POST", "/v1/updates", {"structure_id": "none", "modal_model_id": "none"}),
    ("POST", "/v1/studies", {"structure_id": "none", "truth_id": "none", "dofs": ["1:+Y"]}),
    ("GET", "/v1/studies/none", None),
    ("GET", "/v1/studies/none/arrays", None),
    ("GET", "/v1/jobs/none", None),
    ("GET", "/v1/jobs/none/events", None),
    ("DELETE", "/v1/jobs/none", None),
    ("DELETE", "/v1/structures/none", None),
    ("GET", "/v1/nothing", None),
]


@pytest.mark.parametrize(("method", "path", "body"), UNKNOWN)
def test_an_unknown_id_is_not_found(service: Any, method: str, path: str, body: Any) -> None:
    refusal(service.request(method, path, json=body), 404, "not_found")


def npz(**changed: Any) -> bytes:
    """Return a measured file of the rig below, some of its arrays changed."""
    lines = 21
    arrays = {
        "freq": np.linspace(0.0, 100.0, lines),
        "values": np.ones((lines, 1, 1), complex),
        "outputs": np.array(["1:+Y"]),
        "inputs": np.array(["1:+Y"]),
        "kind": np.array("inertance"),
        "coherence": np.ones((lines, 1)),
    } | changed
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **{name: array for name, array in arrays.items() if array is not None})
    return buffer.getvalue()


def upload(service: Any, content: bytes, rig: str) -> Any:
    """Return the reply to an import."""
    files = {"file": ("frf.npz", content)}
    return service.request("POST", "/v1/measurements/import", files=files, data={"rig_id": rig})


def with_nan() -> Any:
    values = np.ones((21, 1, 1), complex)
    values[3] = np.nan
    return values


def with_header(header: bytes) -> bytes:
    """Return a measured file whose first array begins with another header."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(npz())) as good, zipfile.ZipFile(buffer, "w") as bad:
        written = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header
        for name in good.namelist():
            bad.writestr(name, written + bytes(168) if name == "freq.npy" else good.read(name))
    return buffer.getvalue()


def damaged() -> bytes:
    """Return a measured file with its first compressed bytes overwritten."""
    content = npz()
    start = content.index(b"freq.npy") + 40
    return content[:start] + b"\xa5" * 8 + content[start + 8 :]


FILES = {
    "a header that never ends": (with_header(b"{'descr': '<f8', 'shape': (("), "freq.npy"),
    "a header of brackets": (with_header(b"(" * 5000), "freq.npy"),
    "a header of signs": (with_header(b"-" * 9000 + b"1"), "freq.npy"),
    "damaged bytes": (damaged(), "freq.npy"),
    "a response that is no text": (npz(outputs=np.array([b"\xff"])), "outputs"),
    "a response of half a character": (npz(outputs=np.array(["\ud800"])), "outputs"),
    "a kind that is no text": (npz(kind=np.array(b"\xff")), "kind"),
    "a kind of half a character": (npz(kind=np.array("\ud800")), "kind"),
    "no kind": (npz(kind=np.array([], dtype="U9")), "kind"),
    "a complex axis": (npz(freq=np.linspace(0.0, 100.0, 21) + 1j), "freq"),
    "complex coherence": (npz(coherence=np.full((21, 1), 0.5j)), "coherence"),
    "negative power": (npz(force_spectrum=np.full((21, 1, 1), -1.0)), "force_spectrum"),
    "two numbers for one": (npz(averages=np.array([10.0, 20.0])), "averages"),
    "an FRF that overflows when squared": (npz(values=np.full((21, 1, 1), 1e200 + 0j)), "values"),
    "power that overflows when squared": (npz(force_spectrum=np.full((21, 1, 1), 1e200)), "force_spectrum"),
    "NaN in an FRF": (npz(values=with_nan()), "values"),
    "an array missing": (npz(freq=None), "variables"),
    "no npz file": (b"PK no archive", "file"),
    "neither npz nor universal": (b"freq;value\n1;2\n", "file"),
    "a universal file cut off": (b"    -1\n    58\nNONE\n", "file"),
    "larger than a universal file may be": (b"    -1\n    58\n".ljust(33_000_000), "file"),
    "another shape": (npz(values=np.ones((20, 1, 1), complex)), "values"),
    "words for numbers": (npz(values=np.array(["a"])), "values"),
    "objects": (npz(coherence=np.array([[None]] * 21)), "coherence.npy"),
    "another kind": (npz(kind=np.array("stiffness")), "kind"),
    "a response the rig lacks": (npz(outputs=np.array(["2:+Y"])), "outputs"),
    "another drive": (npz(inputs=np.array(["2:+Y"])), "inputs"),
    "another axis": (npz(freq=np.linspace(0.0, 50.0, 21)), "freq"),
    "coherence above 1": (npz(coherence=np.full((21, 1), 2.0)), "coherence"),
    "unpacks to more than is allowed": (npz(values=np.zeros((6_000_000, 1, 1), complex)), "file"),
}


@pytest.fixture(scope="module")
def short_rig(service: Any) -> str:
    analyser = {"frequency_max": 100.0, "n_lines": 21}
    return str(service.post("/v1/rigs", RIG | {"analyser": analyser})["id"])


@pytest.mark.parametrize("case", FILES)
def test_a_file_without_sense_is_refused(service: Any, settings: Any, short_rig: str, case: str) -> None:
    content, field = FILES[case]
    app_settings = service.app.state.settings
    service.app.state.settings = settings.model_copy(update={"upload_limit": 50_000_000})
    try:
        reply = upload(service, content, short_rig)
    finally:
        service.app.state.settings = app_settings
    assert refusal(reply, 422, "invalid_input")["context"]["field"] == field


def test_a_good_file_is_taken_and_comes_back(service: Any, short_rig: str) -> None:
    reply = upload(service, npz(), short_rig)
    assert reply.status_code == 201, reply.text
    stored = service.request("GET", f"/v1/measurements/{reply.json()['id']}/arrays")
    arrays = np.load(io.BytesIO(stored.content))
    np.testing.assert_array_equal(arrays["values"], np.ones((21, 1, 1)))
    assert (str(arrays["kind"]), float(arrays["averages"])) == ("inertance", 100.0)
    truth = service.request("GET", f"/v1/measurements/{reply.json()['id']}/truth")
    refusal(truth, 404, "not_found")


def test_a_body_of_50_megabytes_is_refused_by_its_length(service: Any) -> None:
    reply = service.request("POST", "/v1/structures", content=b" " * 50_000_000, headers=_JSON)
    refusal(reply, 413, "content_too_large")


def test_a_body_that_calls_itself_a_form_gets_no_more_room(service: Any) -> None:
    headers = {"content-type": "multipart/form-data; boundary=x"}
    reply = service.request("POST", "/v1/structures", content=b" " * 50_000_000, headers=headers)
    refusal(reply, 413, "content_too_large")


def test_a_body_that_does_not_say_its_length_is_refused_while_it_comes(service: Any) -> None:
    sent = 0

    async def pieces() -> AsyncIterator[bytes]:
        nonlocal sent
        for _ in range(50):
            sent += 1_000_000
            yield b" " * 1_000_000

    reply = service.request("POST", "/v1/structures", content=pieces(), headers=_JSON)
    refusal(reply, 413, "content_too_large")
    assert sent < 10_000_000


def test_curves_too_long_for_json_name_the_way_out(service: Any, beam: str) -> None:
    responses = [f"{n}:+Y" for n in range(1, 22)]
    rig = service.post("/v1/rigs", RIG | {"responses": responses, "analyser": {"n_lines": 1601}})["id"]
    test = service.result_of("/v1/measurements", {"structure_id": beam, "rig_id": rig, "route": "expected"})
    reply = service.request("GET", f"/v1/measurements/{test}/curves", params={"points": 1601})
    assert "npz" in refusal(reply, 422, "invalid_input")["detail"]


def test_a_fault_of_the_service_is_a_problem_too(service: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(_id: str) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(service.app.state.store.rigs, "get", broken)
    problem = refusal(service.request("GET", "/v1/rigs/any"), 500, "internal")
    assert "ZeroDivision" not in str(problem)


_JSON = {"content-type": "application/json"}


def _json(body: Any) -> bytes:
    return json.dumps(body).encode()
