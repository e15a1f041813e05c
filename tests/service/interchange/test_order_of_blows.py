"""Files that hold the blows of a roving hammer in another order than the log book."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.interchange.declared import ExciterKind
from modallab.interchange.measured import MeasuredFile
from modallab.rig.analyser import Analyser
from modallab.rig.hardware import Exciter
from modallab.rig.setup import RigSetup

POINTS = tuple(Dof(n, "Y") for n in (1, 2, 3))
AXIS = Analyser(frequency_max=10.0, n_lines=11)


def file_of(inputs: tuple[Dof, ...]) -> MeasuredFile:
    values = np.ones((11, 1, 1)) * np.array([dof.node for dof in inputs]) + 0j
    return MeasuredFile(FrfSet(AXIS.freq, values, POINTS[:1], inputs, FrfKind.INERTANCE))


def rig(kind: ExciterKind) -> RigSetup:
    return RigSetup(POINTS, POINTS[:1], exciter=Exciter(kind=kind), analyser=AXIS)


@pytest.mark.parametrize("inputs", [POINTS[::-1], POINTS[1:]], ids=["other order", "some"])
def test_the_blows_of_a_file_are_those_of_the_measurement(inputs: tuple[Dof, ...]) -> None:
    found = file_of(inputs).on_rig(rig("hammer"))
    assert found.setup.drives == found.frf.inputs == inputs
    np.testing.assert_array_equal(found.frf.values[0, 0], [dof.node for dof in inputs])


def test_shakers_that_drive_at_once_are_all_in_the_file() -> None:
    with pytest.raises(InvalidInputError, match="drives elsewhere"):
        file_of(POINTS[1:]).on_rig(rig("shaker"))
