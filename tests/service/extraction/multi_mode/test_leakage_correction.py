import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel, Mode
from modallab.estimation.windows import WINDOWS
from modallab.extraction.extract import extract
from modallab.extraction.preprocessing.leakage import WindowLeakage
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
        leakage=WindowLeakage.from_window(WINDOWS["hann"].samples(1024), estimator),
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


def leakage_flags(model: ModalModel, frequency: float) -> tuple[Mode, list[str]]:
    """Return the mode nearest to a frequency, and what is said of its leakage."""
    mode = model.modes[int(np.abs(model.frequencies - frequency).argmin())]
    return mode, [flag for flag in mode.flags if flag.startswith("leakage_bias")]


def test_random_error_above_what_leakage_leaves_is_the_whole_error(plain_beam: Beam) -> None:
    rough = leaked("h2", Route.SAMPLED, Noise(force=0.3, response=1e-5))
    told = []
    for frequency, loss_factor in zip(
        plain_beam.frequencies[:, 0], plain_beam.loss_factors[:, 0], strict=True
    ):
        mode, flags = leakage_flags(rough, frequency)
        # of eight standard normal numbers one beyond 4 comes once in 2,000 such tests
        assert abs(mode.loss_factor - loss_factor) < 4 * mode.standard_errors["loss_factor"]
        assert len(flags) == any(mode.leakage_bias[n] > error for n, error in mode.standard_errors.items())
        told.append(len(flags))
    # single FRFs tell the two modes below 0.2 lines to half their damping: what cleans them may be biased
    assert sum(told[:2]) > 0
    assert told[2:] == [0, 0, 0, 0, 0, 0]


def test_what_leakage_may_leave_beyond_random_error_is_flagged_with_a_bound_that_holds(
    plain_beam: Beam,
) -> None:
    fine = leaked("h1", Route.EXPECTED, Noise(force=1e-4, response=1e-7))
    truth = plain_beam.loss_factors[:, 0]
    # mode 1, 0.1 line wide, is none when it is looked for by itself: its lines leak as they did
    mode, (flag,) = leakage_flags(fine, plain_beam.frequencies[0, 0])
    said = float(flag.split(" and ")[1].split(" %")[0]) / 100
    assert abs(mode.loss_factor - truth[0]) < said * mode.loss_factor
    # what leakage has left of the others is within what is told, and flagged where random error is less
    for row in range(1, 8):
        mode, flags = leakage_flags(fine, plain_beam.frequencies[row, 0])
        assert abs(mode.loss_factor - truth[row]) < mode.leakage_bias["loss_factor"] < 0.06 * truth[row]
        assert abs(mode.frequency - plain_beam.frequencies[row, 0]) < mode.leakage_bias["frequency"]
        beyond = [mode.leakage_bias[name] > error for name, error in mode.standard_errors.items()]
        assert len(flags) == any(beyond)
        assert max(mode.leakage_bias[name] / error for name, error in mode.standard_errors.items()) < 2
