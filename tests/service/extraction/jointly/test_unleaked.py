import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel
from modallab.estimation.windows import WINDOWS
from modallab.extraction.extract import extract
from modallab.extraction.measured.leakage import Leakage
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Noise
from modallab.rig.measure import Route, measure
from modallab.rig.setup import RigSetup
from tests.service.extraction.conftest import Beam

RESPONSES = tuple(Dof(node, "Y") for node in range(1, 22, 2))


def leaked(estimator: str, route: Route, noise: Noise, *, n_lines: int = 401) -> ModalModel:
    """Return the modes of the beam driven by random noise, seen through a Hann window."""
    analyser = Analyser(
        n_lines=n_lines, window="hann", estimator=estimator, excitation=ExcitationSetting("random")
    )
    setup = RigSetup((RESPONSES[0],), RESPONSES, noise=noise, analyser=analyser)
    measurement = measure(STRUCTURES["chapter-5-beam"](), setup, route=route, rng=np.random.default_rng(5))
    return extract(
        measurement.frf,
        coherence=measurement.coherence,
        averages=measurement.averages,
        method="lscf",
        leakage=Leakage.of(WINDOWS["hann"].samples(1024), estimator),
        estimator=estimator,
    )


@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_modes_narrower_than_a_line_are_freed_of_leakage(estimator: str, plain_beam: Beam) -> None:
    model = leaked(estimator, Route.EXPECTED, Noise(force=1e-4, response=1e-7))
    # modes 3 to 8 are 0.3 to 1.9 lines wide; uncorrected lines make their damping up to five times too large
    wide = plain_beam.loss_factors[2:, 0] * plain_beam.frequencies[2:, 0]
    nearest = [int(np.abs(model.frequencies - exact).argmin()) for exact in plain_beam.frequencies[2:, 0]]
    np.testing.assert_array_less(
        np.abs(model.frequencies[nearest] - plain_beam.frequencies[2:, 0]), 0.02 * wide
    )
    np.testing.assert_allclose(model.loss_factors[nearest], plain_beam.loss_factors[2:, 0], rtol=0.02)


def test_what_leakage_may_leave_is_flagged_where_random_error_is_less(plain_beam: Beam) -> None:
    rough = leaked("h2", Route.DRAWN, Noise(force=0.3, response=1e-5))
    exact = plain_beam.frequencies[:, 0]
    for m in range(5, 8):  # modes of a line's width and more
        mode = rough.modes[int(np.abs(rough.frequencies - exact[m]).argmin())]
        bias = [flag for flag in mode.flags if flag.startswith("leakage_bias")]
        off = abs(mode.loss_factor - plain_beam.loss_factors[m, 0])
        # five standard errors: noise; or else it has been said
        assert off < 5 * mode.standard_errors["loss_factor"] or bias
