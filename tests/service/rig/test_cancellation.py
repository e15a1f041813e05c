"""Mass cancellation by the analyser."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.effects.gain_error import GainError
from modallab.fe.assembly import assemble
from modallab.fe.structure import PointMass
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Accelerometers, ForceTransducer
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, rig, steel_beam, tilted_beam

FREQ = np.linspace(2.0, 800.0, 57)
MASS = 0.03
FIXED = rig(1, 7, 16, accelerometers=Accelerometers(MASS), analyser={"mass_cancellation": MASS})


def near(found: np.ndarray, wanted: np.ndarray) -> None:
    """Equal up to the rounding of two solutions: 1e-16 times the ratio of the beam's eigenvalues, 1e6."""
    np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-9 * np.abs(wanted).max())


def test_at_the_drive_point_it_leaves_what_the_structure_has_without_the_mass() -> None:
    others = assemble(steel_beam(masses=(PointMass(7, MASS), PointMass(16, MASS))))
    wanted = chain(others, rig(1, 7, 16)).respond(FREQ).inertance
    near(chain(beam_system(), FIXED).respond(FREQ).inertance, wanted)


def test_it_is_the_correction_known_from_text_books() -> None:
    """H = H'/(1 - m H') at the drive point, Ewins, Modal Testing (2000), section 3.7."""
    loaded = replace(FIXED, analyser=replace(FIXED.analyser, mass_cancellation=0.0))
    raw, found = (chain(beam_system(), one).respond(FREQ).inertance[0, :, 0, 0] for one in (loaded, FIXED))
    near(found, raw / (1 - MASS * raw))


def test_gauge_and_accelerometer_go_in_one() -> None:
    heavy = replace(
        FIXED,
        force_transducer=ForceTransducer(mass_below=0.02),
        analyser=replace(FIXED.analyser, mass_cancellation=MASS + 0.02),
    )
    near(
        chain(beam_system(), heavy).respond(FREQ).inertance,
        chain(beam_system(), FIXED).respond(FREQ).inertance,
    )


def test_a_roving_accelerometer_is_cancelled_in_the_run_that_hears_the_drive_point_alone() -> None:
    roving = replace(FIXED, accelerometers=Accelerometers(MASS, roving=True))
    raw = replace(roving, analyser=replace(roving.analyser, mass_cancellation=0.0))
    found, loaded = (chain(beam_system(), one).respond(FREQ).inertance for one in (roving, raw))
    bare = chain(beam_system(), rig(1, 7, 16)).respond(FREQ).inertance
    near(found[0], bare[:, :, :1][0])
    np.testing.assert_array_equal(found[1:], loaded[1:])


@pytest.mark.parametrize("drive", [Dof(1, "Y"), Dof(1, "Y", -1)])
@pytest.mark.parametrize("response", [Dof(1, "Y"), Dof(1, "Y", -1)])
def test_the_senses_of_gauge_and_accelerometer_are_minded(drive: Dof, response: Dof) -> None:
    setup = RigSetup((drive,), (response,), accelerometers=Accelerometers(MASS), analyser=FIXED.analyser)
    sense = drive.sign * response.sign
    near(
        chain(beam_system(), setup).respond(FREQ).inertance,
        sense * chain(beam_system(), rig(1)).respond(FREQ).inertance,
    )


def test_an_accelerometer_that_reads_wrong_leaves_or_takes_too_much() -> None:
    shown = chain(beam_system(), FIXED, [GainError(factor=0.9)]).respond(FREQ).inertance[0, :, 0, 0]
    left = assemble(steel_beam(masses=(PointMass(1, 0.1 * MASS), PointMass(7, MASS), PointMass(16, MASS))))
    near(shown / 0.9, chain(left, rig(1)).respond(FREQ).inertance[0, :, 0, 0])


def test_what_the_mass_does_across_the_gauge_stays() -> None:
    setup = rig(1, accelerometers=Accelerometers(0.3), analyser={"mass_cancellation": 0.3})
    tilted = assemble(tilted_beam())
    found = chain(tilted, setup).respond(FREQ).inertance
    bare = chain(tilted, rig(1)).respond(FREQ).inertance
    assert np.abs(found / bare - 1).max() > 0.1


def test_the_force_spectrum_is_that_of_the_force_left() -> None:
    raw = replace(FIXED, analyser=replace(FIXED.analyser, mass_cancellation=0.0))
    whole, left = (expected_spectra(chain(beam_system(), one)) for one in (raw, FIXED))
    h = chain(beam_system(), raw).respond(raw.analyser.freq).inertance[0, :, 0, 0]
    near(left.ff[0, :, 0, 0], whole.ff[0, :, 0, 0] * np.abs(1 - MASS * h) ** 2)
