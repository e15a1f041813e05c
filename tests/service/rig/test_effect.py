"""What effects say of themselves."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.rig.chain import chain
from modallab.rig.effect import EFFECTS, Effect
from tests.rigs import beam_system, rig

MORE = [cls for cls in EFFECTS.values() if cls.nested_kind is not None]


@pytest.mark.parametrize("cls", MORE, ids=lambda cls: cls.kind)
def test_without_its_further_numbers_an_effect_is_the_plainer_one(cls: type[Effect]) -> None:
    own = cls(at=Dof(4, "Y"))
    simpler = own.reduced_model()
    assert simpler is not None
    plain, more = simpler
    assert plain.kind == cls.nested_kind

    def seen(effect: Effect) -> np.ndarray:
        return chain(beam_system(), rig(2, 4), [effect]).respond(np.linspace(1.0, 200.0, 20)).inertance

    nothing = own.with_parameters(dict.fromkeys(more, 0.0))
    np.testing.assert_allclose(seen(nothing), seen(plain), rtol=1e-9)  # the same sums, rounding
    assert not np.allclose(seen(own), seen(plain), rtol=1e-6)


def test_most_effects_are_more_than_no_other() -> None:
    assert {cls.kind for cls in MORE} == {"suspension", "cable_mass"}
    assert EFFECTS["extra_mass"](at=Dof(4, "Y")).reduced_model() is None
