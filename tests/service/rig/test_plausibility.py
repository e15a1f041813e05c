"""Slips of units and settings are named; what is built and tested is not."""

from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from modallab.api.structures.schemas import StructureIn
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.structure import Structure
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.measurement import Measurement
from modallab.rig.plausibility import measurement_warnings, rig_warnings, structure_warnings
from modallab.rig.setup import RigSetup

DRIVE = Dof(1, "Y")
STEEL = {"modulus": 2.1e11, "density": 7800.0}
BAR = {"area": 5e-4, "second_moment": 4.2e-9}
SHEET = {"kind": "plate", "length": 0.6, "width": 0.4, "thickness": 0.004, "n_elements": [4, 3]}


def beam(length: float = 1.5, section: Any = BAR, material: Any = STEEL) -> Structure:
    return described(
        {"kind": "beam", "length": length, "n_elements": 10, "section": section, "material": material}
    )


def described(body: Any) -> Structure:
    structure: Structure = TypeAdapter[Any](StructureIn).validate_python(body).to_domain()
    return structure


@pytest.mark.parametrize("name", list(STRUCTURES))
def test_no_structure_of_the_catalogue_is_warned_of(name: str) -> None:
    assert structure_warnings(described({"kind": "catalogue", "name": name})) == ()


@pytest.mark.parametrize(
    ("modulus", "density"),
    [
        (2.1e11, 7800.0),  # steel
        (7.0e10, 2700.0),  # aluminium
        (1.6e10, 11340.0),  # lead
        (1.1e12, 3510.0),  # diamond
        (1.0e6, 1100.0),  # soft rubber
        (5.0e6, 15.0),  # expanded polystyrene
        (1.1e10, 450.0),  # spruce
    ],
)
def test_no_solid_is_warned_of(modulus: float, density: float) -> None:
    assert structure_warnings(beam(material={"modulus": modulus, "density": density})) == ()


@pytest.mark.parametrize(
    ("structure", "code", "field"),
    [
        (beam(material=STEEL | {"modulus": 209.0}), "modulus", "modulus"),
        (beam(material=STEEL | {"modulus": 209e3}), "wave_speed", "modulus"),
        (beam(material=STEEL | {"density": 7.8}), "density", "density"),
        (beam(material=STEEL | {"density": 7.8e-9}), "density", "density"),
        (beam(length=1200.0), "extent", "length"),
        (beam(length=1.2e-3), "first_frequency", "length"),
        (beam(section=BAR | {"area": 500.0}), "section", "second_moment"),
        (beam(section=BAR | {"second_moment": 4200.0}), "section", "second_moment"),
        (described(SHEET | {"material": STEEL, "thickness": 4.0}), "thickness", "thickness"),
        (described(SHEET | {"material": STEEL, "length": 600.0, "width": 400.0}), "extent", "length"),
    ],
)
def test_a_slip_of_a_unit_is_named_once_with_its_field(structure: Structure, code: str, field: str) -> None:
    (warning,) = structure_warnings(structure)
    assert (warning.code, warning.field) == (code, field)
    assert "?" in warning.message  # it asks, and refuses nothing


def rig(**analyser: Any) -> RigSetup:
    return RigSetup(drives=(DRIVE,), responses=(DRIVE,), analyser=Analyser(**analyser))


def test_settings_with_which_a_test_says_nothing_are_named() -> None:
    between_lines = ExcitationSetting("random", band=(100.5, 101.5))
    cases = {
        "one_average": rig(averages=1),
        "band_without_lines": rig(frequency_max=800.0, n_lines=401, excitation=between_lines),
        "top_frequency": rig(frequency_max=0.8),
    }
    for code, setup in cases.items():
        assert [warning.code for warning in rig_warnings(setup)] == [code]
    assert rig_warnings(rig()) == ()
    assert rig_warnings(rig(averages=2)) == ()


def measured(averages: float, setup: RigSetup) -> Measurement:
    freq = np.linspace(10.0, 20.0, 11)
    frf = FrfSet(freq, np.ones((11, 1, 1), complex), (DRIVE,), (DRIVE,), FrfKind.INERTANCE)
    return Measurement(frf, np.full((11, 1), 0.9), averages, setup)


def test_one_average_is_named_whether_rig_or_file_states_it() -> None:
    by_rig, by_file = measured(1.0, rig(averages=1)), measured(1.0, rig(averages=None))
    assert [w.field for w in measurement_warnings(by_rig)] == ["analyser.averages"]
    assert [w.field for w in measurement_warnings(by_file)] == ["averages"]
    assert measurement_warnings(measured(9.7, rig(averages=10))) == ()
