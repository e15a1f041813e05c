"""What docs/models.md tells to type."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modallab.interchange.nastran.model import READ_CARDS
from tests.pages import Check, outcomes

TESTS = Path(__file__).parents[1]
OP4 = TESTS / "service" / "interchange" / "nastran" / "bigmat_text.op4"
TEXT = (Path(__file__).parents[2] / "docs" / "models.md").read_text(encoding="utf-8")


def groups_are_those_of_the_page(names: dict[str, Any]) -> None:
    assert f"print(bracket.groups)  # {dict(names['bracket'].groups)}" in TEXT


def an_update_by_groups_finds_what_was_changed(names: dict[str, Any]) -> None:
    found = names["update"].coefficients["stiffness"]
    # exact modes of an exact model: to the tolerance of the iteration
    assert found[1] == pytest.approx(1.2, abs=1e-4)
    assert found[2] == pytest.approx(1.0, abs=1e-4)


def a_chain_of_masses_has_its_frequencies(names: dict[str, Any]) -> None:
    stiffness = np.array([[4e5, -4e5, 0], [-4e5, 6e5, -2e5], [0, -2e5, 2e5]])
    root = np.diag(1 / np.sqrt([2.0, 1.0, 2.0]))
    exact = np.sqrt(np.linalg.eigvalsh(root @ stiffness @ root)[1:]) / (2 * np.pi)
    found = names["lab"].structures.modes(names["chain"].id, count=2)
    np.testing.assert_allclose(found.frequencies, exact, rtol=1e-10)  # rounding
    assert found.n_rigid_body == 1


def matrices_of_cards_have_their_frequencies(names: dict[str, Any]) -> None:
    # lambda^2 - 3.5e3 lambda + 2e6 = 0
    exact = np.sqrt(np.sort(np.roots([1.0, -3.5e3, 2e6]))) / (2 * np.pi)
    found = names["lab"].structures.modes(names["reduced"].id, count=2)
    np.testing.assert_allclose(found.frequencies, exact, rtol=1e-10)  # rounding


def a_file_of_matrices_goes_up_with_its_degrees_of_freedom(names: dict[str, Any]) -> None:
    structures = names["lab"].structures
    given = structures.upload(OP4, dofs=[f"{n}:+{d}" for n in range(1, 8) for d in ("Y", "RZ")], name="line")
    section, material = {"area": 5e-4, "second_moment": 4.1667e-9}, {"modulus": 2.09e11, "density": 7800.0}
    own = structures.beam(length=1.5, n_elements=6, section=section, material=material)
    found = structures.modes(given.id, count=6).frequencies
    # all digits were written
    np.testing.assert_allclose(found, structures.modes(own.id, count=6).frequencies, rtol=1e-8)


def a_mesh_is_the_structure_that_it_says(names: dict[str, Any]) -> None:
    sheet = names["sheet"]
    assert f"print(sheet.groups)  # {dict(sheet.groups)}" in TEXT
    assert (sheet.n_nodes, sheet.n_dofs) == (6, 3 * 4)  # two of six nodes are held


def a_plate_is_measured(names: dict[str, Any]) -> None:
    assert names["test"].values.shape[1:] == (5, 1)
    assert np.isfinite(names["test"].values).all()


def test_every_card_of_the_page_is_read() -> None:
    told = set(
        re.findall(r"\b[A-Z]+[0-9]?\b", TEXT[TEXT.index("| bulk data card") : TEXT.index("Loads, tables")])
    )
    assert told >= READ_CARDS


CHECKS = [
    groups_are_those_of_the_page,
    an_update_by_groups_finds_what_was_changed,
    a_chain_of_masses_has_its_frequencies,
    matrices_of_cards_have_their_frequencies,
    a_file_of_matrices_goes_up_with_its_degrees_of_freedom,
    a_mesh_is_the_structure_that_it_says,
    a_plate_is_measured,
]


@pytest.fixture(scope="module")
def found_wrong(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What each check found wrong after the page ran in a new interpreter and an empty folder."""
    return outcomes("models.md", tmp_path_factory.mktemp("guide"), CHECKS)


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_the_examples_give_what_the_page_says(check: Check, found_wrong: dict[str, str]) -> None:
    assert not found_wrong[check.__name__], found_wrong[check.__name__]
