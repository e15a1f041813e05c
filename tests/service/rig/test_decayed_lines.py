"""Screening of blows: what dies out within the record needs the lines alone."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.effects.tabulated_response import TabulatedResponse
from modallab.fe.assembly import assemble
from modallab.fe.damping import StructuralDamping
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.expected import coarse_spectra, expected_spectra
from modallab.rig.free_decay import decayed_lines, has_decayed
from modallab.rig.hardware import Exciter
from modallab.rig.setup import RigSetup
from tests.rigs import dofs, steel_beam

HEAVILY_DAMPED = StructuralDamping(stiffness_coefficient=0.05, mass_coefficient=400.0)
RANDOM = ExcitationSetting("random")


def struck(n_lines: int, **settings: object) -> RigSetup:
    """Return a rig with a hammer at two points."""
    signal = ExcitationSetting("impact", **settings)  # type: ignore[arg-type]
    analyser = Analyser(frequency_max=800.0, n_lines=n_lines, averages=30, excitation=signal)
    return RigSetup(dofs(1, 9), dofs(1, 5), exciter=Exciter("hammer"), analyser=analyser)


def test_coarse_spectra_of_blows_that_die_out_are_the_exact_ones() -> None:
    test = chain(assemble(steel_beam(HEAVILY_DAMPED)), struck(1601))
    exact, coarse = expected_spectra(test), coarse_spectra(test, 8)
    for name in ("ff", "fx", "xx"):
        whole, lines = getattr(exact, name)[:, ::8], getattr(coarse, name)
        # what hysteretic damping puts before the pre-trigger is outside the record: 1e-3 at the lowest line
        scale = np.abs(whole).max(axis=1, keepdims=True)
        assert (np.abs(lines - whole) / scale)[:, 1:].max() < 2e-3


@pytest.mark.parametrize("settings", [{"place_scatter": 1e-3}, {"angle_scatter": 0.05}])
def test_misaligned_blows_have_no_lines_of_their_own(settings: dict[str, float]) -> None:
    test = chain(assemble(steel_beam()), struck(201, **settings))
    assert decayed_lines(test, slice(None, None, 8)) is None


@pytest.mark.parametrize("end", [0.01, 0.2])
def test_an_exponential_window_is_more_decay(end: float) -> None:
    lightly_damped = StructuralDamping(stiffness_coefficient=0.01, mass_coefficient=40.0)
    setup = struck(801, pre_trigger=0.02)
    windowed = replace(setup, analyser=replace(setup.analyser, window="exponential", window_end=end))
    test = chain(assemble(steel_beam(lightly_damped)), windowed)
    exact, coarse = expected_spectra(test), coarse_spectra(test, 8)
    for name in ("ff", "fx", "xx"):
        whole, lines = getattr(exact, name)[:, ::8], getattr(coarse, name)
        scale = np.abs(whole).max(axis=1, keepdims=True)
        # what rings on beyond the record is left out, a seventh of what the window leaves of it here;
        # and the window falls by 0.2 % over the pulse
        assert (np.abs(lines - whole) / scale)[:, 1:].max() < 0.15 * end + 3e-3


def test_a_table_by_frequency_has_no_lines_of_a_windowed_blow() -> None:
    setup = struck(201)
    windowed = replace(setup, analyser=replace(setup.analyser, window="exponential"))
    gain = TabulatedResponse(at=None, table=((0.0, 1.0, 0.0), (800.0, 1.1, 0.0)))
    assert decayed_lines(chain(assemble(steel_beam()), windowed, [gain]), slice(None)) is None
    assert decayed_lines(chain(assemble(steel_beam()), windowed), slice(None)) is not None


def test_blows_have_decayed_where_structure_and_window_leave_little_at_the_end() -> None:
    test = chain(assemble(steel_beam(HEAVILY_DAMPED)), struck(1601))
    assert has_decayed(test, 0.05)
    setup, slight = struck(201), StructuralDamping(stiffness_coefficient=1e-3)
    assert not has_decayed(chain(assemble(steel_beam(slight)), setup), 0.05)
    windowed = replace(setup, analyser=replace(setup.analyser, window="exponential", window_end=0.01))
    assert has_decayed(chain(assemble(steel_beam(slight)), windowed), 0.05)
    steady = replace(setup, exciter=Exciter("shaker"), analyser=replace(setup.analyser, excitation=RANDOM))
    assert not has_decayed(chain(assemble(steel_beam(HEAVILY_DAMPED)), steady), 0.05)
