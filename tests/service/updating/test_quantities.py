"""Properties found by an update, in the units that they have."""

from functools import cache

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.damping import StructuralDamping
from modallab.fe.imported_elements import GroupMatrices, of_groups
from modallab.fe.plate import plate
from modallab.fe.structure import Material
from modallab.fe.synthetic_modes import ModeNoise
from modallab.updating.method import UPDATERS, UpdateResult
from modallab.updating.options import UpdateOptions
from modallab.updating.parameterisation import Part, parameterise
from modallab.updating.partitioning import automatic_groups
from modallab.updating.quantities import Quantity, quantities
from tests.service.updating.cases import BAY, BAY_DOFS, BEAM, BEAM_DOFS, modes_of

P = MemberProperty
EXACT = 1e-6  # noise-free modes: rounding, times the condition of the equations
PLATE = plate(
    length=0.4,
    width=0.3,
    thickness=0.004,
    n_elements=(6, 5),
    material=Material(2.09e11, 7800.0),
    damping=StructuralDamping(0.01),
)
STRIPS = [tuple(range(first, first + 6)) for first in range(1, 31, 6)]
PLATE_DOFS = tuple(Dof(node, "Z") for node in range(1, 43, 3))
THICKER = change(
    PLATE,
    [
        MemberChange(STRIPS[1], P.THICKNESS, factor=1.4),
        MemberChange(STRIPS[3], P.THICKNESS, value=0.0032),
    ],
)


@cache
def of_plate(method: str) -> UpdateResult:
    options = UpdateOptions(tolerance=1e-9)
    target = modes_of(THICKER, 8, PLATE_DOFS)
    return UPDATERS[method](PLATE, parameterise(STRIPS, ("thickness",)), target, options=options)


@pytest.mark.parametrize("method", ["inverse_eigensensitivity", "one_shot"])
def test_density_and_modulus_of_bars_of_the_bay_are_found(method: str) -> None:
    wrong = [
        MemberChange((25, 26), P.DENSITY, factor=1.5),
        MemberChange((12, 13, 31), P.MODULUS, factor=2.0),
    ]
    each = [(member.number,) for member in BAY.members]
    groups = each if method == "one_shot" else automatic_groups(BAY)
    target = modes_of(change(BAY, wrong), 10, BAY_DOFS)
    parameters = parameterise(groups, ("density", "modulus"))
    result = UPDATERS[method](BAY, parameters, target, options=UpdateOptions(tolerance=1e-8))
    assert result.converged, result.stopped_because
    for part, numbers, factor in (("density", (25, 26), 1.5), ("modulus", (12, 13, 31), 2.0)):
        for number, found in result.coefficients[part].items():
            assert found == pytest.approx(factor if number in numbers else 1.0, abs=EXACT)
    stiffer = next(one for one in result.quantities if (one.part, one.members) == ("modulus", (31,)))
    assert (stiffer.unit, stiffer.before) == ("N/m^2", 7.5e10)
    assert stiffer.after == pytest.approx(1.5e11, rel=EXACT)


def test_area_and_second_moment_of_bars_of_the_bay_are_found_at_once() -> None:
    wrong = [
        MemberChange((25, 26), P.AREA, factor=1.5),
        MemberChange((12, 13, 31), P.SECOND_MOMENT, factor=2.0),
    ]
    truth = change(BAY, wrong)
    parameters = parameterise([(m.number,) for m in BAY.members], ("area", "second_moment"))
    result = UPDATERS["one_shot"](BAY, parameters, modes_of(truth, 10, BAY_DOFS))
    assert result.suspected == {"area": (25, 26), "second_moment": (12, 13, 31)}
    for ours, theirs in zip(result.structure.members, truth.members, strict=True):
        assert ours.section.area == pytest.approx(theirs.section.area, rel=EXACT)
        assert ours.section.second_moment == pytest.approx(theirs.section.second_moment, rel=EXACT)
        assert (ours.mass_factor, ours.axial_factor, ours.bending_factor) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize("method", UPDATERS)
def test_the_thickness_of_parts_of_a_plate_is_found_by_every_method(method: str) -> None:
    result = of_plate(method)
    assert result.converged, result.stopped_because
    assert set(result.suspected["thickness"]) & {n for i in (1, 3) for n in STRIPS[i]}
    for number, found in result.coefficients["thickness"].items():
        factor = 1.4 if number in STRIPS[1] else 0.8 if number in STRIPS[3] else 1.0
        assert found == pytest.approx(factor, abs=EXACT)
    for ours, theirs in zip(result.structure.non_bar_members, THICKER.non_bar_members, strict=True):
        assert ours.thickness == pytest.approx(theirs.thickness, rel=EXACT)  # type: ignore[union-attr]


