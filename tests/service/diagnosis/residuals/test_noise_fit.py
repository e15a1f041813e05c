"""Noise of force and responses from incoherent spectra."""

import numpy as np
import pytest

from modallab.core.arrays import FloatArray
from modallab.diagnosis.residuals.channel_noise import ChannelNoise, NoiseData
from modallab.diagnosis.residuals.noise_cost import Coefficients, NoiseCost
from modallab.diagnosis.residuals.noise_fit import fit_channel_noise

N_FREQ, N_OUT = 400, 5
FREQ = np.linspace(1, 100, N_FREQ)
FORCE_NOISE = 3e-4
RESPONSE_NOISE = np.geomspace(1e-3, 1e-1, N_OUT)
HELD_OUT = np.array([False, False, True, False, False])


def spectra(scatter: float, seed: int = 0, exponent: float = 0.0) -> NoiseData:
    """Return incoherent spectra of resonant channels, one of them held out, their logarithms scattered.

    Noise falls with a power of frequency.
    """
    rng = np.random.default_rng(seed)
    freq = FREQ[:, None]
    resonances = rng.uniform(10, 90, N_OUT)
    gain = 1 / ((1 - (freq / resonances) ** 2) ** 2 + (0.05 * freq / resonances) ** 2)
    force, colour = np.ones((N_FREQ, N_OUT)), freq**-exponent
    of_force = FORCE_NOISE * colour
    expected = RESPONSE_NOISE * colour + gain * force * of_force / (force + of_force)
    return NoiseData(
        freq=FREQ,
        measured=expected * np.exp(scatter * rng.standard_normal(expected.shape)),
        weight=np.full(expected.shape, 30.0),
        fitted=np.broadcast_to(~HELD_OUT, expected.shape),
        other=np.zeros(expected.shape),
        coherent=gain * force,
        gain=gain[:, :, None],
        force=force[:, :, None],
    )


def levels(data: NoiseData, start: ChannelNoise | None = None) -> FloatArray:
    """Return the noise of force and responses, fitted, (n_freq, 1 + n_out)."""
    found = fit_channel_noise(data, force_noise=True, response_noise=True, start=start)
    return np.column_stack([found.force_at(FREQ), found.response_at(FREQ)])


def expected(data: NoiseData, fitted: FloatArray) -> FloatArray:
    """Return the incoherent spectra of levels, (n_freq, n_out)."""
    force, of_force = data.force[..., 0], fitted[:, :1]
    return np.asarray(fitted[:, 1:] + data.gain[..., 0] * force * of_force / (force + of_force))


def test_exact_spectra_tell_every_level() -> None:
    true = np.tile([FORCE_NOISE, *RESPONSE_NOISE], (N_FREQ, 1))
    # steps end where the next would change a logarithm by 1e-8
    np.testing.assert_allclose(levels(spectra(0.0)), true, rtol=1e-7)


@pytest.mark.parametrize("exponent", [1.0, 2.0])
def test_noise_that_falls_with_frequency_is_found(exponent: float) -> None:
    data = spectra(0.0, exponent=exponent)
    # a logarithm that is linear over that of frequency; the penalty bends it where lines are few
    fitted = levels(data)
    np.testing.assert_allclose(expected(data, fitted)[4:], data.measured[4:], rtol=0.03)
    np.testing.assert_allclose(fitted[40:, 1:], RESPONSE_NOISE * FREQ[40:, None] ** -exponent, rtol=0.02)


@pytest.mark.parametrize("factor", [0.3, 4.0])
def test_levels_do_not_depend_on_the_start(factor: float) -> None:
    # a model that is wrong by far more than the scatter: differences of predictions have to be smooth
    data = spectra(0.5)
    found = fit_channel_noise(data, force_noise=True, response_noise=True)
    assert found.force is not None
    assert found.response is not None
    start = ChannelNoise(FREQ, found.force + np.log(factor), found.response - np.log(factor))
    first, again = (expected(data, levels(data, near)) for near in (None, start))
    # a fit ends at a relative gain of 1e-13: a logarithm is 1e-6 off, of a scatter of 0.2
    np.testing.assert_allclose(again, first, rtol=1e-5)


def test_a_held_out_channel_tells_its_own_noise_alone() -> None:
    data = spectra(0.1)
    louder = data.measured * np.where(HELD_OUT, 7.0, 1.0)
    found, changed = levels(data), levels(NoiseData(**{**vars(data), "measured": louder}))
    own = np.array([False, *HELD_OUT])
    np.testing.assert_array_equal(changed[:, ~own], found[:, ~own])
    assert (changed[:, own] > 3 * found[:, own]).all()


def test_few_lines_tell_one_level() -> None:
    data = spectra(0.0)
    few = NoiseData(**{name: values[::8] for name, values in vars(data).items()})
    found = fit_channel_noise(few, force_noise=True, response_noise=True)
    assert found.force is not None
    assert len(found.force) == 1
    np.testing.assert_allclose(found.force_at(FREQ), FORCE_NOISE, rtol=1e-6)


def test_spectra_of_another_shape_take_few_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    # beside a resonance that no prediction has: by first derivatives alone 70 steps, as each gains a share
    data = spectra(0.3)
    bump = 1 + 50 * np.exp(-(((FREQ - 40) / 8) ** 2))
    steps, counted = NoiseCost.steps, list[float]()

    def count(cost: NoiseCost, position: Coefficients) -> tuple[float, Coefficients]:
        found = steps(cost, position)
        counted.append(found[0])
        return found

    monkeypatch.setattr(NoiseCost, "steps", count)
    levels(NoiseData(**{**vars(data), "measured": data.measured * bump[:, None]}))
    assert len(counted) < 40
