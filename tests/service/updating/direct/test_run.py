"""A direct method run and judged."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.synthetic_modes import ModeNoise, exact_modes, synthetic_modes
from modallab.updating.direct.method import DIRECT_METHODS, DirectOptions
from modallab.updating.direct.result import DirectResult
from modallab.updating.direct.run import update_directly
from tests.service.updating.direct.cases import BEAM, BOTH, STIFFER, SYSTEM, measured, wrong_rows

CORRECTING, LOCATING = ("baruch", "berman_nagy"), ("error_matrix", "modified_error_matrix")


@cache
def run(method: str, n_modes: int = 4) -> DirectResult:
    return update_directly(SYSTEM, method, measured(STIFFER, 8), options=DirectOptions(n_modes=n_modes))


@pytest.mark.parametrize("method", CORRECTING)
def test_modes_that_were_used_are_reproduced_and_the_others_show_how_far_that_holds(method: str) -> None:
    found = run(method)
    assert found.corrects
    assert found.reproduced is not None
    assert found.reproduced < 1e-8
    modes = found.modes
    assert modes.n_used == 4
    assert modes.after is not None
    assert modes.mac_after is not None
    np.testing.assert_allclose(modes.after[:4], modes.measured[:4], rtol=1e-8)
    assert modes.mac_after[:4].min() > 1 - 1e-8
    # what was not used stays about as wrong as it was
    error_before, error_after = (np.abs(x / modes.measured - 1)[4:] for x in (modes.before, modes.after))
    assert error_after.max() > 0.3 * error_before.max()


@pytest.mark.parametrize("method", CORRECTING)
def test_connections_that_the_structure_lacks_are_counted(method: str) -> None:
    found = run(method)
    assert set(found.connectivity_loss) == set(found.errors)
    assert 0.3 < found.connectivity_loss["stiffness"] < 1


@pytest.mark.parametrize("method", CORRECTING)
def test_modes_beyond_those_measured_are_told_before_and_after(method: str) -> None:
    others = run(method).other_modes
    assert others is not None
    assert len(others.before) == len(SYSTEM.dofs) - 4
    assert others.rigid_body is None  # a cantilever has none
    # the highest modes do not see a correction in the lowest
    np.testing.assert_allclose(others.after[-5:], others.before[-5:], rtol=1e-4)


@pytest.mark.parametrize("method", CORRECTING)
def test_a_wrong_mass_holds_rigid_bodies_that_were_free(method: str) -> None:
    free = STRUCTURES["chapter-5-beam"]()
    heavier = change(free, [MemberChange((1, 2), MemberProperty.DENSITY, factor=2.0)])
    stiffer = change(free, [MemberChange((11, 12), MemberProperty.MODULUS, factor=2.0)])
    held = [
        update_directly(assemble(free), method, exact_modes(assemble(truth), 4)).other_modes
        for truth in (heavier, stiffer)
    ]
    assert held[0] is not None
    assert held[1] is not None
    assert held[0].rigid_body is not None
    assert held[1].rigid_body is not None
    assert held[0].rigid_body > 1.0
    assert abs(held[1].rigid_body) < 0.01  # Hz, rounding under the root


@pytest.mark.parametrize("method", LOCATING)
def test_methods_that_locate_leave_the_model_alone(method: str) -> None:
    found = run(method)
    assert not found.corrects
    assert found.mass is None
    assert found.other_modes is None
    assert found.reproduced is None
    for matrix in found.errors:
        ranked = found.ranked(matrix)
        assert sorted(ranked) == sorted(SYSTEM.dofs)
        shares = found.dof_errors[matrix]
        assert shares[SYSTEM.index(ranked[0])] == shares.max()


def test_the_force_balance_ranks_wrong_dofs_first() -> None:
    first = run("modified_error_matrix").ranked("force_balance")
    wrong = wrong_rows(STIFFER, "stiffness")
    assert {SYSTEM.index(dof) for dof in first[: len(wrong)]} == wrong


# One that keeps the members needs all degrees of freedom, and cannot have any modes whatever.
FREE = [method for method in DIRECT_METHODS if method != "eigendynamic_constraint"]


@pytest.mark.parametrize("completion", ["guyan", "dynamic", "irs", "serep", "expansion"])
@pytest.mark.parametrize("method", FREE)
def test_a_method_works_with_some_dofs_measured(method: str, completion: str) -> None:
    sensors = tuple(Dof(node, "Y") for node in range(3, 22, 2))
    noise, rng = ModeNoise(eigenvalue=0.002, eigenvector=0.01), np.random.default_rng(4)
    target = synthetic_modes(assemble(BOTH), 4, sensors, noise=noise, rng=rng)
    found = update_directly(SYSTEM, method, target, options=DirectOptions(completion))
    for table in (*found.errors.values(), *found.dof_errors.values()):
        assert np.isfinite(table).all()
    assert bool(found.connectivity_loss) == (found.corrects and completion == "expansion")
    if found.corrects:
        assert found.modes.after is not None
        # whatever the shapes: these are its modes
        np.testing.assert_allclose(found.modes.after, target.frequencies, rtol=1e-7)


@pytest.mark.parametrize("method", DIRECT_METHODS)
def test_the_scale_of_shapes_is_not_needed_and_missed_by_none(method: str) -> None:
    target = measured(STIFFER, 4)
    modes = tuple(
        replace(mode, shape=mode.shape * (2.0 - r)) for r, mode in enumerate(target.modes) if r != 2
    )
    found = update_directly(SYSTEM, method, replace(target, modes=modes, normalisation="none"))
    assert "no scale" in found.notes[-1]
    # the mass is right, so that its scale is the true one
    scaled = update_directly(SYSTEM, method, replace(target, modes=(*target.modes[:2], target.modes[3])))
    for name, table in scaled.errors.items():
        size = np.abs(getattr(SYSTEM, name).toarray()).max() if name in ("mass", "stiffness") else table.max()
        np.testing.assert_allclose(found.errors[name], table, atol=1e-7 * size)  # rounding


@pytest.mark.parametrize("method", DIRECT_METHODS)
def test_a_model_without_errors_is_found_to_have_none(method: str) -> None:
    found = update_directly(SYSTEM, method, measured(BEAM, 5))
    for shares in found.dof_errors.values():
        assert shares.max() < 1e-5  # rounding: see `test_modified_error_matrix`


@pytest.mark.parametrize(
    ("count", "allowed"), [(0, {"minimum": 1, "maximum": 1000}), (9, {"minimum": 1, "maximum": 8})]
)
def test_more_modes_than_measured_cannot_be_used(count: int, allowed: dict[str, int]) -> None:
    with pytest.raises(InvalidInputError) as caught:
        run("baruch", n_modes=count)
    assert caught.value.context == {"field": "n_modes", "value": count, "allowed": allowed}


def test_progress_is_told_and_may_stop_the_work() -> None:
    class StoppedError(Exception):
        pass

    def stop(fraction: float, message: str) -> None:
        assert message
        if fraction > 0.5:
            raise StoppedError

    with pytest.raises(StoppedError):
        update_directly(SYSTEM, "baruch", measured(BEAM, 3), progress=stop)


def test_a_method_that_is_none_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="no updating method"):
        update_directly(SYSTEM, "guess", measured(BEAM, 3))