def test_a_thickness_is_no_modulus_and_no_density() -> None:
    # bending goes by t^3 and mass by t: no other property of a strip moves both so
    parameters = parameterise(STRIPS, ("thickness", "modulus", "density"))
    result = UPDATERS["one_shot"](PLATE, parameters, modes_of(THICKER, 8, PLATE_DOFS))
    assert result.suspected == {
        "thickness": tuple(sorted(STRIPS[1] + STRIPS[3])),
        "modulus": (),
        "density": (),
    }
    assert result.rank == 15


def test_a_quantity_has_its_unit_and_an_interval_that_holds_the_truth() -> None:
    noise = ModeNoise(eigenvalue=0.002, eigenvector=0.01)
    target = modes_of(THICKER, 8, PLATE_DOFS, noise, seed=1)
    result = UPDATERS["one_shot"](PLATE, parameterise(STRIPS, ("thickness",)), target)
    assert [one.members for one in result.quantities] == STRIPS
    for one, true in zip(result.quantities, (0.004, 0.0056, 0.004, 0.0032, 0.004), strict=True):
        assert (one.part, one.unit, one.before) == ("thickness", "m", 0.004)
        assert one.after == pytest.approx(true, rel=0.02)
        assert one.interval is not None
        low, high = one.interval
        assert low < true < high < 1.1 * low


def test_density_and_area_of_what_only_bends_cannot_be_told_apart() -> None:
    groups = [tuple(range(first, first + 4)) for first in range(1, 21, 4)]
    truth = change(BEAM, [MemberChange(groups[0], P.DENSITY, factor=1.5)])
    parameters = parameterise(groups, ("density", "area"))
    result = UPDATERS["one_shot"](BEAM, parameters, modes_of(truth, 8, BEAM_DOFS))
    assert result.rank == 5
    assert result.identifiability is not None
    words = {one.words for one in result.identifiability.directions}
    assert words == {f"density and area of {g[0]}-{g[-1]} cannot be told apart by these data" for g in groups}
    product = result.coefficients["density"][1] * result.coefficients["area"][1]
    assert product == pytest.approx(1.5, abs=EXACT)


def test_second_moment_and_modulus_are_named_in_words() -> None:
    groups = [tuple(range(first, first + 4)) for first in range(1, 21, 4)]
    parameters = parameterise(groups, ("modulus", "second_moment"))
    result = UPDATERS["one_shot"](BEAM, parameters, modes_of(BEAM, 8, BEAM_DOFS))
    assert result.identifiability is not None
    words = [one.words for one in result.identifiability.directions]
    assert "modulus and second moment of 1-4 cannot be told apart by these data" in words


def test_a_value_that_members_do_not_share_is_left_out() -> None:
    parameters = parameterise([(1, 2), (3, 4)], ("density", "modulus"))
    heavier = change(
        BAY,
        [MemberChange((2,), P.DENSITY, factor=1.5), MemberChange((3, 4), P.AXIAL_STIFFNESS, factor=2.0)],
    )
    values = np.array([1.1, 1.2, 1.3, 1.4])
    density, modulus = BAY.members[0].material.density, BAY.members[0].material.modulus
    assert quantities(heavier, parameters, values) == (
        Quantity(parameters.macros[1].part, (3, 4), "kg/m^3", density, density * 1.2, None),
        Quantity(parameters.macros[2].part, (1, 2), "N/m^2", modulus, modulus * 1.3, None),
    )


def test_members_given_by_matrices_have_multiples_and_no_units() -> None:
    clamped = STRUCTURES["cantilever"]()
    system, every = assemble(clamped), tuple(member.number for member in clamped.members)
    given = of_groups([GroupMatrices("all", system.mass, system.stiffness)], system.dofs)
    target = modes_of(change(clamped, [MemberChange(every, P.MODULUS, factor=1.3)]), 4, BEAM_DOFS[1:])
    result = UPDATERS["one_shot"](given, parameterise([given.groups["all"]], ("modulus",)), target)
    assert result.coefficients["modulus"][1] == pytest.approx(1.3, abs=EXACT)
    assert result.quantities == ()


def test_the_change_is_relative_to_the_value_before_and_undetermined_from_zero() -> None:
    assert Quantity(Part.AREA, (1,), "m^2", 2e-4, 2.5e-4, None).change == pytest.approx(
        0.25, rel=1e-12
    )  # rounding
    assert np.isnan(Quantity(Part.AREA, (1,), "m^2", 0.0, 1e-4, None).change)
