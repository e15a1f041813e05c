"""Noise that is added to expected spectra."""

import numpy as np

from modallab.fe.assembly import assemble
from modallab.rig.added_noise import AddedNoise
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from tests.diagnosing import model, rig


def test_the_noise_between_two_tests_makes_one_of_the_other() -> None:
    noisy, clean = (expected_spectra(chain(assemble(model()), rig(noise=noise))) for noise in (0.1, 0.0))
    made = AddedNoise.between(clean, noisy).added_to(clean)
    np.testing.assert_allclose(made.ff, noisy.ff, rtol=1e-12)
    np.testing.assert_allclose(made.xx, noisy.xx, rtol=1e-12)


def test_a_single_run_has_the_responses_of_all_runs_with_the_noise_of_each() -> None:
    roving, fixed = (
        AddedNoise.between(
            *(
                expected_spectra(chain(assemble(model()), rig(roving=roving, noise=noise)))
                for noise in (0.0, 0.1)
            )
        )
        for roving in (True, False)
    )
    single = roving.in_single_run()
    assert single.ff.shape == fixed.ff.shape
    assert single.xx.shape == fixed.xx.shape
    np.testing.assert_array_equal(single.xx[0, :, 1], roving.xx[1, :, 0])
