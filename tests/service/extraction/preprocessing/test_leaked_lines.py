"""The closed form of how leaked lines err, against records made of random numbers."""

from functools import cache

import numpy as np
import pytest

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.windows import WINDOWS
from modallab.extraction.preprocessing.leakage import SinglePole, WindowLeakage
from modallab.extraction.preprocessing.leaked_lines import (
    LeakedLines,
    LineErrors,
    leaked_lines,
    white_error_correlation,
)

FREQ = np.arange(95.0, 106.0)  # lines of 1 Hz, so that records last 1 s
EIGENVALUE = np.array((2 * np.pi * 100.3) ** 2 * (1 + 0.012j))  # 1.2 lines wide
CONSTANT = np.array(1.0 - 0.1j)
MASS = 0.2  # kg of an armature: force falls to a half at resonance
RECORDS, FINE = 8000, 8  # nodes a line of the source's spectrum: records are cut out of 8 s
REACH = 12  # lines beyond these: a Hann window has fallen to 1e-4 there
HANN = WINDOWS["hann"].samples(1024)


def poles() -> tuple[SinglePole, SinglePole]:
    rest: ComplexArray = np.full(len(FREQ), 0.4 + 0.2j)
    beside: ComplexArray = 0.5 * rest
    return (
        SinglePole(EIGENVALUE, -EIGENVALUE * CONSTANT, rest),
        SinglePole(EIGENVALUE, -EIGENVALUE * 0.5 * CONSTANT, beside),
    )


def inertance(pole: SinglePole, nu: FloatArray) -> ComplexArray:
    return np.asarray(pole.constant / (pole.eigenvalue - (2 * np.pi * nu) ** 2) + pole.residual[0])


@cache
def recorded(source_mass: float) -> tuple[ComplexArray, ComplexArray]:
    """Return transforms of windowed force and response, (RECORDS, n_lines)."""
    rng = np.random.default_rng(3)
    nu = np.arange((FREQ[0] - REACH) * FINE, (FREQ[-1] + REACH) * FINE + 1) / FINE
    source = rng.standard_normal((RECORDS, len(nu))) + 1j * rng.standard_normal((RECORDS, len(nu)))
    time = np.arange(len(HANN)) / len(HANN)
    seen = np.exp(2j * np.pi * (nu[:, None] - FREQ[0]) * time) * HANN
    window = np.fft.fft(seen)[:, : len(FREQ)] / np.sqrt((HANN**2).sum() * len(HANN) * 2 * FINE)
    response, drive = (inertance(pole, nu) for pole in poles())
    force = source / (1 + source_mass * drive)
    return force @ window, (force * response) @ window


def found(force: ComplexArray, motion: ComplexArray, estimator: str) -> ComplexArray:
    """Return the relative error that each record brings into an estimate, (RECORDS, n_lines)."""
    ff, fx, xx = (
        (np.abs(force) ** 2).mean(axis=0),
        (force.conj() * motion).mean(axis=0),
        (np.abs(motion) ** 2).mean(axis=0),
    )
    by_h1 = force.conj() * (motion - fx / ff * force) / fx
    by_h2 = motion.conj() * (motion - xx / fx.conj() * force) / xx
    return np.asarray({"h1": by_h1, "h2": by_h2, "hv": (by_h1 + by_h2) / 2}[estimator])


@pytest.mark.parametrize("source_mass", [0.0, MASS])
@pytest.mark.parametrize("estimator", ["h1", "h2", "hv"])
def test_moments_of_line_errors_are_those_of_many_records(estimator: str, source_mass: float) -> None:
    leakage = WindowLeakage.from_window(HANN, estimator, source_mass=source_mass)
    errors = leaked_lines(leakage, FREQ, 1.0, *poles()).errors
    each = found(*recorded(source_mass), estimator)
    covariance = each.T @ each.conj() / RECORDS
    relation = each.T @ each / RECORDS
    size = np.sqrt(np.diagonal(covariance).real)
    scale = size[:, None] * size
    # a correlation of 8,000 products with long tails is known to 2 %, the worst of some 240 to 8 %
    np.testing.assert_allclose(errors.covariance / scale, covariance / scale, atol=0.08)
    np.testing.assert_allclose(errors.relation / scale, relation / scale, atol=0.08)


@pytest.mark.parametrize("estimator", ["h1", "h2"])
def test_leaked_lines_are_neither_independent_nor_circular(estimator: str) -> None:
    errors = leaked_lines(WindowLeakage.from_window(HANN, estimator), FREQ, 1.0, *poles()).errors
    own = np.sqrt(np.diagonal(errors.covariance).real)
    apart = ~np.eye(len(own), dtype=bool)
    assert np.abs(errors.covariance / np.outer(own, own))[apart].max() > 0.2
    assert np.abs(errors.relation / np.outer(own, own))[apart].max() > 0.1


def test_white_noise_ties_lines_as_the_window_overlaps_itself() -> None:
    # the transform of a Hann window squared: 1, -2/3 and 1/6 of neighbours, then nothing
    row = white_error_correlation(WindowLeakage.from_window(HANN, "h1"), FREQ, 1.0)[0]
    np.testing.assert_allclose(row, [1, 4 / 9, 1 / 36, *np.zeros(8)], atol=1e-9)  # rounding


def test_a_sum_of_forms_errs_as_the_sum_of_its_lines() -> None:
    lines = leaked_lines(WindowLeakage.from_window(HANN, "h2"), FREQ, 1.0, *poles())
    weight = np.linspace(1.0, 2.0, len(FREQ)) * np.exp(1j * np.arange(len(FREQ)))
    summed = LeakedLines(weight[:, None, None] * lines.form, lines.moments).errors
    along = np.stack([weight, -1j * weight])  # real and imaginary part of the sum
    by_lines = lines.errors.propagate(along)
    circular, turned = summed.covariance.sum().real, summed.relation.sum()
    by_forms = np.array([[circular + turned.real, turned.imag], [turned.imag, circular - turned.real]])
    np.testing.assert_allclose(by_lines, by_forms / 2, rtol=1e-9)


def test_independent_circular_errors_share_their_square_between_both_parts() -> None:
    errors = LineErrors(np.diag([1.0, 4.0]) + 0j, np.zeros((2, 2), complex))
    np.testing.assert_allclose(errors.propagate(np.array([[1, 1j]])), [[2.5]])
