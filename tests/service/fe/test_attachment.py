"""Attachments."""

from modallab.core.dof import Dof
from modallab.fe.attachment import merged
from tests.rigs import beam_system


def test_attachments_with_motions_of_their_own_are_not_merged() -> None:
    oscillators = beam_system().add_oscillator(Dof(5, "Y"), 0.02, 90.0, 0.05).attachments
    assert merged(oscillators) == oscillators
    masses = beam_system().add_mass(3, 0.1).add_mass(4, 0.1).attachments
    mass, oscillator = merged((*masses, *oscillators))
    assert mass.is_constant
    assert oscillator is oscillators[0]
