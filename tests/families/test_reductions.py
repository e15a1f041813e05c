"""What every reduction must be: a congruence, exact where all DoFs are masters, never too soft."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.reduction import REDUCTIONS, reduce, reduction_of
from modallab.fe.system import DynamicSystem

BEAM = assemble(STRUCTURES["chapter-5-beam"]())
CANTILEVER = assemble(STRUCTURES["cantilever"]())
MASTERS = tuple(Dof(node, "Y") for node in range(3, 22, 2))


@pytest.mark.parametrize("kind", REDUCTIONS)
def test_parameters_have_units_and_defaults_within_bounds(kind: str) -> None:
    reduction = reduction_of(kind)
    assert reduction.kind == kind
    assert reduction.summary
    for name, spec in REDUCTIONS[kind].specs().items():
        assert spec.unit
        assert spec.doc
        assert spec.lower <= reduction.parameters[name] <= spec.upper


@pytest.mark.parametrize("kind", REDUCTIONS)
def test_reduced_matrices_are_the_congruence_of_the_full_ones(kind: str) -> None:
    reduced = reduce(CANTILEVER, MASTERS, reduction_of(kind))
    t = reduced.transformation
    assert t.shape == (len(CANTILEVER.dofs), len(MASTERS))
    for small, full in ((reduced.mass, CANTILEVER.mass), (reduced.stiffness, CANTILEVER.stiffness)):
        np.testing.assert_array_equal(small, small.T)
        size = np.abs(small).max()
        np.testing.assert_allclose(small, t.T @ (full @ t), atol=1e-9 * size)  # rounding
        assert np.linalg.eigvalsh(small)[0] > -1e-9 * size


@pytest.mark.parametrize("kind", REDUCTIONS)
@pytest.mark.parametrize("system", [BEAM, CANTILEVER])
def test_no_frequency_is_below_that_of_the_full_model(kind: str, system: DynamicSystem) -> None:
    reduced, _ = reduce(system, MASTERS, reduction_of(kind)).modes()
    full = system.modes().frequencies
    # Rayleigh and Ritz: fewer motions are a stiffer structure. Rounding: squares of Hz, of the largest one's
    assert (reduced**2 > full[: len(reduced)] ** 2 - 1e-9 * reduced[-1] ** 2).all()


@pytest.mark.parametrize("kind", REDUCTIONS)
def test_with_every_dof_a_master_nothing_is_reduced(kind: str) -> None:
    masters = CANTILEVER.dofs
    reduced, _ = reduce(CANTILEVER, masters, reduction_of(kind)).modes()
    full = CANTILEVER.modes().frequencies[: len(reduced)]
    assert len(reduced) >= 10  # serep keeps what the masters tell apart
    np.testing.assert_allclose(reduced[:10], full[:10], rtol=1e-6)  # rounding; eigenvalues span 1e8


@pytest.mark.parametrize("kind", REDUCTIONS)
def test_masters_may_come_in_any_order_and_sense(kind: str) -> None:
    turned = tuple(Dof(dof.node, dof.direction, -1) for dof in MASTERS[::-1])
    one, other = (reduce(CANTILEVER, masters, reduction_of(kind)) for masters in (MASTERS, turned))
    assert other.masters == MASTERS[::-1]  # coordinates are in the positive sense
    size = np.abs(one.transformation).max()
    np.testing.assert_allclose(
        other.transformation[:, ::-1], one.transformation, atol=1e-9 * size
    )  # rounding


@pytest.mark.parametrize("kind", REDUCTIONS)
def test_what_is_attached_is_reduced_with_the_structure(kind: str) -> None:
    loaded = CANTILEVER.add_mass(21, 0.5).add_oscillator(Dof(11, "Y"), 0.3, 40.0, 0.0)
    reduced, _ = reduce(loaded, (*MASTERS, Dof(11, "RZ")), reduction_of(kind)).modes()
    whole = loaded.folded()
    full = DynamicSystem(mass=whole.mass, stiffness=whole.stiffness, dofs=whole.dofs).modes().frequencies
    # the oscillator's own coordinate is a slave of its foot: statically it does not move against it
    assert reduced[0] == pytest.approx(full[0], rel=1e-2)
    assert len(reduced) >= 3  # serep keeps what the masters tell apart
    assert (reduced > full[: len(reduced)] * (1 - 1e-6)).all()  # rounding


@pytest.mark.parametrize("kind", REDUCTIONS)
def test_wrong_masters_are_named(kind: str) -> None:
    for masters, words in (((), "at least one"), ((MASTERS[0], MASTERS[0]), "once")):
        with pytest.raises(InvalidInputError, match=words) as caught:
            reduce(CANTILEVER, masters, reduction_of(kind))
        assert caught.value.context["field"] == "masters"
    with pytest.raises(InvalidInputError, match="no degree of freedom 99"):
        reduce(CANTILEVER, (Dof(99, "Y"),), reduction_of(kind))


def test_unknown_names_and_numbers_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="no reduction called 'magic'"):
        reduction_of("magic")
    with pytest.raises(InvalidInputError, match="guyan has no parameter 'frequency'"):
        reduction_of("guyan", {"frequency": 3.0})
    with pytest.raises(InvalidInputError, match="out of bounds"):
        reduction_of("dynamic", {"frequency": -1.0})
    for kind, name in (("irs", "iterations"), ("serep", "modes")):
        with pytest.raises(InvalidInputError, match="counted") as caught:
            reduction_of(kind, {name: 2.5})
        assert caught.value.context["field"] == name
