"""Modes 0.1 to 1.9 lines wide, driven by random noise and seen through a Hann window."""

from functools import cache

import numpy as np
import pytest

from modallab.core.arrays import BoolArray, FloatArray
from modallab.core.modal_model import ModalModel
from modallab.estimation.windows import WINDOWS
from modallab.extraction.extract import extract
from modallab.extraction.measured.leakage import Leakage
from modallab.extraction.singly.method import EXTRACTION_METHODS, TRAITS
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.hardware import Noise
from modallab.rig.measure import Route, measure
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from tests.service.extraction.conftest import DRIVE, RESPONSES, Beam

EXACT = [kind for kind in sorted(EXTRACTION_METHODS) if TRAITS[kind].exact]
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


def read(measurement: Measurement, estimator: str, method: str) -> ModalModel:
    return extract(
        measurement.frf,
        coherence=measurement.coherence,
        averages=measurement.averages,
        method=method,
        leakage=Leakage.of(WINDOWS["hann"].samples(1024), estimator),
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


@pytest.mark.parametrize("method", EXACT)
@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_modes_beyond_their_stated_errors_are_flagged(estimator: str, method: str, plain_beam: Beam) -> None:
    off, flagged = judged(estimator, method, of(plain_beam))
    # 48 modes and two numbers each: chance alone puts one beyond 3 in four lots, beyond 3.5 in 22
    assert not ((off > 3.5) & ~flagged).any()


@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_modes_that_the_lines_tell_are_not_flagged(estimator: str, plain_beam: Beam) -> None:
    off, flagged = judged(estimator, "dobson", of(plain_beam))
    assert not flagged[:, WIDE].any()
    assert np.isfinite(off[:, WIDE]).all()


def test_drawn_lines_of_many_frfs_leave_narrow_modes_biased_and_it_is_said(plain_beam: Beam) -> None:
    # independent errors of eleven FRFs average out, and what the non-linear correction makes of them does not
    for estimator in ("h1", "h2"):
        off, flagged = judged(estimator, "dobson", of(plain_beam))
        seen = np.isfinite(off[:DRAWN, NARROW])
        assert (flagged[:DRAWN, NARROW] & seen).sum() > 0.6 * seen.sum()


def test_lines_that_hardly_tell_a_mode_make_its_errors_wide(plain_beam: Beam) -> None:
    # 0.1 line wide, errors of all responses in common as they were recorded together
    model = read(taken("h2")[-1], "h2", "dobson")
    mode = min(model.modes, key=lambda mode: abs(mode.frequency - plain_beam.frequencies[0, 0]))
    assert mode.standard_errors["loss_factor"] > 0.2 * mode.loss_factor
