from modallab_client._read import read_as
from modallab_client.results import Diagnosis
from tests.client.fake import DIAGNOSIS, completed


def test_what_a_number_that_may_differ_came_to_is_read() -> None:
    delay = {"name": "delay", "at": {"channels": ["4:+Y"]}, "mode": None, "value": -1e-6, "unit": "s"}
    loss = {"name": "modal_loss_factor", "at": None, "mode": 3, "value": 1.18, "unit": "1"}
    reply = {
        "id": "d1",
        "verdict": "nothing_missing",
        "steps": [],
        "tolerated": [
            delay | {"standard_error": 1e-8, "tolerance": 1e-6},
            loss | {"standard_error": None, "tolerance": 0.2},
        ],
    }
    first, second = read_as(Diagnosis, completed(Diagnosis, reply)).tolerated
    assert (first.name, first.at, first.value, first.standard_error) == ("delay", delay["at"], -1e-6, 1e-8)
    assert (second.mode, second.tolerance, second.standard_error) == (3, 0.2, None)
    assert read_as(Diagnosis, DIAGNOSIS).tolerated == ()
