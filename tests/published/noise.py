"""The bias of H2 by noise in the response, on the thesis's beam: section 5.7.3."""

import numpy as np

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.fe.assembly import assemble
from modallab.rig.analyser import Analyser
from modallab.rig.chain import chain
from modallab.rig.hardware import Accelerometers, Exciter, ForceTransducer, Noise
from modallab.rig.measure import Route, measure
from modallab.rig.setup import RigSetup
from tests.published.roving import hidden_beam
from tests.published.tables import table

TABLES = table("beam_1992")
NOISE = TABLES["section_5_7_3"]
GAUGE = ForceTransducer(TABLES["beam"]["force_transducer_mass"])


def bias_of_h2(spacing: float, **noise: float) -> tuple[FloatArray, FloatArray]:
    """Lines, Hz, and by how much of itself H2 is off H1 without force noise, which no noise biases."""
    setup = RigSetup(
        (Dof(1, "Y"),),
        (Dof(NOISE["response_node"], "Y"),),
        exciter=Exciter(armature_mass=NOISE["armature_mass"]),
        force_transducer=GAUGE,
        accelerometers=Accelerometers(TABLES["beam"]["accelerometer_mass"], roving=True),
        noise=Noise(**noise),
        analyser=Analyser(800.0, round(800 / spacing) + 1, estimator="h2"),
    )
    rng = np.random.default_rng(0)
    frf = measure(hidden_beam(), setup, route=Route.EXPECTED, rng=rng).frf
    exact = chain(assemble(hidden_beam()), setup).respond(frf.freq).inertance[0, :, 0, 0]
    off = frf.values[:, 0, 0] / exact - 1
    # H2 = H (1 + r_o) [5.7]: noise that has nothing to do with the signals does not turn the phase
    np.testing.assert_allclose(off.imag, 0.0, atol=1e-9 * np.abs(off).max())
    return frf.freq, off.real
