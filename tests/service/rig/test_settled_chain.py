"""A chain whose modes all die away within the lead-in of simulated records."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.fe.assembly import assemble
from modallab.fe.beam import beam
from modallab.fe.damping import StructuralDamping
from modallab.fe.structure import Material, Section
from modallab.rig.chain import Chain, chain
from modallab.rig.expected import expected_spectra
from modallab.rig.nonlinear_settings import NONLINEAR_RECORDS
from modallab.rig.settled_chain import settled_chain
from modallab.rig.simulated_variance import SimulatedVariance, simulated_factors
from tests.diagnosing import model, rig

CUBIC = CubicStiffness(Dof(4, "Y"), 1e10)


@pytest.fixture(scope="module")
def ringing() -> Chain:
    """A free beam on a cubic spring alone: what swings on it has next to no damping."""
    free = beam(
        length=1.2,
        n_elements=8,
        section=Section(5e-4, 4.1667e-9),
        material=Material(2.09e11, 7800.0),
        damping=StructuralDamping(stiffness_coefficient=0.008),
    )
    return chain(assemble(free), rig(roving=False), [CUBIC])


def widths(whole: Chain) -> tuple[np.ndarray, np.ndarray]:
    frequencies, half_widths = whole.runs[0].resonances(whole.setup.analyser.frequency_max)
    inside = frequencies < whole.setup.analyser.frequency_max
    return frequencies[inside], half_widths[inside]


def test_the_slow_mode_dies_away_within_the_lead_in_and_others_stay(ringing: Chain) -> None:
    frequencies, before = widths(ringing)
    settled, after = widths(settled_chain(ringing))
    lead_in = NONLINEAR_RECORDS.max_lead_in / ringing.setup.analyser.spacing
    left = np.exp(-2 * np.pi * after * lead_in)
    assert left.max() == pytest.approx(NONLINEAR_RECORDS.decay_threshold, rel=1e-3)  # light damping
    np.testing.assert_allclose(settled, frequencies, rtol=1e-3)
    enough = np.exp(-2 * np.pi * before * lead_in) < NONLINEAR_RECORDS.decay_threshold
    assert enough.any()
    assert not enough.all()
    np.testing.assert_allclose(after[enough], before[enough], rtol=1e-6)  # a mode's damping is its own


def test_a_chain_that_settles_is_returned_as_it_is() -> None:
    whole = chain(assemble(model()), rig(roving=False), [CUBIC])
    assert settled_chain(whole) is whole


def test_what_never_settles_adds_nothing_to_the_scatter_of_a_test(ringing: Chain) -> None:
    """Transients of a mode that rings on would make slow lines scatter a hundred times as much."""
    spectra = expected_spectra(ringing)
    ringing_on = simulated_factors(ringing, spectra, 4).response
    steady = SimulatedVariance().factors(ringing, spectra, [CUBIC])
    assert steady is not None
    slow = slice(1, 20)
    assert np.median(steady.response[:, slow]) < 0.3 * np.median(ringing_on[:, slow])
