"""Where an accelerometer roves, a global method may see one mode twice: it is told from a pair."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from tests.service.extraction.conftest import Beam

AVERAGES = 100.0
LINES: FloatArray = np.arange(0.5, 100.0, 0.25)
DOFS = tuple(Dof(node, "Y") for node in range(1, 11))
LOSS = 0.02
MASS = 0.02  # kg, that rove


def noisy(frf: FrfSet) -> ModalModel:
    rng = np.random.default_rng(1)
    level = 1e-3 * np.sqrt((np.abs(frf.values) ** 2).mean(axis=0))
    error = rng.standard_normal(frf.values.shape) + 1j * rng.standard_normal(frf.values.shape)
    values = frf.values + level * error / np.sqrt(2)
    coherence = 1 / (1 + AVERAGES * level**2 / np.maximum(np.abs(values) ** 2, 1e-300))
    noise = FrfSet(frf.freq, values, frf.outputs, frf.inputs, frf.kind)
    return extract(noise, coherence=coherence, averages=AVERAGES, method="lscf")


def flagged(model: ModalModel) -> list[float]:
    return [mode.frequency for mode in model.modes if any(f.startswith("doubled: ") for f in mode.flags)]


def roved(frequencies: FloatArray, seed: int) -> FrfSet:
    """Return inertances of a structure whose frequencies a roving mass lowers, to first order."""
    shapes = np.random.default_rng(seed).standard_normal((len(frequencies), len(DOFS)))
    own = frequencies[:, None] * np.sqrt(1 - MASS * shapes**2)
    eigenvalue = (2 * np.pi * own) ** 2 * (1 + 1j * LOSS)
    omega2 = (2 * np.pi * LINES[:, None, None]) ** 2
    values = -(omega2 / (eigenvalue - omega2) * shapes * shapes[:, :1]).sum(axis=1)
    return FrfSet(LINES, values[:, :, None], DOFS, DOFS[:1], FrfKind.INERTANCE)


def test_modes_that_one_roving_mass_doubles_are_said_to_be_one(roving_beam: Beam, freq: np.ndarray) -> None:
    model = noisy(roving_beam.frf(freq))
    doubled = flagged(model)
    assert len(doubled) > 1
    ranges = np.sort(roving_beam.frequencies, axis=1)[:, [0, -1]]
    inside = [(low <= np.array(doubled)) & (np.array(doubled) <= high) for low, high in ranges]
    # every one is in the range of a mode, and with at least one other
    assert np.sum(inside) == len(doubled)
    assert 1 not in np.sum(inside, axis=1)
    text = next(flag for mode in model.modes for flag in mode.flags if flag.startswith("doubled: "))
    assert float(text.split("as with ")[1].split(" g ")[0]) == pytest.approx(20.0, rel=0.05)  # to first order


def test_modes_of_one_structure_are_not_doubled(plain_beam: Beam, freq: np.ndarray) -> None:
    assert not flagged(noisy(plain_beam.frf(freq)))


@pytest.mark.parametrize("seed", [1, 3, 5])  # of shapes; of 1 and 3 one FRF alone makes a pair seem to rove
def test_a_pair_stays_a_pair_beside_modes_that_a_roving_mass_moves(seed: int) -> None:
    frequencies = np.array([20.0, 40.0, 60.0, 60.6, 85.0])  # half a bandwidth apart
    model = noisy(roved(frequencies, seed))
    assert any("at the roving accelerometer" in note for note in model.notes)
    pair, others = frequencies[2:4], frequencies[[0, 1, 4]]
    doubled = flagged(model)
    # a frequency moves by 1 % times the squared shape, seldom above 2 %
    assert not [frequency for frequency in doubled if abs(frequency / pair.mean() - 1) < 0.025]
    assert all(np.abs(frequency / others - 1).min() < 0.05 for frequency in doubled)


def test_a_single_mode_among_them_is_said_to_be_one() -> None:
    frequencies = np.array([20.0, 40.0, 60.0, 85.0])
    doubled = np.array(flagged(noisy(roved(frequencies, 2))))
    near = np.abs(doubled[:, None] / frequencies - 1) < 0.05
    assert near[:, 2].sum() > 1  # where the pair of the test above is
    assert 1 not in near.sum(axis=0)
