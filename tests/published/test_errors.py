"""What mass loading and noise do to the thesis's beam: sections 5.7.1 and 5.7.3."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.modes import ModalBasis
from modallab.rig.chain import chain
from modallab.rig.hardware import Accelerometers
from modallab.rig.setup import RigSetup
from tests.published.noise import GAUGE, NOISE, TABLES, bias_of_h2
from tests.published.roving import hidden_beam
from tests.published.tables import to_the_digit

LOADING = TABLES["section_5_7_1"]
N_MODES = 8  # below 800 Hz


def loaded(accelerometer: float) -> ModalBasis:
    """The modes of the beam with gauge and accelerometer on it, as a rig has it."""
    place = Dof(LOADING["response_node"], "Y")
    sensor = Accelerometers(accelerometer, roving=True)
    setup = RigSetup((Dof(1, "Y"),), (place,), force_transducer=GAUGE, accelerometers=sensor)
    return chain(assemble(hidden_beam()), setup).runs[0].system.modes().elastic(N_MODES)


def test_every_natural_frequency_falls_as_the_accelerometer_grows_heavier() -> None:
    masses = np.linspace(LOADING["masses"][0], LOADING["masses"][1], 5)
    frequencies = np.array([loaded(mass).frequencies for mass in masses])
    assert (np.diff(frequencies, axis=0) < 0).all()
    falls = 1 - frequencies[-1] / frequencies[0]
    assert falls.argmax() + 1 == LOADING["falls_most"]
    assert falls.argmin() + 1 == LOADING["falls_least"]


def test_the_fall_goes_by_the_apparent_mass_of_each_mode_at_the_accelerometer() -> None:
    light, heavy = (loaded(mass) for mass in LOADING["masses"])
    system = assemble(hidden_beam())
    own = system.selection((Dof(LOADING["response_node"], "Y"),)).T @ light.shapes.real
    apparent: FloatArray = 1 / own[0] ** 2
    assert apparent.argmin() + 1 == LOADING["falls_most"]
    assert apparent.argmax() + 1 == LOADING["falls_least"]
    added = LOADING["masses"][1] - LOADING["masses"][0]
    # f sqrt(m/(m + m_a)) for a mode alone; others take part, the more the heavier the added mass is
    alone = 1 - np.sqrt(apparent / (apparent + added))
    np.testing.assert_allclose(1 - heavy.frequencies / light.frequencies, alone, rtol=0.1)


def test_noise_biases_h2_at_the_fifth_mode_by_the_printed_share() -> None:
    freq, bias = bias_of_h2(NOISE["spacing"], response=NOISE["response_noise"])
    low, high = NOISE["band"]
    near = bias[(freq >= low) & (freq <= high)]
    assert len(near) == 5
    assert to_the_digit(np.array([100 * near.min()]), NOISE["h2_bias"][:1], 2) == 1
    assert to_the_digit(np.array([100 * near.max()]), NOISE["h2_bias"][1:], 1) == 1


def test_the_printed_mode_is_where_the_printed_masses_put_it() -> None:
    found = loaded(TABLES["beam"]["accelerometer_mass"]).frequencies[NOISE["mode"] - 1 :][:1]
    assert to_the_digit(found, [NOISE["frequency"]], 1) == 1


def test_no_other_mode_is_biased_as_much_by_the_same_noise() -> None:
    freq, bias = bias_of_h2(0.5, response=NOISE["response_noise"])
    at = [
        bias[np.abs(freq - f).argmin()] for f in loaded(TABLES["beam"]["accelerometer_mass"]).frequencies[1:]
    ]
    assert np.argmax(at) + 2 == NOISE["mode"]


def test_the_bias_is_proportional_to_the_noise_and_knows_nothing_of_the_force_s() -> None:
    _, once = bias_of_h2(NOISE["spacing"], response=1e-3)
    _, twice = bias_of_h2(NOISE["spacing"], response=2e-3, force=1e-2)
    np.testing.assert_allclose(twice, 2 * once, rtol=1e-9)
