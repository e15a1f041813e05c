"""Every effect that could sit in a test of a plate, or of an imported model, can be measured there."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.place import EffectSpec
from modallab.fe.assembly import assemble
from modallab.fe.damping import StructuralDamping
from modallab.fe.imported_elements import GroupMatrices, of_groups
from modallab.fe.plate import plate
from modallab.fe.structure import Material, Structure
from modallab.rig.analyser import Analyser
from modallab.rig.effect import EFFECTS, build
from modallab.rig.hardware import Accelerometers
from modallab.rig.measure import Route, measure
from modallab.rig.setup import RigSetup

LOSSY = StructuralDamping(0.01)
PLATE = plate(
    length=0.6, width=0.4, thickness=0.004, n_elements=(3, 2), material=Material(2e11, 7800.0), damping=LOSSY
)
_SYSTEM = assemble(PLATE)
IMPORTED = of_groups([GroupMatrices("all", _SYSTEM.mass, _SYSTEM.stiffness)], PLATE.dofs, damping=LOSSY)
RESPONSES = tuple(Dof(node, "Z") for node in (1, 4, 12))
SETUP = RigSetup(
    drives=RESPONSES[:1],
    responses=RESPONSES,
    accelerometers=Accelerometers(mass=0.01, roving=True),
    analyser=Analyser(frequency_max=300.0, n_lines=61, averages=10),
)
WEAK = {"cubic_stiffness": {"stiffness": 1.0}}  # its default is too strong for a straight line


@pytest.mark.parametrize("kind", EFFECTS)
@pytest.mark.parametrize("structure", [PLATE, IMPORTED], ids=["plate", "imported"])
def test_an_effect_acts_where_it_says_that_it_could(structure: Structure, kind: str) -> None:
    for at in EFFECTS[kind].places(assemble(structure), SETUP)[:1]:
        effect = build(EffectSpec(kind, at, WEAK.get(kind, {})))
        effect.check(structure, SETUP)
        found = measure(structure, SETUP, [effect], route=Route.EXPECTED, rng=np.random.default_rng(0))
        assert np.isfinite(found.frf.values).all()
        if effect.structural:
            assert effect.added_to(structure).dofs == structure.dofs


@pytest.mark.parametrize("kind", ["joint_flexibility", "misplaced_accelerometer"])
def test_what_needs_bars_could_be_nowhere(kind: str) -> None:
    assert not EFFECTS[kind].places(assemble(PLATE), SETUP)
