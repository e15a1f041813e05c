"""In a notebook every result shows what it is."""

from typing import Any

import numpy as np
import pytest

from modallab_client import results
from modallab_client._read import read_as
from modallab_client.correlation import ReducedModel
from modallab_client.models import Frf, ModeShapes
from tests.client.fake import completed

SLIP = {"code": "extent", "message": "the structure is <1200 m> long", "field": "length"}
LINES = np.array([10.0, 20.0])
SHAPES = ModeShapes(LINES, np.ones((3, 2), complex), ("1:+Y", "2:+Y", "3:+Y"))
FRF = Frf(LINES, np.ones((2, 1, 1), complex), ("2:+Y",), ("1:+Y",), "mobility", ("0 Hz left out",))
REDUCED = ReducedModel(
    ("1:+Y",),
    ("1:+Y", "2:+Y"),
    *(np.ones((1, 1)),) * 3,
    LINES,
    np.ones((1, 2)),
    LINES,
    np.array([1e-3, 0.02]),
)


def result(kind: Any, **given: Any) -> Any:
    return read_as(kind, completed(kind, given))


ANALYSER = {"averages": 5, "n_lines": 401, "frequency_max": 800.0, "window": "hann", "estimator": "h1"}
RIG = result(
    results.Rig,
    id="r1",
    drives=["1:+Y"],
    responses=["1:+Y", "3:+Y"],
    exciter={"kind": "shaker"},
    analyser=ANALYSER | {"excitation": {"kind": "burst_random"}},
)
BEAM = result(results.Structure, id="s1", name="beam", n_nodes=21, n_dofs=42, members=20, warnings=[SLIP])


@pytest.mark.parametrize(
    ("shown", "words"),
    [
        (BEAM, ["Structure s1 beam", "<td>42</td>", "length: the structure is &lt;1200 m&gt; long"]),
        (RIG, ["Rig r1", "shaker at 1:+Y", "burst random, hann, h1", "401 lines from 0 to 800 Hz"]),
        (SHAPES, ["Mode shapes at 3 DoFs", "<td>20</td>"]),
        (FRF, ["mobility", "2 from 10 to 20 Hz", "0 Hz left out"]),
        (REDUCED, ["2 DoFs reduced to 1", "<td>0.02</td>"]),
        (result(results.JobStatus, id="j1", state="running", fraction=0.333), ["Job j1", "33%"]),
        (result(results.StabilisationChart, modes=[23.6, 66.0]), ["<td>66</td>"]),
        (result(results.FitPlotData, mode=2, frequency=66.01, response="3:+Y"), ["Mode 2", "66.01 Hz"]),
    ],
)
def test_a_result_is_a_table(shown: Any, words: list[str]) -> None:
    html = shown._repr_html_()
    for text in words:
        assert text in html


def test_structures_and_rigs_are_told_in_a_sentence() -> None:
    assert BEAM.summary() == "beam: 21 nodes, 42 degrees of freedom, 20 members"
    assert RIG.summary() == "shaker at 1:+Y, 2 responses, 401 lines from 0 to 800 Hz, 5 averages"


def test_a_reduced_model_has_a_table_of_its_errors() -> None:
    assert REDUCED.table().splitlines()[-1].split() == ["2", "20", "0.02"]
    assert repr(SHAPES) == "ModeShapes(2 modes at 3 DoFs)"
