"""The armature takes the force at resonances: the thesis's figure 5.15 as a law, on the beam of table 5.4."""

from functools import cache

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.fe.assembly import assemble
from modallab.rig.chain import chain
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer
from modallab.rig.setup import RigSetup
from tests.published.roving import DOFS, hidden_beam
from tests.published.tables import table

BEAM = table("beam_1992")["beam"]
SYSTEM = assemble(hidden_beam())
HARDWARE = {
    "force_transducer": ForceTransducer(BEAM["force_transducer_mass"]),
    "accelerometers": Accelerometers(BEAM["accelerometer_mass"]),
}


def rig(armature: float) -> RigSetup:
    return RigSetup(DOFS[:1], DOFS[:1], Exciter(armature_mass=armature), **HARDWARE)  # type: ignore[arg-type]


@cache
def resonances() -> tuple[FloatArray, FloatArray]:
    """Where the drive-point inertance peaks below 800 Hz, and its height phi^2/eta, 1/kg."""
    freq = np.linspace(10.0, 800.0, 39_501)
    size = np.abs(chain(SYSTEM, rig(0.0)).respond(freq).inertance[0, :, 0, 0])
    peaks = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])) + 1
    return freq[peaks], size[peaks]


def force(armature: float, freq: FloatArray) -> FloatArray:
    """G_ff/G_pp at `freq`."""
    return np.asarray(np.abs(chain(SYSTEM, rig(armature)).respond(freq).force[0, :, 0, 0]) ** 2)


def test_the_force_at_resonances_falls_with_the_square_of_a_heavy_armature_s_mass() -> None:
    frequencies, heights = resonances()
    assert len(frequencies) == 8
    # slope -2 x^2/(1 + x^2) with x = m phi^2/eta: within 0.05 of -2 from x = 6.2 on
    ratios = np.geomspace(10.0, 100.0, 11)
    for frequency, height in zip(frequencies, heights, strict=True):
        levels = [force(x / height, np.array([frequency]))[0] for x in ratios]
        slope = np.polyfit(np.log(ratios), np.log(levels), 1)[0]
        assert slope == pytest.approx(-2.0, abs=0.05)


def test_from_twenty_to_a_hundred_grams_it_falls_less_steeply_where_damping_is_not_small() -> None:
    frequencies, heights = resonances()
    for light, heavy in ((0.02, 0.025), (0.08, 0.1)):
        found = np.log(force(heavy, frequencies) / force(light, frequencies)) / np.log(heavy / light)
        x = heights * np.sqrt(light * heavy)
        # modes overlap by some per cent: phi^2/eta is not quite imaginary at the peak
        np.testing.assert_allclose(found, -2 * x**2 / (1 + x**2), rtol=0.1)
