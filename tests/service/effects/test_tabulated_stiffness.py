"""A tabulated stiffness is what its table says: that of a spring, a mass and a damper is theirs."""

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frequency_table import FrequencyTable
from modallab.core.place import EffectSpec
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.ground_spring import GroundSpring
from modallab.effects.local_damping import LocalDamping
from modallab.effects.tabulated_stiffness import TabulatedStiffness
from modallab.rig.chain import chain
from modallab.rig.effect import Effect, build
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, rig

FREQ = np.linspace(2.0, 800.0, 400)
OMEGA = 2 * np.pi * FREQ
PLACE = Dof(7, "Y")


def _frfs(effect: Effect, setup: RigSetup) -> ComplexArray:
    return chain(beam_system(), setup, [effect]).respond(FREQ).inertance


@pytest.mark.parametrize(
    ("known", "values"),
    [
        (GroundSpring(at=PLACE, stiffness=2e4), np.full(len(FREQ), 2e4 + 0j)),
        (ExtraMass(at=PLACE, mass=0.1), -0.1 * OMEGA**2 + 0j),
        (LocalDamping(at=PLACE, damping=30.0), 30j * OMEGA),
    ],
)
def test_the_table_of_a_known_part_acts_as_the_part(known: Effect, values: ComplexArray) -> None:
    setup = rig(1, 7, 16)
    tabulated = TabulatedStiffness(at=PLACE, table=FrequencyTable.of(FREQ, values).rows)
    # two solutions of the same receptances, rounded at resonances
    np.testing.assert_allclose(_frfs(tabulated, setup), _frfs(known, setup), rtol=1e-6)


def test_another_effect_has_no_table() -> None:
    with pytest.raises(InvalidInputError) as caught:
        build(EffectSpec("extra_mass", PLACE, table=((0.0, 1.0, 0.0),)))
    assert caught.value.context["field"] == "effects.table"
