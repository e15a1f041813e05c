"""White noise of force and responses from incoherent spectra."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.diagnosis.residuals.white_noise import NoiseData, WhiteNoise, fit_white_noise

N_FREQ, N_OUT = 400, 5
FORCE_NOISE = 3e-4
RESPONSE_NOISE = np.geomspace(1e-3, 1e-1, N_OUT)
HELD_OUT = np.array([False, False, True, False, False])


def spectra(scatter: float, seed: int = 0) -> NoiseData:
    """Return incoherent spectra of resonant channels, one of them held out, their logarithms scattered."""
    rng = np.random.default_rng(seed)
    freq = np.linspace(1, 100, N_FREQ)[:, None]
    resonances = rng.uniform(10, 90, N_OUT)
    gain = 1 / ((1 - (freq / resonances) ** 2) ** 2 + (0.05 * freq / resonances) ** 2)
    force = np.ones((N_FREQ, N_OUT))
    expected = RESPONSE_NOISE + gain * force * FORCE_NOISE / (force + FORCE_NOISE)
    return NoiseData(
        measured=expected * np.exp(scatter * rng.standard_normal(expected.shape)),
        weight=np.full(expected.shape, 30.0),
        fitted=np.broadcast_to(~HELD_OUT, expected.shape),
        other=np.zeros(expected.shape),
        coherent=gain * force,
        gain=gain[:, :, None],
        force=force[:, :, None],
    )


def levels(data: NoiseData, start: WhiteNoise | None = None) -> FloatArray:
    """Return the noise of force and responses, fitted."""
    found = fit_white_noise(data, force_noise=True, response_noise=True, start=start)
    return np.array([found.force, *found.response])


def test_exact_spectra_tell_every_level() -> None:
    # steps end where the next would change a logarithm by 1e-12
    np.testing.assert_allclose(levels(spectra(0.0)), [FORCE_NOISE, *RESPONSE_NOISE], rtol=1e-9)


@pytest.mark.parametrize("factor", [0.3, 4.0])
def test_levels_do_not_depend_on_the_start(factor: float) -> None:
    # a model that is wrong by far more than the scatter: differences of predictions have to be smooth
    data = spectra(0.5)
    start = WhiteNoise(factor * FORCE_NOISE, RESPONSE_NOISE / factor)
    np.testing.assert_allclose(levels(data, start), levels(data), rtol=1e-9)


def test_a_held_out_channel_tells_its_own_noise_alone() -> None:
    data = spectra(0.1)
    louder = data.measured * np.where(HELD_OUT, 7.0, 1.0)
    found, changed = levels(data), levels(NoiseData(**{**vars(data), "measured": louder}))
    own = np.array([False, *HELD_OUT])
    np.testing.assert_array_equal(changed[~own], found[~own])
    assert changed[own] > 3 * found[own]
