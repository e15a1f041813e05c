"""Correlations, expanded modes and reduced models: asked for, read, drawn."""

from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest
from matplotlib import pyplot

from modallab_client import ModalLab, errors
from modallab_client.methods.correlations import correlation_of
from modallab_client.results import Correlation
from tests.client.fake import MODE, FakeService, completed, npz

REPLY: dict[str, Any] = {
    "id": "c1",
    "mac": [[1.0, 0.1], [0.2, 0.9]],
    "pairs": [[1, 1], [2, 2]],
    "frequency_differences": [0.01, -1.5],
    "comac": [0.9, 1.0],
    "dofs": ["1:+Y", "3:+Y"],
    "ecomac": [0.04, 0.0],
    "pole_weighted_mac": [[1.0, 0.0], [0.0, 0.8]],
    "orthogonality": {
        "reduction": "serep",
        "parameters": {"modes": 2.0},
        "n_motions": 2,
        "cross": [[1.0, 0.05], [0.04, 0.99]],
        "auto": [[1.0, 0.02], [0.02, 1.0]],
        "frequency_errors": [0.0, 1e-3],
    },
    "responses": {
        "frac": [[0.5], [0.25]],
        "outputs": ["1:+Y", "3:+Y"],
        "inputs": ["1:+Y"],
        "frequency_scale": 1.1,
        "fdac_on_ridge": 0.99,
        "fdac_unscaled": 0.8,
        "notes": ["n"],
    },
    "something_new": 1,
}
FREQ = np.array([2.0, 4.0, 6.0])
FDAC = np.linspace(0, 1, 9).reshape(1, 3, 3)


@pytest.fixture(autouse=True)
def _off_screen() -> Iterator[None]:
    pyplot.switch_backend("agg")
    yield
    pyplot.close("all")


def correlation() -> Correlation:
    return correlation_of(completed(Correlation, REPLY), {"fdac_freq": FREQ, "fdac": FDAC})


