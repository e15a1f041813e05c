"""Where model and measurement part, drawn."""

import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np

from modallab.core.dof import Dof
from modallab.core.place import Members
from modallab.diagnosis.reporting.location_plot import location_drawings
from modallab.diagnosis.result import Diagnosis, FittedEffect, Verdict
from modallab.fe.assembly import assemble
from modallab.fe.imported_elements import GroupMatrices, of_groups
from modallab.fe.plate import plate
from modallab.fe.structure import Material, Member, Section, Structure
from tests.diagnosed import STEP, curves, diagnosis


def drawings(found: Diagnosis) -> list[ET.Element]:
    """Return the drawings, which must be well-formed."""
    return list(ET.fromstring(f"<div>{location_drawings(found)}</div>").iter("svg"))


def cells(drawing: ET.Element, level: int) -> list[ET.Element]:
    """Return the cells of a map that have a colour."""
    return [one for one in drawing.iter("rect") if one.get("class") == f"l{level}"]


def test_the_map_is_dark_at_the_resonance_before_and_light_all_over_after() -> None:
    before, after, _ = drawings(diagnosis())
    dark = [float(one.get("x", 0)) for level in (3, 4) for one in cells(before, level)]
    # 0 to 400 Hz over 402 units from 58: the resonance at 120 Hz lies near 58 + 0.3 x 402 = 179
    assert min(abs(x - 179) for x in dark) < 20
    # channel 5:+Y is off by a factor that nothing was added for; all others agree
    rows = {one.get("y") for level in (1, 2, 3, 4) for one in cells(after, level)}
    assert len(rows) == 1


def test_every_response_has_a_row_and_one_held_out_a_star() -> None:
    before, *_ = drawings(diagnosis())
    names = [one.text for one in before.iter("text") if one.get("class") == "side"]
    assert names == ["1:+Y", "2:+Y", "4:+Y *", "5:+Y", "7:+Y", "9:+Y"]


def test_the_structure_shows_the_response_that_is_off_and_rings_what_was_added() -> None:
    *_, sketch = drawings(diagnosis())
    (ring,) = (one for one in sketch.iter("circle") if one.get("class") == "ring")
    nodes = {one.get("cx"): one.get("class", "") for one in sketch.iter("circle") if one is not ring}
    assert ring.get("cx") in nodes, "node 4 was measured"
    levels = [int(style[1]) for _, style in sorted(nodes.items(), key=lambda one: float(one[0] or 0))]
    assert max(levels) == levels[3], "5:+Y is furthest off"
    member = replace(STEP, effect=FittedEffect("density_error", Members((3, 5)), {}))
    *_, marked = drawings(diagnosis(steps=(member,)))
    assert len([one for one in marked.iter("path") if one.get("class") == "marked"]) == 2


def test_without_additions_there_is_one_map() -> None:
    titles = [one.get("aria-label", "") for one in drawings(diagnosis(Verdict.NOTHING_MISSING, ()))]
    assert len(titles) == 2
    assert "initial prediction" in titles[0]
    assert "structure" in titles[1]


def test_names_of_many_responses_do_not_run_into_each_other() -> None:
    few = curves()
    many = replace(
        few,
        measured=np.tile(few.measured, (1, 20, 1)),
        before=np.tile(few.before, (1, 20, 1)),
        after=np.tile(few.after, (1, 20, 1)),
        random_error=np.tile(few.random_error, (1, 20, 1)),
        held_out=np.tile(few.held_out, 20),
        outputs=tuple(Dof(1 + i % 9, "Y") for i in range(120)),
    )
    before, *_ = drawings(replace(diagnosis(), curves=many))
    heights = [float(one.get("y", 0)) for one in before.iter("text") if one.get("class") == "side"]
    assert len(heights) > 10
    assert np.diff(heights).min() >= 11  # a line of text
    assert float(re.findall(r"[\d.]+", before.get("viewBox", ""))[3]) < 400


def test_numbers_of_the_nodes_of_a_frame_keep_apart() -> None:
    nodes = {1: (0.0, 0.0), 2: (0.0, 0.1), 3: (0.0, 0.2), 4: (0.4, 0.2), 5: (0.8, 0.2), 6: (0.8, 0.0)}
    section, material = Section(5e-4, 4.1667e-9), Material(2.09e11, 7800.0)
    members = tuple(Member(i, (i, i + 1), section, material) for i in range(1, 6))
    frame = Structure(nodes=nodes, members=members)
    found = diagnosis()
    outputs = tuple(Dof(node, "Y") for node in nodes)
    *_, sketch = drawings(replace(found, structure=frame, curves=replace(found.curves, outputs=outputs)))
    numbers = {
        one.text: (float(one.get("x", 0)), float(one.get("y", 0)))
        for one in sketch.iter("text")
        if one.get("class") == "tick"
    }
    assert set(numbers) == {"1", "2", "3", "4", "5", "6"}
    places = np.array(list(numbers.values()))
    apart = np.abs(places[:, None] - places) >= (22, 13)
    assert (apart.any(axis=2) | np.eye(6, dtype=bool)).all()


def test_a_plate_is_drawn_by_the_rims_of_its_elements() -> None:
    found = diagnosis()
    body = plate(length=0.6, width=0.4, thickness=0.004, n_elements=(3, 2), material=Material(7e10, 2700.0))
    outputs = tuple(Dof(node, "Z") for node in (1, 3, 6, 8, 10, 12))
    shown = replace(found.curves, inputs=(Dof(1, "Z"),), outputs=outputs)
    *_, sketch = drawings(replace(found, structure=body, curves=shown))
    rims = [one for one in sketch.iter("path") if one.get("class") == "rim"]
    assert len(rims) == 3 * 3 + 4 * 2, "those between two elements once"


def test_a_model_in_space_is_drawn_from_aside() -> None:
    flat = plate(length=0.6, width=0.4, thickness=0.004, n_elements=(3, 2), material=Material(7e10, 2700.0))
    system = assemble(flat)
    at = {node: (x, 0.0, y) for node, (x, y) in flat.nodes.items()}  # upright: its depth is its height
    upright = of_groups([GroupMatrices("all", system.mass, system.stiffness)], flat.dofs, at)
    found = diagnosis()
    outputs = tuple(Dof(node, "Z") for node in (1, 3, 6, 8, 10, 12))
    shown = replace(found.curves, inputs=(Dof(1, "Z"),), outputs=outputs)
    *_, sketch = drawings(replace(found, structure=upright, curves=shown))
    heights = {float(one.get("cy", 0)) for one in sketch.iter("circle")}
    assert len(heights) == 3, "the rows of nodes lie above one another"
