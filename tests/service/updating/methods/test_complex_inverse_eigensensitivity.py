"""Inverse eigensensitivity from complex modes: it finds hidden damping, and says what it cannot."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError, UnderdeterminedError
from modallab.core.modal_model import ModalModel
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import Distribution, ModeNoise
from modallab.updating.method import UPDATERS, UpdateResult
from modallab.updating.method_options import parts_of
from modallab.updating.methods.complex_inverse_eigensensitivity import complex_inverse_eigensensitivity
from modallab.updating.options import ComplexTwoStageOptions
from modallab.updating.parameterisation import parameterise
from modallab.updating.partitioning import automatic_groups
from tests.service.updating.cases import BAY, BAY_DOFS, BEAM, BEAM_DOFS, WRONG_BAY, modes_of

ALL = ("mass", "stiffness", "damping")
FOURS = [tuple(range(i, i + 4)) for i in range(1, 21, 4)]
LOSSY = MemberChange((11, 12), MemberProperty.LOSS_FACTOR, value=0.15)
JOINT = [
    MemberChange((1, 2), MemberProperty.DENSITY, factor=1.5),
    MemberChange((11, 12), MemberProperty.MODULUS, factor=1.5),
    LOSSY,
]


def moved(result: UpdateResult, part: str, unchanged: float) -> dict[int, float]:
    # 1e-6: noise-free, it converges quadratically below the tolerance of its last step, 1e-4
    return {n: v for n, v in result.coefficients[part].items() if abs(v - unchanged) > 1e-6}


@pytest.mark.parametrize("name", ["chapter-5-beam", "cantilever"])
def test_a_lossy_place_is_found_in_a_structure_that_is_damped_all_over(name: str) -> None:
    structure = STRUCTURES[name]()  # D = aM + bK, b = 0.005
    dofs = BEAM_DOFS[1:]
    result = complex_inverse_eigensensitivity(
        structure, parameterise(FOURS, ALL), modes_of(change(structure, JOINT), 8, dofs)
    )
    assert result.converged, result.stopped_because
    assert moved(result, "mass", 1.0) == pytest.approx({1: 1.5, 2: 1.5}, abs=1e-6)
    assert moved(result, "stiffness", 1.0) == pytest.approx({11: 1.5, 12: 1.5}, abs=1e-6)
    assert moved(result, "damping", 0.0) == pytest.approx({11: 0.145, 12: 0.145}, abs=1e-6)
    again = modes_of(result.structure, 8, dofs)
    wanted = modes_of(change(structure, JOINT), 8, dofs)
    np.testing.assert_allclose(again.loss_factors, wanted.loss_factors, rtol=1e-6)


def test_axial_and_bending_stiffness_stand_beside_damping() -> None:
    wrong = [
        MemberChange((5, 6, 7), MemberProperty.AXIAL_STIFFNESS, factor=1.3),
        MemberChange((8, 9, 10), MemberProperty.BENDING_STIFFNESS, factor=0.8),
        MemberChange((8, 9, 10), MemberProperty.LOSS_FACTOR, value=0.1),
    ]
    parameters = parameterise(automatic_groups(BAY), ("axial", "bending", "damping"))
    result = complex_inverse_eigensensitivity(BAY, parameters, modes_of(change(BAY, wrong), 10, BAY_DOFS))
    assert result.converged, result.stopped_because
    assert moved(result, "axial", 1.0) == pytest.approx(dict.fromkeys((5, 6, 7), 1.3), abs=1e-5)
    assert moved(result, "bending", 1.0) == pytest.approx(dict.fromkeys((8, 9, 10), 0.8), abs=1e-5)
    assert moved(result, "damping", 0.0) == pytest.approx(dict.fromkeys((8, 9, 10), 0.1), abs=1e-5)


def test_without_coefficients_of_damping_it_stays_as_it_is() -> None:
    stiffer = change(BEAM, [MemberChange((5, 6, 7, 8), MemberProperty.MODULUS, factor=1.4)])
    parameters = parameterise(FOURS, ("mass", "stiffness"))
    result = complex_inverse_eigensensitivity(BEAM, parameters, modes_of(stiffer, 8, BEAM_DOFS))
    assert moved(result, "stiffness", 1.0) == pytest.approx(dict.fromkeys((5, 6, 7, 8), 1.4), abs=1e-6)
    assert [m.loss_factor for m in result.structure.members] == [m.loss_factor for m in BEAM.members]


def noisy(structure: Structure, seed: int) -> ModalModel:
    """Return noisy modes that know the errors of their loss factors and phases."""
    exact = modes_of(structure, 8, BEAM_DOFS)
    rng = np.random.default_rng(seed)
    modes = []
    for mode in exact.modes:
        size = 0.003 * np.abs(mode.shape).max()
        parts = rng.normal(0, size, (2, len(mode.shape)))
        modes.append(
            replace(
                mode,
                frequency=mode.frequency * (1 + rng.normal(0, 5e-4)),
                loss_factor=mode.loss_factor + rng.normal(0, 5e-4),
                shape=mode.shape + parts[0] + 1j * parts[1],
                standard_errors={"frequency": 5e-4 * mode.frequency, "loss_factor": 5e-4},
                shape_errors=np.full(len(mode.shape), size),
            )
        )
    return replace(exact, modes=tuple(modes))


def test_standard_errors_of_loss_factors_are_the_scatter_of_repeated_tests() -> None:
    parameters = parameterise([(9, 10), (11, 12), (13, 14)], ("stiffness", "damping"))
    options = ComplexTwoStageOptions(suspect_threshold=0.0, damping_threshold=0.0)
    lossy = change(BEAM, [LOSSY])
    found = [
        complex_inverse_eigensensitivity(BEAM, parameters, noisy(lossy, seed), options=options)
        for seed in range(40)
    ]
    values = np.array([[r.coefficients["damping"][m] for m in (9, 11, 13)] for r in found])
    stated = np.array([[r.standard_errors["damping"][m] for m in (9, 11, 13)] for r in found])
    ratio = values.std(axis=0, ddof=1) / np.sqrt((stated**2).mean(axis=0))
    # the scatter of 40 draws is itself known to 1/sqrt(2 * 39) = 11 %: three of these
    np.testing.assert_allclose(ratio, 1.0, atol=0.34)


def test_loss_factors_below_zero_are_told() -> None:
    noise = ModeNoise(eigenvalue=0.005, eigenvector=0.05, distribution=Distribution.UNIFORM)
    lossy = change(WRONG_BAY, [MemberChange((1, 2), MemberProperty.LOSS_FACTOR, value=0.05)])
    groups = parameterise(automatic_groups(BAY), ALL)
    result = complex_inverse_eigensensitivity(BAY, groups, modes_of(lossy, 10, BAY_DOFS, noise, seed=0))
    below = [n for n, value in result.coefficients["damping"].items() if value < -1e-4]
    assert below
    assert f"{len(below)} loss factors came out below zero" in result.stopped_because
    at_zero = {m.number for m in result.structure.members if m.loss_factor == 0.0}
    assert set(below) <= at_zero
    assert assemble(result.structure).modes().elastic(10).loss_factors.min() > 0


def test_the_usual_parts_hold_damping() -> None:
    assert parts_of("complex_inverse_eigensensitivity") == ALL
    assert parts_of("inverse_eigensensitivity") == ("mass", "stiffness")


def test_real_modes_are_refused_by_the_complex_method_and_complex_ones_by_the_real() -> None:
    heavy = change(WRONG_BAY, [MemberChange((1, 2), MemberProperty.LOSS_FACTOR, value=0.3)])
    groups = automatic_groups(BAY)
    with pytest.raises(InvalidInputError, match="the modes are real"):
        complex_inverse_eigensensitivity(BAY, parameterise(groups, ALL), modes_of(WRONG_BAY, 10, BAY_DOFS))
    with pytest.raises(InvalidInputError, match="is complex"):
        UPDATERS["inverse_eigensensitivity"](BAY, parameterise(groups), modes_of(heavy, 10, BAY_DOFS))


def test_more_coefficients_than_measured_numbers_are_refused() -> None:
    each = parameterise([(n,) for n in range(1, 21)], ALL)
    with pytest.raises(UnderdeterminedError) as caught:
        complex_inverse_eigensensitivity(BEAM, each, modes_of(change(BEAM, [LOSSY]), 3, BEAM_DOFS[:4]))
    # three modes of one frequency, one loss factor, four complex entries each
    assert caught.value.context == {"field": "macros", "value": 60, "allowed": {"maximum": 30}}
