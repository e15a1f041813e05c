"""What every updating method must do."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError, UnderdeterminedError, UnknownDofError
from modallab.core.modal_model import ModalModel
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.fe.structure import Structure
from modallab.fe.synthetic_modes import ModeNoise, synthetic_modes
from modallab.updating.method import UPDATERS, UpdateResult
from modallab.updating.method_options import parts_of
from modallab.updating.options import UpdateOptions
from modallab.updating.parameterisation import Part, parameterise
from modallab.updating.partitioning import automatic_groups

BEAM = STRUCTURES["chapter-5-beam"]()
DOFS = tuple(Dof(node, "Y") for node in range(1, 22, 2))
PARAMETERS = parameterise(automatic_groups(BEAM))


def measured(structure: Structure, dofs: tuple[Dof, ...] = DOFS, seed: int | None = None) -> ModalModel:
    noise = ModeNoise() if seed is None else ModeNoise(eigenvalue=0.002, eigenvector=0.01)
    return synthetic_modes(assemble(structure), 8, dofs, noise=noise, rng=np.random.default_rng(seed))


WRONG = change(BEAM, [MemberChange((9, 10, 11, 12), MemberProperty.MODULUS, factor=1.4)])


def turned(target: ModalModel, step: float) -> ModalModel:
    """The same modes, each turned by so many radians more than the one before."""
    modes = tuple(replace(m, shape=m.shape * np.exp(1j * step * k)) for k, m in enumerate(target.modes))
    return replace(target, modes=modes)


@cache
def updated(kind: str) -> UpdateResult:
    return UPDATERS[kind](BEAM, PARAMETERS, measured(WRONG))


@pytest.mark.parametrize("kind", UPDATERS)
def test_an_update_brings_the_model_to_the_measured_modes(kind: str) -> None:
    result = updated(kind)
    assert result.converged, result.stopped_because
    assert result.frequencies.measured is not None
    # noise-free and within reach of the coefficients: what is left is the tolerance of the last step
    np.testing.assert_allclose(result.frequencies.after, result.frequencies.measured, rtol=1e-4)
    assert (result.mac.after > 0.9999).all()


@pytest.mark.parametrize("kind", UPDATERS)
def test_the_updated_structure_is_the_one_reported(kind: str) -> None:
    result = updated(kind)
    found = assemble(result.structure).modes().elastic(8).frequencies
    np.testing.assert_allclose(found, result.frequencies.after, rtol=1e-9)


@pytest.mark.parametrize("kind", UPDATERS)
def test_a_model_without_errors_stays_as_it_is(kind: str) -> None:
    result = UPDATERS[kind](BEAM, PARAMETERS, measured(BEAM))
    assert result.converged, result.stopped_because
    assert result.suspected == {"mass": (), "stiffness": ()}
    assert result.structure.members == BEAM.members


@pytest.mark.parametrize("kind", UPDATERS)
def test_the_same_modes_give_the_same_numbers(kind: str) -> None:
    again = UPDATERS[kind](BEAM, PARAMETERS, measured(WRONG))
    assert again.coefficients == updated(kind).coefficients


@pytest.mark.parametrize("kind", UPDATERS)
def test_the_sense_of_a_measured_shape_does_not_matter(kind: str) -> None:
    result = UPDATERS[kind](BEAM, PARAMETERS, turned(measured(WRONG), np.pi))
    for part, table in updated(kind).coefficients.items():
        assert result.coefficients[part] == pytest.approx(table, abs=1e-6)  # rounding of the turn


@pytest.mark.parametrize("kind", [kind for kind in UPDATERS if Part.DAMPING not in parts_of(kind)])
def test_the_phase_of_a_measured_shape_does_not_matter_to_a_method_of_real_modes(kind: str) -> None:
    result = UPDATERS[kind](BEAM, PARAMETERS, turned(measured(WRONG), 1.0))
    for part, table in updated(kind).coefficients.items():
        assert result.coefficients[part] == pytest.approx(table, abs=1e-6)  # rounding of the turn


@pytest.mark.parametrize("kind", UPDATERS)
def test_the_phase_of_a_shape_without_a_scale_does_not_matter(kind: str) -> None:
    # phi^T M phi = 1 says the phase of a complex shape, up to its sense: without it none is known
    free = replace(measured(WRONG), normalisation="none")
    results = [UPDATERS[kind](BEAM, PARAMETERS, target) for target in (free, turned(free, 1.0))]
    for part, table in results[0].coefficients.items():
        assert results[1].coefficients[part] == pytest.approx(table, abs=1e-6)  # rounding of the turn


@pytest.mark.parametrize("kind", UPDATERS)
def test_noise_leaves_finite_numbers_and_says_how_sure(kind: str) -> None:
    result = UPDATERS[kind](BEAM, PARAMETERS, measured(WRONG, seed=4))
    for table in (*result.coefficients.values(), *result.standard_errors.values()):
        assert np.isfinite(list(table.values())).all()
    assert result.rank > 0
    assert np.isfinite(result.condition_number)
    told = result.identifiability
    assert told is not None
    assert told.covariance is not None
    for part, ends in result.intervals.items():
        for number, (low, high) in ends.items():
            assert low < high, (part, number)
    assert result.stopped_because


@pytest.mark.parametrize("kind", UPDATERS)
def test_progress_is_told_and_may_stop_the_work(kind: str) -> None:
    class StoppedError(Exception):
        pass

    told: list[float] = []

    def stop(fraction: float, message: str) -> None:
        assert message
        told.append(fraction)
        if len(told) == 2:
            raise StoppedError

    with pytest.raises(StoppedError):
        UPDATERS[kind](BEAM, PARAMETERS, measured(WRONG), progress=stop)
    assert 0 < told[0] <= told[1] <= 1


@pytest.mark.parametrize("kind", UPDATERS)
def test_what_cannot_be_updated_is_refused(kind: str) -> None:
    update, target = UPDATERS[kind], measured(WRONG)
    few = replace(target, modes=target.modes[:1], dofs=DOFS)
    every = parameterise([(n,) for n in range(1, 21)])
    with pytest.raises(UnderdeterminedError):
        update(BEAM, every, few)
    with pytest.raises(UnknownDofError):
        update(BEAM, PARAMETERS, replace(target, dofs=(Dof(99, "Y"), *DOFS[1:])))
    with pytest.raises(InvalidInputError):
        update(BEAM, PARAMETERS, replace(target, modes=()))
    with pytest.raises(UnderdeterminedError, match="no measured number moves"):  # bending stretches nothing
        update(BEAM, parameterise(automatic_groups(BEAM), ("axial",)), target)
    unlike = replace(target.modes[3], shape=np.array([1, 0, 0, 1, 0, 0, -1, 0, 0, -1, 0j]))
    with pytest.raises(UnderdeterminedError, match="mode 4"):
        update(BEAM, PARAMETERS, replace(target, modes=(*target.modes[:3], unlike)))


@pytest.mark.parametrize("kind", UPDATERS)
def test_an_update_that_may_not_finish_says_so(kind: str) -> None:
    result = UPDATERS[kind](BEAM, PARAMETERS, measured(WRONG), options=UpdateOptions(max_iterations=1))
    assert not result.converged
    assert len(result.history) >= 1


@pytest.mark.parametrize("kind", UPDATERS)
def test_a_method_says_what_it_is(kind: str) -> None:
    assert (UPDATERS[kind].__doc__ or "").strip()
