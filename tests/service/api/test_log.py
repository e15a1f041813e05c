"""The lab log of a measurement: enough to make it again, and nothing of the truth."""

import io
from typing import Any

import numpy as np
import pytest
import scipy

import modallab
from modallab.api.rigs.replies import rig_request
from modallab.api.rigs.schemas import RigIn
from modallab.core.dof import Dof
from modallab.core.place import Channels, EffectSpec
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Accelerometers, Coil, Exciter, ForceTransducer, Noise
from modallab.rig.setup import RigSetup
from modallab.rig.stinger import StingerRod, StingerStiffness
from modallab.rig.suspension import Suspension

SECRET = {"kind": "extra_mass", "at": "9:+Y", "parameters": {"mass": 0.0625}}


@pytest.fixture(scope="module")
def truth(service: Any, beam: str) -> str:
    """The beam with a stiffer member 7."""
    changes = [{"members": [7], "property": "modulus", "factor": 1.3}]
    return str(service.post(f"/v1/structures/{beam}/changes", {"changes": changes})["id"])


@pytest.fixture(scope="module")
def measured_id(service: Any, truth: str, rig: str) -> str:
    """A test with a hidden mass."""
    body = {"structure_id": truth, "rig_id": rig, "route": "drawn", "seed": 5, "effects": [SECRET]}
    return str(service.result_of("/v1/measurements", body))


def test_it_says_what_was_declared_and_asked(service: Any, measured_id: str, rig: str) -> None:
    log = service.get(f"/v1/measurements/{measured_id}/log")
    assert (log["id"], log["rig_id"], log["route"], log["seed"]) == (measured_id, rig, "drawn", 5)
    assert log["version"] == modallab.__version__
    assert log["libraries"] == {"numpy": np.__version__, "scipy": scipy.__version__}
    assert log["averages"] == 100
    stored = service.get(f"/v1/rigs/{rig}")
    assert {name: stored[name] for name in log["rig"] if name != "suspension"} == {
        name: value for name, value in log["rig"].items() if name != "suspension"
    }


def test_it_says_nothing_of_the_truth(service: Any, measured_id: str, truth: str, beam: str) -> None:
    for path in ("", "/log"):
        reply = service.request("GET", f"/v1/measurements/{measured_id}{path}").text
        for secret in (truth, beam, "extra_mass", "0.0625", '9:+Y", "parameters'):
            assert secret not in reply
    assert service.get(f"/v1/measurements/{measured_id}/truth") == {
        "structure_id": truth,
        "effects": [SECRET],
    }


def test_frfs_from_elsewhere_have_neither_route_nor_seed(service: Any, measured_id: str, rig: str) -> None:
    npz = service.request("GET", f"/v1/measurements/{measured_id}/arrays").content
    reply = service.request(
        "POST", "/v1/measurements/import", files={"file": ("m.npz", io.BytesIO(npz))}, data={"rig_id": rig}
    )
    log = service.get(f"/v1/measurements/{reply.json()['id']}/log")
    assert (log["route"], log["seed"], log["libraries"]) == (None, None, {})


def test_there_is_no_log_of_nothing(service: Any) -> None:
    reply = service.request("GET", "/v1/measurements/none/log")
    assert reply.status_code == 404
    assert reply.headers["content-type"].startswith("application/problem+json")


RIGS = {
    "bare": RigSetup((Dof(1, "Y"),), (Dof(3, "Y"),)),
    "several shakers": RigSetup((Dof(1, "Y"), Dof(9, "Y", -1)), (Dof(3, "Y", -1),)),
    "everything": RigSetup(
        (Dof(1, "Y"),),
        (Dof(3, "Y"), Dof(4, "X", -1)),
        Exciter("shaker", 0.02, 1e4, 3.0, Coil(7.5, 1.5, 1e-4), "voltage"),
        stinger=StingerRod(0.0015, 0.067, 2.07e11, 7850.0),
        force_transducer=ForceTransducer(0.01, mass_cancelled=True, stiffness=1e8),
        accelerometers=Accelerometers(0.02, True, "wax", 5e3, 0.03, 0.1, 1e-3),
        noise=Noise(1e-3, 1 / 3),
        analyser=Analyser(
            1234.5, 77, "hann", 12, 2 / 3, "hv", 16, 8.0, ExcitationSetting("random", 0.1), "ac", 0.3, 0.01
        ),
        suspension=Suspension((Dof(1, "Y"), Dof(21, "Y")), 1e3, 0.05),
        effects=(EffectSpec("polarity", Channels((Dof(3, "Y"),)), {}),),
    ),
    "springs": RigSetup((Dof(1, "Y"),), (Dof(3, "Y"),), stinger=StingerStiffness(1e6, 1e2, 1e5)),
}


@pytest.mark.parametrize("setup", RIGS.values(), ids=RIGS)
def test_the_rig_in_a_log_declares_the_same_rig(setup: RigSetup) -> None:
    assert RigIn.model_validate(rig_request(setup)).to_domain() == setup
