"""What successive records share of the power that leaks: closed form, invariants, sampled records."""

from typing import Any

import numpy as np
import pytest
from scipy.sparse import csc_array
from scipy.special import polygamma

from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.progress import silent
from modallab.estimation.coherence import coherence
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.system import DynamicSystem
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import Chain, chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Noise
from modallab.rig.record_correlation import correlated_excess_variance, leaked_covariances
from modallab.rig.sampled import sampled_spectra
from modallab.rig.setup import RigSetup
from tests.rigs import beam_system, dofs

Y = Dof(1, "Y")


def oscillator(
    frequency: float, loss: float, *, excitation: str = "random", noise: float = 0.0, **settings: Any
) -> Chain:
    """A mass on a spring, driven and heard at once, on lines 1 Hz apart."""
    stiffness = (2 * np.pi * frequency) ** 2
    matrix = csc_array([[stiffness]])
    system = DynamicSystem(csc_array([[1.0]]), matrix, (Y,), damping=csc_array(loss * matrix))
    usual: dict[str, Any] = {
        "frequency_max": 128.0,
        "n_lines": 129,
        "window": "rectangular",
        "averages": 1000,
    }
    analyser = Analyser(**usual | settings, excitation=ExcitationSetting(excitation))
    return chain(system, RigSetup((Y,), (Y,), noise=Noise(noise, noise), analyser=analyser))


def excess(whole: Chain) -> FloatArray:
    return correlated_excess_variance(whole, expected_spectra(whole))


def loose(spectra: CrossSpectra) -> FloatArray:
    return np.asarray(spectra.xx * (1 - coherence(spectra)))


@pytest.mark.parametrize(
    ("frequency", "loss"), [(60.5, 0.002), (60.25, 0.005), (60.0, 0.002), (60.0, 0.02), (60.5, 0.02)]
)
def test_a_single_mode_has_the_factor_of_a_state_handed_on_from_record_to_record(
    frequency: float, loss: float
) -> None:
    rho = np.exp(-np.pi * frequency * loss + 2j * np.pi * frequency)  # records of 1 s
    wanted = 1 + abs(1 - rho) ** 4 / (2 * (1 - rho.real) ** 2 * (1 - abs(rho) ** 2))
    found = excess(oscillator(frequency, loss))[0, :, 0]
    # Five to ten lines off: nearer the force at the line itself explains part of the state, farther
    # off the mode's mirror at negative frequency counts (offset over 120 lines, squared: 0.7 %).
    off = np.r_[50:56, 66:71]
    np.testing.assert_allclose(found[off], wanted, rtol=0.01)


@pytest.mark.parametrize("window", ["rectangular", "hann"])
def test_without_lag_it_is_the_power_that_the_force_does_not_explain(window: str) -> None:
    setup = RigSetup(
        dofs(1), dofs(4, 9), analyser=Analyser(window=window, excitation=ExcitationSetting("random"))
    )
    whole = chain(beam_system(), setup)
    spectra = expected_spectra(whole)
    own = next(leaked_covariances(whole, spectra, 0))
    # 1 - coherence is a difference of nearly equal numbers: 1e-16 over the least of it, 1e-8
    np.testing.assert_allclose(own, loose(spectra), rtol=1e-6)


def test_signals_that_repeat_with_the_record_have_independent_records() -> None:
    assert (excess(oscillator(60.5, 0.002, excitation="periodic_random", noise=1e-3)) == 1).all()


@pytest.mark.parametrize(("window", "overlap"), [("rectangular", 0.0), ("hann", 0.5), ("hann", 0.75)])
def test_where_noise_outweighs_what_leaks_the_effective_averages_tell_it_all(
    window: str, overlap: float
) -> None:
    found = excess(oscillator(60.5, 0.3, noise=10.0, window=window, overlap=overlap))
    np.testing.assert_allclose(found, 1.0, atol=0.01)  # what leaks is below a hundredth of it


def test_a_longer_memory_than_is_worked_out_falls_geometrically() -> None:
    # |rho|^2 = 0.83: over half of the sum lies beyond the records that are worked out
    found, rho = excess(oscillator(60.5, 5e-4))[0, 50:56, 0], np.exp(-np.pi * 60.5 * 5e-4)
    wanted = 1 + (1 + rho) ** 2 / (2 * (1 - rho**2))
    assert wanted > 10
    # 1000 averages: 1 - l/n takes half a per cent off the slowest lags
    np.testing.assert_allclose(found, wanted, rtol=0.02)


@pytest.mark.parametrize(("window", "overlap"), [("rectangular", 0.0), ("hann", 0.5)])
def test_sampled_records_scatter_by_it(window: str, overlap: float) -> None:
    whole = oscillator(100.45, 0.002, noise=1e-6, window=window, overlap=overlap, averages=20)
    rng, n_tests, near = np.random.default_rng(1), 800, slice(85, 116)
    spectra = expected_spectra(whole)
    drawn = [np.log(loose(sampled_spectra(whole, rng, silent)))[0, near, 0] for _ in range(n_tests)]
    found = np.var(drawn, axis=0)
    factor = correlated_excess_variance(whole, spectra)[0, near, 0]
    # a variance of 800 numbers is known to sqrt(2/800) = 5 %; four of these
    wanted = polygamma(1, (spectra.averages - 1) / factor)
    np.testing.assert_allclose(found, wanted, rtol=4 * np.sqrt(2 / n_tests))
    assert factor.max() > 2  # or independent records would do as well
