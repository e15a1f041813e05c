"""Where natural frequencies drift during a test, a mode stays one mode, and the drift is named."""

from functools import cache

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract

FREQ: FloatArray = np.linspace(0.0, 400.0, 6401)  # Hz
FREQUENCY = np.array([52.5, 144.6, 188.0, 283.1, 341.0])  # Hz
LOSS_FACTOR = np.array([1e-3, 4e-4, 5e-4, 4e-4, 6e-4])
N_FRF = 9
DOFS = tuple(Dof(n + 1, "Z") for n in range(N_FRF))
NOISE = 1e-3  # of each FRF's rms


def frf(drift: float, frequency: FloatArray = FREQUENCY, *, together: bool = False) -> FrfSet:
    """Return inertances measured while the frequencies rise by `drift`, relative.

    One FRF after the other, or all together as the mean of five records.
    """
    rng = np.random.default_rng(1)
    shapes = rng.standard_normal((N_FRF, len(frequency)))
    square = (2 * np.pi * FREQ[:, None]) ** 2
    stretch = 1 + drift * np.linspace(-0.5, 0.5, 5 if together else N_FRF)
    values = np.zeros((len(FREQ), N_FRF), complex)
    for n, factor in enumerate(stretch):
        eigenvalue = (2 * np.pi * frequency * factor) ** 2 * (1 + 1j * LOSS_FACTOR)
        measured = slice(None) if together else slice(n, n + 1)
        constants = shapes[measured] * shapes[0] / (len(stretch) if together else 1)
        values[:, measured] += -square * (1 / (eigenvalue - square)) @ constants.T
    parts = rng.standard_normal((2, *values.shape))
    values = values + NOISE * np.sqrt((np.abs(values) ** 2).mean(axis=0) / 2) * (parts[0] + 1j * parts[1])
    return FrfSet(FREQ, values[:, :, None], DOFS, DOFS[:1], FrfKind.INERTANCE)


@cache
def modes(drift: float, method: str) -> ModalModel:
    return extract(frf(drift), coherence=None, averages=100.0, method=method)


@pytest.mark.parametrize("method", ["lscf", "poly_reference_lscf"])
def test_a_drift_splits_no_mode(method: str) -> None:
    model = modes(1e-4, method)  # a tenth to a quarter of the bandwidths
    assert len(model.modes) == len(FREQUENCY)
    np.testing.assert_allclose(model.frequencies, FREQUENCY, rtol=5e-5)  # within the drift
    # a pole that moves by a quarter of its bandwidth seems broader by less than 5 %
    np.testing.assert_allclose(model.loss_factors, LOSS_FACTOR, rtol=0.05)


def test_a_drift_is_named() -> None:
    assert any("all modes drift by +0.01 " in note for note in modes(1e-4, "lscf").notes)
    assert not any("split or doubled" in note for note in modes(1e-4, "lscf").notes)


@pytest.mark.parametrize("method", ["lscf", "poly_reference_lscf"])
def test_a_drift_of_all_frfs_together_splits_no_mode(method: str) -> None:
    model = extract(frf(8e-5, together=True), coherence=None, averages=100.0, method=method)
    assert len(model.modes) == len(FREQUENCY)
    np.testing.assert_allclose(model.frequencies, FREQUENCY, rtol=1e-5)  # the mean of the drift
    np.testing.assert_allclose(model.loss_factors, LOSS_FACTOR, rtol=0.05)  # as above
    told = [float(n.split("drifts by about ")[1].split(" %")[0]) for n in model.notes if "drifts by" in n]
    assert told
    # five records vary by 1.22 times as much as a steady drift of the same range, and noise adds to it
    np.testing.assert_allclose(told, 8e-3 * 1.22, rtol=0.2)


def test_without_a_drift_no_drift_is_named() -> None:
    assert not any("drift" in note for note in modes(0.0, "lscf").notes)
    assert len(modes(0.0, "lscf").modes) == len(FREQUENCY)


def test_a_pair_stays_a_pair_in_a_drifting_test() -> None:
    # a third of a bandwidth apart, further than the drift moves either
    frequency = np.where(np.arange(len(FREQUENCY)) == 2, FREQUENCY[1] * (1 + 1.5e-4), FREQUENCY)
    model = extract(frf(3e-5, frequency), coherence=None, averages=100.0, method="lscf")
    near = np.abs(model.frequencies / FREQUENCY[1] - 1) < 1e-3
    assert near.sum() >= 2
