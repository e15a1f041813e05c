"""A measurement is made again, byte for byte, from its log and its truth, also after a restart."""

from pathlib import Path
from typing import Any

from tests.serving import Lab, free_port, running

HIDDEN = [
    {"kind": "extra_mass", "at": "7:+Y", "parameters": {"mass": 0.05}},
    {"kind": "mains_hum", "at": None, "parameters": {}},
    {"kind": "drift", "at": None, "parameters": {}},
]
RIG = {
    "drive": "1:+Y",
    "responses": ["1:+Y", "7:+Y"],
    "exciter": {"armature_mass": 0.02},
    "stinger": {"diameter": 0.0015, "length": 0.05, "modulus": 2.07e11, "density": 7850.0},
    "accelerometers": {"mass": 0.02, "roving": True},
    "suspension": {"at": ["2:+Y", "20:+Y"], "stiffness": 1e3},
    "analyser": {
        "n_lines": 101,
        "averages": 10,
        "window": "hann",
        "excitation": {"kind": "random"},
        "bits": 12,
    },
    "noise": {"force": 1e-3, "response": 1e-3},
    "effects": [{"kind": "polarity", "at": {"channels": ["7:+Y"]}, "parameters": {}}],
}


def measured(lab: Lab, body: dict[str, Any]) -> str:
    """Return the id of a measurement."""
    job = lab.json("POST", "/measurements", body)["id"]
    return str(lab.wait_for(job, state="succeeded")["result_id"])


def content(lab: Lab, measurement: str) -> bytes:
    """Return all arrays as they come over the wire."""
    reply = lab.request("GET", f"/measurements/{measurement}/arrays")
    assert reply.is_success, reply.text
    return reply.content


def again(lab: Lab, measurement: str) -> str:
    """Return the id of a measurement made anew from what log and truth of another say, and no more."""
    log, truth = (lab.json("GET", f"/measurements/{measurement}/{part}") for part in ("log", "truth"))
    rig = lab.json("POST", "/rigs", log["rig"])["id"]
    assert rig != log["rig_id"]
    return measured(lab, truth | {"rig_id": rig, "route": log["route"], "seed": log["seed"]})


def test_log_and_truth_make_the_same_bytes_again_after_a_restart(tmp_path: Path) -> None:
    port = free_port()
    arguments = ["serve", "--port", str(port)]
    with Lab(port) as lab:
        with running(*arguments, data=tmp_path, environment={"PYTHONHASHSEED": "1"}):
            lab.wait_until_up()
            beam = lab.json("POST", "/structures", {"kind": "catalogue", "name": "chapter-5-beam"})["id"]
            rig = lab.json("POST", "/rigs", RIG)["id"]
            asked = {"structure_id": beam, "rig_id": rig, "effects": HIDDEN, "seed": 2**62 + 1}
            made = {
                route: measured(lab, asked | {"route": route}) for route in ("expected", "drawn", "sampled")
            }
            arrays = {route: content(lab, one) for route, one in made.items()}
            assert len(set(arrays.values())) == 3
        with running(*arguments, data=tmp_path, environment={"PYTHONHASHSEED": "77"}):
            lab.wait_until_up()
            for route, one in made.items():
                assert content(lab, one) == arrays[route], "what is stored has changed"
                assert content(lab, again(lab, one)) == arrays[route]
