"""Studies as the client asks for them, reads, tabulates and draws them."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot

from modallab_client import ModalLab
from modallab_client._read import read_as
from modallab_client.results import Study
from tests.client.fake import FakeService, completed, npz

CELL = {
    "level": "NL1",
    "division": "each",
    "n_runs": 2,
    "n_failed": 0,
    "n_converged": 2,
    "suspected": 1.0,
    "unfounded": 0.5,
    "coefficient_error": [0.0, 0.002],
    "frequency_error": [1e-5, 2e-5],
    "coverage": 0.95,
    "of_a_later_version": 1,
}
NOT_MADE = {"coefficient_error": None, "frequency_error": None, "coverage": None}
RUN = {
    "level": "NL1",
    "division": "each",
    "seed": 3,
    "converged": True,
    "stopped_because": "no coefficient moved any more",
    "suspected": {"mass": [], "stiffness": [11, 12]},
    "all_suspected": True,
    "n_unfounded": 0,
    "coefficient_error": 0.001,
    "frequency_error": 1e-5,
    "coverage": 0.95,
}
STUDY: dict[str, Any] = {
    "id": "st<1>",
    "plan": {
        "method": "one_shot",
        "levels": [
            {"name": "NL1", "noise": {"eigenvalue": 0.0, "eigenvector": 0.0, "distribution": "uniform"}},
            {"name": "NL3", "noise": {"eigenvalue": 0.005, "eigenvector": 0.05, "distribution": "uniform"}},
        ],
        "divisions": [
            {
                "name": "each",
                "parameterisation": {
                    "macros": [{"members": [11], "part": "stiffness"}],
                    "lower": 0.05,
                    "upper": 10.0,
                },
            }
        ],
        "seeds": [3, 4],
        "count": 10,
        "dofs": ["1:+Y"],
        "options": {"max_iterations": 30},
    },
    "true": {"mass": {"11": 1.0}, "stiffness": {"11": 2.0}},
    "wrong": {"mass": {}, "stiffness": {"11": 2.0}},
    "cells": [CELL, CELL | NOT_MADE | {"level": "NL3", "n_failed": 2, "suspected": 0.0}],
    "runs": [RUN, RUN | NOT_MADE | {"level": "NL3", "converged": False, "stopped_because": "too few rows"}],
}


@pytest.fixture(autouse=True)
def _off_screen() -> Iterator[None]:
    pyplot.switch_backend("agg")
    yield
    pyplot.close("all")


def test_what_is_left_out_is_left_to_the_service(lab: ModalLab, service: FakeService) -> None:
    service.on("POST /v1/studies", {"id": "j1", "state": "queued"})
    lab.studies.start("s1", "s2", dofs=["1:+Y"])
    assert service.body() == {"structure_id": "s1", "truth_id": "s2", "dofs": ["1:+Y"]}
    lab.studies.start("s1", "s2", dofs=["1:+Y"], divisions={"two": [[1], [2]]}, seeds=range(2), lower=0.1)
    assert service.body()["divisions"] == {"two": [[1], [2]]}
    assert (service.body()["seeds"], service.body()["lower"]) == ([0, 1], 0.1)


def test_a_study_and_its_coefficients_are_read(lab: ModalLab, service: FakeService) -> None:
    service.on("GET /v1/studies/st1", STUDY)
    arrays = {"parts": np.array(["mass", "stiffness"]), "members": np.array([11, 11]), "true": np.ones(2)}
    service.on("GET /v1/studies/st1/arrays", npz(**arrays, coefficients=np.array([[1.0, 2.0], [np.nan] * 2])))
    study = lab.studies.get("st1")
    plan = study.plan
    assert [level.name for level in plan.levels] == ["NL1", "NL3"]
    assert plan.levels[1].noise.eigenvector == 0.05
    (division,) = plan.divisions
    assert (division.name, division.parameterisation.macros[0].members) == ("each", (11,))
    assert (plan.seeds, plan.options["max_iterations"]) == ((3, 4), 30)
    assert study.wrong["stiffness"] == {11: 2.0}
    assert study.runs[0].suspected["stiffness"] == (11, 12)
    assert (study.runs[1].stopped_because, study.runs[1].coefficient_error) == ("too few rows", None)
    found = lab.studies.coefficients("st1")
    assert (found.parts, found.members) == (("mass", "stiffness"), (11, 11))
    np.testing.assert_array_equal(found.found, [[1.0, 2.0], [np.nan, np.nan]])


def test_a_table_has_a_row_for_every_level_and_division() -> None:
    study = read_as(Study, completed(Study, STUDY))
    head, one, other = study.table().splitlines()
    assert head.split()[:4] == ["level", "division", "runs", "failed"]
    assert one.split() == ["NL1", "each", "2", "0", "100%", "0.5", "0", "0.002", "1e-05", "2e-05", "95.0%"]
    assert other.split() == ["NL3", "each", "2", "2", "0%", "0.5"]
    assert "st&lt;1&gt;" in study._repr_html_()


def test_errors_suspects_and_coverage_are_drawn_by_level() -> None:
    axes = read_as(Study, completed(Study, STUDY)).plot()
    assert [tick.get_text() for tick in axes[2].get_xticklabels()] == ["NL1", "NL3"]
    # nothing was made at the second level
    np.testing.assert_array_equal(axes[0].lines[0].get_ydata(), [0.0, np.nan])
    assert axes[0].get_ylim()[1] > 0.002, "the bar up to 90 % is seen"
    np.testing.assert_array_equal(axes[2].lines[0].get_ydata(), [100.0, 0.0])
    np.testing.assert_array_equal(axes[3].lines[0].get_ydata(), [95.0, np.nan])
