"""The log book: what it refuses, and the runs it implies."""

from collections.abc import Callable

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.setup import AcquisitionRun, RigSetup
from tests.rigs import dofs, rig


def test_lines_run_from_zero_hertz_to_the_top() -> None:
    analyser = Analyser(frequency_max=800.0, n_lines=401)
    assert analyser.spacing == 2.0
    assert analyser.record_length == 0.5
    np.testing.assert_array_equal(analyser.freq, 2.0 * np.arange(401))


def test_a_roving_accelerometer_takes_a_run_for_every_response() -> None:
    roving = rig(1, 7, accelerometers=Accelerometers(0.02, roving=True))
    assert roving.acquisition_runs == (
        AcquisitionRun(dofs(1), dofs(1), 0.0, accelerometer_mass=0.02),
        AcquisitionRun(dofs(1), dofs(7), 1.0, accelerometer_mass=0.02),
    )
    assert rig(1, 7).acquisition_runs == (AcquisitionRun(dofs(1), dofs(1, 7)),)


@pytest.mark.parametrize(
    ("field", "make"),
    [
        ("averages", lambda: Analyser(averages=0)),
        ("n_lines", lambda: Analyser(n_lines=7)),
        ("frequency_max", lambda: Analyser(frequency_max=-800.0)),
        ("frequency_max", lambda: Analyser(frequency_max=float("nan"))),
        ("overlap", lambda: Analyser(overlap=0.95)),
        ("excitation.level", lambda: ExcitationSetting(level=0.0)),
        ("armature_mass", lambda: Exciter(armature_mass=-0.01)),
        ("armature_mass", lambda: Exciter(armature_mass=4.6)),
        ("mass_below", lambda: ForceTransducer(mass_below=0.6)),
        ("accelerometers.mass", lambda: Accelerometers(mass=0.6)),
        ("noise.force", lambda: Noise(force=11.0)),
        ("mass_below", lambda: ForceTransducer(mass_below=-0.01)),
        ("accelerometers.mass", lambda: Accelerometers(mass=-0.01)),
        ("noise.force", lambda: Noise(force=-1.0)),
        ("noise.response", lambda: Noise(response=float("inf"))),
        ("responses", lambda: RigSetup(dofs(1), ())),
        ("responses", lambda: RigSetup(dofs(1), (Dof(3, "Y"), Dof(3, "Y", -1)))),
        ("responses", lambda: RigSetup(dofs(1), (Dof(3, "RZ"),))),
        ("drive", lambda: RigSetup((Dof(1, "RZ"),), dofs(3))),
        ("drives", lambda: RigSetup((), dofs(3))),
        ("drives", lambda: RigSetup(dofs(1, 1), dofs(3))),
    ],
)
def test_what_has_no_meaning_is_refused_by_name(field: str, make: Callable[[], object]) -> None:
    with pytest.raises(InvalidInputError) as caught:
        make()
    assert caught.value.context["field"] == field
