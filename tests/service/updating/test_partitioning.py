"""How a structure is divided into macro elements when nobody has."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.members import Material
from modallab.fe.plate import plate
from modallab.fe.structure import Section, Structure
from modallab.updating.partition_settings import PARTITION
from modallab.updating.partitioning import automatic_groups, partitioned, property_groups

BEAM, BAY = STRUCTURES["chapter-5-beam"](), STRUCTURES["bay"]()
STEEL = Material(2.09e11, 7800.0)
SHEET = plate(length=0.6, width=0.4, thickness=0.004, n_elements=(60, 40), material=STEEL)


def is_connected(structure: Structure, numbers: Iterable[int]) -> bool:
    """Return whether members reach one another over nodes that they share: by a search from the first."""
    left = {number: set(structure.member(number).nodes) for number in numbers}
    reached = left.pop(next(iter(left)))
    while touching := [number for number, nodes in left.items() if nodes & reached]:
        for number in touching:
            reached |= left.pop(number)
    return not left


def all_numbers(groups: Iterable[Iterable[int]]) -> list[int]:
    return sorted(number for group in groups for number in group)


def test_a_straight_beam_is_cut_into_equal_pieces() -> None:
    fours = tuple(tuple(range(i, i + 4)) for i in range(1, 21, 4))
    assert automatic_groups(BEAM) == fours
    assert partitioned(BEAM, 5) == fours


def test_a_frame_is_cut_at_its_corners_as_the_thesis_cuts_it() -> None:
    groups = automatic_groups(BAY)
    for group in ((1, 2, 3, 4), (5, 6, 7), (13, 14, 15, 16), (25, 26, 27, 28), (29, 30, 31)):
        assert group in groups
    assert all_numbers(groups) == list(range(1, 32))


def test_a_change_of_section_ends_a_piece() -> None:
    thick = tuple(replace(m, section=Section(1e-3, 4e-9)) if m.number > 2 else m for m in BEAM.members)
    assert automatic_groups(replace(BEAM, members=thick))[0] == (1, 2)


def test_a_change_of_section_is_where_a_beam_is_rather_cut() -> None:
    thick = tuple(replace(m, section=Section(1e-3, 4e-9)) if m.number > 9 else m for m in BEAM.members)
    assert [len(half) for half in partitioned(BEAM, 2)] == [10, 10]
    assert [len(half) for half in partitioned(replace(BEAM, members=thick), 2)] == [9, 11]


@pytest.mark.parametrize("name", STRUCTURES)
@pytest.mark.parametrize("count", [1, 2, 3, 7, 10])
def test_parts_are_connected_hold_every_member_once_and_are_of_like_size(name: str, count: int) -> None:
    structure = STRUCTURES[name]()
    parts = partitioned(structure, count)
    numbers = [member.number for member in structure.all_members]
    assert len(parts) == count
    assert all_numbers(parts) == sorted(numbers)
    assert all(is_connected(structure, part) for part in parts)
    # a frame cannot be cut anywhere: a cut moves by up to a bar between two corners
    assert max(map(len, parts)) <= 1.5 * len(numbers) / count + 1


def test_a_plate_of_thousands_is_cut_into_compact_parts() -> None:
    parts = partitioned(SHEET, 24)
    assert all(is_connected(SHEET, part) for part in parts)
    # five cuts in turn, each by up to 5 % of the smaller half aside
    assert {round(len(part), -1) for part in parts} <= {90, 100, 110}
    label = np.zeros(2400, int)
    for i, part in enumerate(parts):
        label[np.array(part) - 1] = i
    table = label.reshape(40, 60)
    cuts = (np.diff(table, axis=0) != 0).sum() + (np.diff(table, axis=1) != 0).sum()
    # 24 squares of 10 x 10 have 380 sides between them, 24 strips a whole row or more each above 1,300
    assert cuts <= 1.15 * 380


def test_a_large_structure_has_no_more_macro_elements_than_modes_can_tell_apart() -> None:
    parts = automatic_groups(SHEET)
    assert len(parts) == PARTITION.max_runs
    assert 30 <= min(map(len, parts)) <= max(map(len, parts)) <= 50


def test_names_stay_whole_whatever_else_is_cut() -> None:
    named = tuple(replace(m, group="stiffener") if m.number in (700, 1500) else m for m in SHEET.all_members)
    groups = automatic_groups(SHEET.of_members(named))
    assert groups[0] == (700, 1500)
    assert all_numbers(groups) == list(range(1, 2401))


def test_members_alike_are_one_group_and_so_are_those_of_a_name() -> None:
    named = tuple(replace(m, group="left") if m.number in (1, 9) else m for m in BAY.members)
    structure = replace(BAY, members=named)
    groups = property_groups(structure)
    assert groups[0] == (1, 9)
    assert all_numbers(groups) == list(range(1, 32))
    bars = {member.number: member for member in structure.members}
    made_of = [
        {(bars[n].group or bars[n].section, bars[n].group or bars[n].material) for n in g} for g in groups
    ]
    assert all(len(kinds) == 1 for kinds in made_of)
    assert all(one.isdisjoint(other) for one, other in combinations(made_of, 2))


def test_the_same_structure_is_divided_the_same_way() -> None:
    assert partitioned(SHEET, 7) == partitioned(SHEET, 7)


@pytest.mark.parametrize("count", [0, 21])
def test_more_parts_than_members_are_refused(count: int) -> None:
    with pytest.raises(InvalidInputError, match="20 members make no") as caught:
        partitioned(BEAM, count)
    assert caught.value.context["allowed"] == {"minimum": 1, "maximum": 20}
