"""The small beam of the diagnosis tests with one end clamped, and drawn measurements of it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.fe.structure import Support
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra
from modallab.rig.measure import measurement_of
from modallab.rig.measurement import Measurement
from modallab.rig.wishart import wishart_spectra
from tests.diagnosing import model, rig

CANTILEVER = replace(model(), supports=(Support(1, ("Y", "RZ")),))
SETUP = replace(rig(), drives=(Dof(3, "Y"),), responses=tuple(Dof(node, "Y") for node in (2, 3, 4, 5, 7, 9)))
HELD_OUT = [Dof(4, "Y")]


def draw_cantilever(effects: Sequence[Effect], *, seed: int = 0) -> Measurement:
    """Return a measurement of the cantilever drawn round the expected spectra."""
    spectra = expected_spectra(chain(assemble(CANTILEVER), SETUP, effects))
    return measurement_of(wishart_spectra(spectra, np.random.default_rng(seed)), SETUP)
