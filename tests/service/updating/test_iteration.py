"""How an update ends, for readers: first of all whether it corrected anything."""

import pytest

from modallab.fe.assembly import assemble
from modallab.fe.changes import MemberChange, MemberProperty, change
from modallab.updating.direct.run import update_directly
from modallab.updating.error_location.run import locate
from modallab.updating.iteration import StopReason, stated_end
from modallab.updating.method import UPDATERS
from modallab.updating.parameterisation import parameterise
from tests.service.updating.cases import BEAM, BEAM_DOFS, modes_of

EACH = parameterise([(n,) for n in range(1, 21)])
EXACT = modes_of(BEAM, 8, BEAM_DOFS)
HEAVIER = modes_of(change(BEAM, [MemberChange((7, 8), MemberProperty.DENSITY, factor=1.5)]), 8, BEAM_DOFS)


@pytest.mark.parametrize("method", ["inverse_eigensensitivity", "one_shot"])
def test_an_update_of_a_model_without_errors_begins_with_its_outcome(method: str) -> None:
    result = UPDATERS[method](BEAM, EACH, EXACT)
    assert result.stopped_because.startswith(StopReason.UNCHANGED)
    assert set(result.coefficients["mass"].values()) == {1.0}
    corrected = UPDATERS[method](BEAM, EACH, HEAVIER)
    assert corrected.stopped_because.startswith(StopReason.CONVERGED)


@pytest.mark.parametrize("method", ["baruch", "berman_nagy"])
def test_a_direct_method_on_the_modes_of_the_model_corrects_nothing(method: str) -> None:
    everywhere = modes_of(BEAM, 4, BEAM.dofs)
    assert update_directly(assemble(BEAM), method, everywhere).stopped_because.startswith(
        StopReason.UNCHANGED
    )
    wrong = modes_of(change(BEAM, [MemberChange((7, 8), MemberProperty.DENSITY, factor=1.5)]), 4, BEAM.dofs)
    assert update_directly(assemble(BEAM), method, wrong).stopped_because.startswith(StopReason.SOLVED)


def test_an_error_location_without_suspects_says_that_none_is_located() -> None:
    assert locate(BEAM, EACH, "zhang_sensitivity", EXACT).stopped_because == StopReason.NOT_LOCATED
    assert locate(BEAM, EACH, "zhang_sensitivity", HEAVIER).stopped_because == StopReason.LOCATED


def test_a_diverged_path_is_named_before_its_outcome() -> None:
    nominal = EACH.nominal
    diverged = f"{StopReason.DIVERGED}: a mode was lost"
    assert stated_end(diverged, EACH, nominal, 1e-4) == f"{diverged}; {StopReason.UNCHANGED}"
    assert stated_end(diverged, EACH, nominal + 2e-4, 1e-4) == diverged
    # changes below the tolerance are those of a path that has converged, not corrections
    assert stated_end("converged", EACH, nominal + 5e-5, 1e-4).startswith(StopReason.UNCHANGED)
