"""Distortion that comes in bursts: how averages of it scatter, against tests gone through in time."""

import numpy as np
import pytest

from modallab.core.dof import Dof
from modallab.core.progress import silent
from modallab.effects.cubic_stiffness import CubicStiffness
from modallab.effects.extra_mass import ExtraMass
from modallab.effects.overload import Overload
from modallab.fe.assembly import assemble
from modallab.rig.added_noise import AddedNoise
from modallab.rig.chain import chain
from modallab.rig.effect import Effect
from modallab.rig.expected import expected_spectra
from modallab.rig.measure import measurement_of
from modallab.rig.sampled import sampled_spectra
from modallab.rig.simulated_variance import SimulatedVariance, is_intermittent, simulated_factors
from tests.diagnosing import model, predicting, rig

CUBIC, CLIPPED = CubicStiffness(Dof(4, "Y"), 1e10), Overload(None, 2.8)


@pytest.mark.parametrize("effect", [CUBIC, CLIPPED], ids=lambda effect: effect.kind)
@pytest.mark.parametrize("roving", [True, False], ids=["roving", "fixed"])
def test_with_the_true_effect_the_incoherent_spectrum_scatters_as_it_is_said_to(
    effect: Effect, roving: bool
) -> None:
    setup = rig(roving=roving, noise=1e-4)
    whole = chain(assemble(model()), setup, [effect])
    plain, gaps = [], []
    for seed in (4, 5):
        spectra = sampled_spectra(whole, np.random.default_rng(seed), silent)
        predictor, observed = predicting(measurement_of(spectra, setup))
        left = predictor.residual([effect])
        assert left.response is not None
        plain.append((left.response[observed.usable] ** 2).mean())
        gaps.append(left.gaps(observed.usable))
    # Gaussian records would leave 1, to within sqrt(2/960) = 5 %
    assert min(plain) > 1.4
    # a burst is in many lines of all channels at once: one test's gap scatters by some 30 %
    assert 0.6 < np.mean([gap["response"] for gap in gaps]) < 1.6
    assert 0.7 < np.mean([gap["frf"] for gap in gaps]) < 1.4


def test_without_distortion_next_to_nothing_is_added_to_gaussian_scatter() -> None:
    whole = chain(assemble(model()), rig(roving=False))
    factors = simulated_factors(whole, expected_spectra(whole))
    for part in (factors.force, factors.frf, factors.response):
        assert part.min() == 1.0
        # one in twenty lines exceeds by chance what so few tests can tell
        assert part[:, 1:].mean() < 1.15


def test_a_test_is_gone_through_once_for_effects_of_about_one_size() -> None:
    variance, setup = SimulatedVariance(), rig(roving=False)

    def factors(*effects: Effect) -> object:
        whole = chain(assemble(model()), setup, effects)
        return variance.factors(whole, expected_spectra(whole), effects)

    first = factors(CLIPPED)
    assert factors(Overload(None, 2.81)) is first
    assert factors(CLIPPED, ExtraMass(Dof(4, "Y"), 0.01)) is first
    assert factors(Overload(None, 1.4)) is not first


def test_what_repeats_or_ends_within_the_record_has_no_bursts() -> None:
    assert is_intermittent([CUBIC], rig())
    assert not is_intermittent([ExtraMass(Dof(4, "Y"), 0.01)], rig())
    assert not is_intermittent([CUBIC], rig(kind="chirp"))


@pytest.mark.parametrize("roving", [True, False], ids=["roving", "fixed"])
def test_noise_that_the_log_book_leaves_open_hides_distortion_as_declared_noise_does(roving: bool) -> None:
    """Without it a weak distortion, the sum of few bursts, is all that is incoherent at many lines."""
    declared, open_noise = (
        chain(assemble(model()), rig(roving=roving, noise=noise), [CUBIC]) for noise in (1e-3, 0.0)
    )
    noisy, clean = (expected_spectra(each) for each in (declared, open_noise))
    known = simulated_factors(declared, noisy).response
    added = simulated_factors(open_noise, clean, noise=AddedNoise.between(clean, noisy)).response
    without = simulated_factors(open_noise, clean).response
    # means of few tests, each a few bursts: 20 %; without noise several times as much
    assert np.mean(np.log(added / known)) == pytest.approx(0.0, abs=0.2)
    assert np.mean(np.log(without / known)) > 0.7