def test_a_correlation_in_full_is_asked_for_by_keywords(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/correlations", REPLY)
    service.on("GET /v1/correlations/c1", REPLY)
    service.on("GET /v1/correlations/c1/arrays", npz(fdac_freq=FREQ, fdac=FDAC))
    wanted = {"kind": "serep", "parameters": {"modes": 2}}
    found = lab.correlations.create("mm1", "s1", count=2, reduction=wanted, measurement_id="m1")
    assert service.body(0) == {
        "modal_model_id": "mm1",
        "structure_id": "s1",
        "count": 2,
        "reduction": wanted,
        "measurement_id": "m1",
    }
    again = lab.correlations.get("c1")
    for one in (found, again):
        assert one.orthogonality is not None
        assert one.responses is not None
        assert one.cross_orthogonality is not None
        assert (one.orthogonality.reduction, one.orthogonality.parameters) == ("serep", {"modes": 2.0})
        assert one.orthogonality.n_motions == 2
        assert one.cross_orthogonality[0, 1] == 0.05
        assert (one.responses.frequency_scale, one.responses.notes) == (1.1, ("n",))
        np.testing.assert_array_equal(one.responses.fdac, FDAC)
        np.testing.assert_array_equal(one.responses.frac, [[0.5], [0.25]])


def test_without_frfs_no_arrays_are_asked_for(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/correlations", {**REPLY, "responses": None, "orthogonality": None})
    found = lab.correlations.create("mm1", "s1")
    assert found.responses is None
    assert found.orthogonality is None
    assert found.auto_orthogonality is None
    assert len(service.requests) == 1


def test_a_reply_that_is_none_is_said_to_be(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/correlations", httpx.Response(200, json={"pairs": []}))
    with pytest.raises(errors.UnexpectedReplyError, match="mac"):
        lab.correlations.create("mm1", "s1")


def test_expanded_modes_come_with_what_they_left_over(lab: ModalLab, service: FakeService) -> None:
    flagged = {**MODE, "flags": ["doubtful_expansion"]}
    about = {"id": "mm2", "modes": [MODE, flagged], "dofs": ["1:+Y"], "method": "dobson"}
    service.on("GET /v1/modal-models/mm2", about)
    service.on("GET /v1/modal-models/mm2/arrays", npz(shapes=np.ones((1, 2))))
    reply = {**about, "fit_residuals": [0.001, 0.4], "rayleigh_frequencies": [23.7, 60.0]}
    service.on("POST /v1/structures/s1/expanded-modes", reply)
    found = lab.structures.expanded_modes("s1", "mm1", reduction="guyan")
    assert service.body(0) == {"modal_model_id": "mm1", "reduction": "guyan"}
    assert found.model.id == "mm2"
    np.testing.assert_array_equal(found.fit_residuals, [0.001, 0.4])
    lines = found.table().splitlines()
    assert "60.00" in lines[2]
    assert "doubtful_expansion" in lines[2]
    assert "doubtful_expansion" in found._repr_html_()


def test_a_structure_is_reduced_by_name_and_number(lab: ModalLab, service: FakeService) -> None:
    two = np.eye(2)
    names = {"masters": np.array(["1:+Y", "3:+Y"]), "dofs": np.array(["1:+Y", "2:+Y", "3:+Y"])}
    numbers = {"frequencies": np.array([0.0, 23.6]), "model_frequencies": np.array([23.5])}
    errors_ = {"frequency_errors": np.array([0.004])}
    arrays = npz(
        transformation=np.ones((3, 2)), mass=two, stiffness=two, shapes=two, **names, **numbers, **errors_
    )
    service.on("GET /v1/structures/s1/reduced", arrays)
    found = lab.structures.reduced("s1", ["1:+Y", "3:+Y"], kind="dynamic", frequency=60.0)
    asked = service.requests[0].url.params
    assert asked.get_list("masters") == ["1:+Y", "3:+Y"]
    assert (asked["kind"], asked["frequency"]) == ("dynamic", "60.0")
    assert found.masters == ("1:+Y", "3:+Y")
    assert found.transformation.shape == (3, 2)
    assert found.frequency_errors[0] == 0.004


def test_pairs_are_tabulated_with_their_orthogonality() -> None:
    lines = correlation().table().splitlines()
    assert lines[0].split() == ["measured", "model", "difference", "Hz", "MAC", "orthogonality"]
    assert lines[2].split() == ["2", "2", "-1.5", "0.9000", "0.9900"]
    assert "<caption>Correlation at 2 degrees of freedom</caption>" in correlation()._repr_html_()


def test_degrees_of_freedom_are_drawn_by_name() -> None:
    upper, lower = correlation().plot_coordinates()
    assert [bar.get_height() for bar in upper.containers[0]] == [0.9, 1.0]
    assert [bar.get_height() for bar in lower.containers[0]] == [0.04, 0.0]
    assert [tick.get_text() for tick in lower.get_xticklabels()] == ["1:+Y", "3:+Y"]


def test_orthogonality_is_drawn_twice_and_only_if_there_is_any() -> None:
    left, right = correlation().plot_orthogonality()
    np.testing.assert_array_equal(left.images[0].get_array(), REPLY["orthogonality"]["cross"])
    np.testing.assert_array_equal(right.images[0].get_array(), REPLY["orthogonality"]["auto"])
    with pytest.raises(ValueError, match="without a reduction"):
        correlation_of(completed(Correlation, REPLY | {"orthogonality": None}), None).plot_orthogonality()


def test_lines_are_drawn_with_their_ridge_and_frfs_as_bars() -> None:
    responses = correlation().responses
    assert responses is not None
    axes = responses.plot()
    np.testing.assert_array_equal(np.asarray(axes.collections[0].get_array()).ravel(), FDAC.ravel())
    np.testing.assert_allclose(np.asarray(axes.lines[1].get_ydata(), float), 1.1 * FREQ)
    with pytest.raises(ValueError, match="tuple"):
        responses.plot("9:+Y")
    bars = responses.plot_frac()
    assert [bar.get_height() for bar in bars.containers[0]] == [0.5, 0.25]
