"""Averages of signals that come back, against draws from their law."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.estimation.coherence import coherence
from modallab.estimation.estimators.h1 import h1
from modallab.fe.assembly import assemble
from modallab.rig.analyser import ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra, noise_densities, noise_free
from modallab.rig.hardware import Exciter, ForceTransducer, Noise
from modallab.rig.periodic import periodic_signals
from modallab.rig.periodic_variance import periodic_factors
from modallab.rig.setup import RigSetup
from modallab.rig.wishart_periodic import noncentral_wishart_spectra
from tests.diagnosing import model, rig

TESTS = 400
AVERAGES = 60


def noisy(kind: str, force: float, **setting: float) -> RigSetup:
    setup = rig(kind=kind, averages=AVERAGES, roving=False)
    source = ExcitationSetting(kind, **setting)  # type: ignore[arg-type]
    analyser = replace(setup.analyser, excitation=source)
    setup = replace(setup, noise=Noise(force, 1e-4), analyser=analyser)
    if kind != "impact":
        return setup
    return replace(setup, exciter=Exciter(kind="hammer"), force_transducer=ForceTransducer())


@pytest.mark.parametrize(
    "setup",
    [
        noisy("chirp", 1e-3),
        noisy("pseudo_random", 0.3),
        noisy("impact", 1e-2),
        noisy("impact", 1e-3, level_scatter=0.1),
    ],
    ids=["a little noise", "strong noise", "blows", "blows of many sizes"],
)
def test_variances_are_those_of_draws(setup: RigSetup) -> None:
    whole = chain(assemble(model()), setup)
    spectra = expected_spectra(whole)
    factors = periodic_factors(whole, spectra)
    assert factors is not None
    clean, steady, rng = noise_free(whole), periodic_signals(whole), np.random.default_rng(5)
    assert steady is not None
    noise = noise_densities(whole, clean)[:, 0]  # through a rectangular window
    drawn = [noncentral_wishart_spectra(spectra, clean, noise, steady, rng) for _ in range(TESTS)]
    n = spectra.averages
    g2 = coherence(spectra)
    loose = np.array([one.xx * (1 - coherence(one)) for one in drawn])
    h = np.array([h1(one)[..., 0] for one in drawn])
    power = spectra.ff[:, :, 0, 0].real
    found = {
        "force": n * np.log([one.ff[:, :, 0, 0].real for one in drawn]).var(axis=0),
        "frf": h.var(axis=0) * n * power[..., None] / (spectra.xx * (1 - g2)),
        "response": n * np.log(loose).var(axis=0),
    }
    for part, each in found.items():
        # A variance of 400 draws is known to sqrt(2/400) = 7 %, five of these and 4/n beyond first order.
        factor = getattr(factors, part)[:, 1:]
        np.testing.assert_allclose(each[:, 1:] / factor, 1.0, atol=0.35 + 4 / n, err_msg=part)
        # All 160 lines together are known well, unless the size of all lines scatters alike.
        alike = part == "force" and setup.analyser.excitation.level_scatter > 0
        assert (each[:, 1:] / factor).mean() == pytest.approx(1.0, abs=0.3 if alike else 3 / n), part


def test_signals_drawn_anew_scatter_as_gaussian_ones() -> None:
    whole = chain(assemble(model()), rig())
    assert periodic_factors(whole, expected_spectra(whole)) is None


def test_a_force_without_noise_does_not_scatter() -> None:
    whole = chain(assemble(model()), rig(kind="chirp", noise=0.0))
    factors = periodic_factors(whole, expected_spectra(whole))
    assert factors is not None
    assert factors.force.max() < 1e-12  # rounding
