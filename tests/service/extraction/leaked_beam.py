"""The beam whose modes are 0.1 to 1.9 lines wide, driven by random noise and read through a Hann window."""

from functools import cache

import numpy as np

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.modal_model import ModalModel
from modallab.estimation.windows import WINDOWS
from modallab.extraction.extract import extract
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.service.extraction.conftest import DRIVE, RESPONSES, Beam

FAR = 5.0  # Hz: a mode further off is another one
DRAWN, SAMPLED = 5, 1  # tests by each estimator
NARROW, WIDE = slice(0, 2), slice(3, 8)  # below 0.2 lines, above 0.5


@cache
def taken(estimator: str) -> tuple[Measurement, ...]:
    """Return drawn tests and sampled ones."""
    analyser = Analyser(
        n_lines=401, window="hann", estimator=estimator, excitation=ExcitationSetting("random")
    )
    setup = RigSetup((DRIVE,), RESPONSES, noise=Noise(force=1e-2, response=1e-5), analyser=analyser)
    routes = [Route.DRAWN] * DRAWN + [Route.SAMPLED] * SAMPLED
    return tuple(
        measure(STRUCTURES["chapter-5-beam"](), setup, route=route, rng=np.random.default_rng(seed))
        for seed, route in enumerate(routes)
    )


@cache
def read(measurement: Measurement, estimator: str, method: str) -> ModalModel:
    return extract(
        measurement.frf,
        coherence=measurement.coherence,
        averages=measurement.averages,
        method=method,
        leakage=WindowLeakage.from_window(WINDOWS["hann"].samples(1024), estimator),
        estimator=estimator,
    )


@cache
def judged(estimator: str, method: str, truth: tuple[tuple[float, ...], ...]) -> tuple[FloatArray, BoolArray]:
    """Return how many standard errors modes are off, and which are flagged, (n_tests, 8); NaN if not seen."""
    off, flagged = [], []
    for measurement in taken(estimator):
        model = read(measurement, estimator, method)
        for frequency, loss_factor in zip(*truth, strict=True):
            mode = min(model.modes, key=lambda mode: abs(mode.frequency - frequency))
            scores = (
                (mode.frequency - frequency) / mode.standard_errors["frequency"],
                (mode.loss_factor - loss_factor) / mode.standard_errors["loss_factor"],
            )
            off.append(max(map(abs, scores)) if abs(mode.frequency - frequency) < FAR else np.nan)
            flagged.append(any(flag.startswith("leakage_bias: ") for flag in mode.flags))
    return np.reshape(off, (-1, 8)), np.reshape(flagged, (-1, 8))


def of(beam: Beam) -> tuple[tuple[float, ...], ...]:
    return tuple(beam.frequencies[:, 0].tolist()), tuple(beam.loss_factors[:, 0].tolist())
