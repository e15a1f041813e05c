"""Direct updating methods as the client asks for them and reads them."""

from typing import Any

import numpy as np
from matplotlib.patches import Rectangle

from modallab_client import ModalLab
from modallab_client.methods.updates import update_of
from modallab_client.results import DirectUpdate, ErrorLocation
from tests.client.fake import UPDATE, FakeService, completed, npz

STORED = {name: UPDATE[name] for name in ("id", "stopped_because", "frequencies")}
DIRECT: dict[str, Any] = STORED | {
    "kind": "direct",
    "converged": True,
    "method": "berman_nagy",
    "dofs": ["1:+Y", "2:+Y"],
    "completion": "expanded: serep",
    "n_modes": 1,
    "reproduced": 1e-12,
    "connectivity_loss": {"stiffness": 0.85},
    "other_modes": {"before": [9.0], "after": [8.0], "mac": [0.9], "rigid_body": None},
    "dof_errors": {
        "stiffness": [{"dof": "2:+Y", "error": 0.3}, {"dof": "1:+Y", "error": 0.0}],
        "mass": [{"dof": "1:+Y", "error": 0.1}, {"dof": "2:+Y", "error": 0.02}],
    },
    "notes": ["n"],
}


def test_a_direct_update_is_asked_by_keywords_and_its_matrices_come_apart(
    lab: ModalLab, service: FakeService
) -> None:
    service.on("POST /v1/updates", {"id": "j1", "state": "queued"})
    service.on("GET /v1/updates/u1/arrays", npz(dofs=np.array(["1:+Y", "2:+Y"]), stiffness=np.eye(2)))
    lab.updates.start("s1", "mm1", method="berman_nagy", expansion="serep", n_modes=5)
    assert service.body(0)["options"] == {"expansion": "serep", "n_modes": 5}
    made = lab.updates.matrices("u1")
    assert made.dofs == ("1:+Y", "2:+Y")
    np.testing.assert_array_equal(made.stiffness, np.eye(2))
    assert made.mass is None


def test_what_it_cost_is_read() -> None:
    update = update_of(completed(DirectUpdate, DIRECT))
    assert update.structure_id is None
    assert update.direct is not None
    assert update.direct.connectivity_loss == {"stiffness": 0.85}
    assert update.direct.other_modes is not None
    np.testing.assert_array_equal(update.direct.other_modes.after, [8.0])
    assert [item.dof for item in update.direct.dof_errors["stiffness"]] == ["2:+Y", "1:+Y"]
    found = update_of(completed(DirectUpdate, DIRECT | {"other_modes": None, "reproduced": None})).direct
    assert found is not None
    assert found.other_modes is None


def test_errors_by_dof_show_themselves() -> None:
    update = update_of(completed(DirectUpdate, DIRECT))
    assert "2:+Y" in update.table()
    assert "<th>relative error</th>" in update._repr_html_()
    drawn = update.plot().lines
    np.testing.assert_array_equal(drawn[0].get_ydata(), [0.3, 0.0])
    assert update_of(UPDATE).direct is None


LOCATED: dict[str, Any] = STORED | {
    "kind": "error_location",
    "method": "zhang_subspace",
    "suspected": {"stiffness": [11]},
    "changes": {"stiffness": {"10": 0.0, "11": 0.4}},
    "weights": {"stiffness": {"10": 0.0, "11": 0.9}},
    "remaining": [0.1],
    "rank": 1,
    "condition_number": 1.0,
}


def test_suspects_of_one_step_are_read_and_shown() -> None:
    update = update_of(completed(ErrorLocation, LOCATED))
    assert isinstance(update, ErrorLocation)
    assert update.suspected == {"stiffness": (11,)}
    np.testing.assert_array_equal(update.remaining, [0.1])
    assert update.coefficients == {"stiffness": {10: 1.0, 11: 1.4}}
    assert (update.structure_id, update.converged, update.direct) == (None, False, None)
    head, *rows = update.table().splitlines()
    assert "weight" in head
    assert [row.split() for row in rows] == [["stiffness", "11", "0.4", "0.9"]]
    ends = [bar.get_y() + bar.get_height() for bar in update.plot().patches if isinstance(bar, Rectangle)]
    np.testing.assert_allclose(ends, [1.0, 1.4])
