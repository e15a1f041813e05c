"""Pictures of structures and mode shapes, still and moving."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot
from PIL import Image

from modallab_client._read import read_as
from modallab_client._shape_plot import moved
from modallab_client.models import ModeShapes
from modallab_client.results import StructureGeometry
from tests.client.fake import completed


@pytest.fixture(autouse=True)
def _off_screen() -> Iterator[None]:
    pyplot.switch_backend("agg")
    yield
    pyplot.close("all")


def layout(nodes: dict[str, Any], members: list[list[int]], dofs: list[str]) -> StructureGeometry:
    parts = [{"number": i, "nodes": ends} for i, ends in enumerate(members, 1)]
    given = {"id": "s1", "name": "rod", "nodes": nodes, "members": parts, "dofs": dofs}
    return read_as(StructureGeometry, completed(StructureGeometry, given))


ROD = layout({str(n): [float(n), 0.0] for n in range(5)}, [[n, n + 1] for n in range(4)], ["0:+Y", "4:+Y"])
SHAPE = ModeShapes(np.array([12.5]), np.array([[1.0], [0.5], [2.0]]), ("0:+Y", "2:-Y", "0:+RZ"))


def test_nodes_between_measured_ones_lie_on_a_straight_line() -> None:
    moving = moved(ROD, [1.0, 0.5], ("0:+Y", "2:-Y"))
    sizes = moving.motion[:, 1].real / moving.motion[0, 1].real
    # from 1 to -0.5 in two equal lengths, and with the last one measured to the end; rounding
    np.testing.assert_allclose(sizes, [1.0, 0.25, -0.5, -0.5, -0.5], atol=1e-6)
    assert not moving.motion[:, [0, 2]].any()


def test_a_node_nearer_to_one_neighbour_moves_more_like_it() -> None:
    uneven = layout({"1": [0.0, 0.0], "2": [1.0, 0.0], "3": [4.0, 0.0]}, [[1, 2], [2, 3]], [])
    motion = moved(uneven, [0.0, 4.0], ("1:+Y", "3:+Y")).motion[:, 1].real
    np.testing.assert_allclose(motion / motion[2], [0.0, 0.25, 1.0], atol=1e-6)  # the hold


def test_nodes_that_nothing_measured_is_connected_to_stay_at_rest() -> None:
    two = layout({"1": [0.0, 0.0], "2": [1.0, 0.0], "3": [2.0, 0.0], "4": [3.0, 0.0]}, [[1, 2], [3, 4]], [])
    motion = moved(two, [1.0], ("1:+Y",)).motion
    assert motion[1, 1] == pytest.approx(motion[0, 1], rel=1e-6)
    np.testing.assert_array_equal(motion[2:], 0.0)


def test_a_shape_is_drawn_over_the_structure_at_rest() -> None:
    axes = SHAPE.plot_shape(ROD)
    assert axes.get_title() == "mode 1, 12.5 Hz"
    assert len(axes.lines) == 2 * 4 + 1  # members at rest and moved, measured nodes
    assert len(axes.lines[-1].get_xdata()) == 2  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="there is no mode 2: there are 1"):
        SHAPE.plot_shape(ROD, 2)


def test_a_plate_is_drawn_in_space() -> None:
    corners = {"1": [0.0, 0.0], "2": [1.0, 0.0], "3": [1.0, 1.0], "4": [0.0, 1.0]}
    plate = layout(corners, [[1, 2, 3, 4]], [])
    axes = ModeShapes(np.array([1.0]), np.ones((1, 1), complex), ("1:+Z",)).plot_shape(plate)
    assert axes.name == "3d"
    assert plate.plot().name == "rectilinear"


def test_an_animation_is_a_moving_picture_or_a_page(tmp_path: Path) -> None:
    shape = SHAPE.animate(ROD)
    with Image.open(shape.save(tmp_path / "mode.gif")) as picture:
        assert picture.n_frames > 10  # type: ignore[attr-defined]
        picture.seek(0)
        first = np.asarray(picture.convert("L"), float)
        picture.seek(picture.n_frames // 2)  # type: ignore[attr-defined]
        assert np.abs(np.asarray(picture.convert("L"), float) - first).max() > 100  # half a cycle on
    page = shape.save(tmp_path / "mode.html").read_text()
    assert "<script" in page
    assert "base64" in page
    with pytest.raises(ValueError, match=r"a \.gif or a \.html file, not mode.avi"):
        shape.save(tmp_path / "mode.avi")
    assert not pyplot.get_fignums(), "its figures are closed"


def test_a_structure_is_drawn_with_the_numbers_of_its_nodes() -> None:
    axes = ROD.plot()
    assert [text.get_text().strip() for text in axes.texts] == ["0", "1", "2", "3", "4"]
    assert axes.get_title() == "rod: 5 nodes, 4 members"
    assert "<td>5</td>" in ROD._repr_html_()
