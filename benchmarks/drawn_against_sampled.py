"""Drawn measurements against sampled ones: do H1 and coherence scatter alike?

z is the difference of a line's mean, or variance, between the two routes over its standard error; if
both routes follow one law, z has standard deviation 1 over the lines.

    python -m benchmarks.drawn_against_sampled [tests]
"""

from functools import partial

import numpy as np

from benchmarks.bench import Bench, count
from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.progress import silent
from modallab.estimation.coherence import coherence
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import Chain, chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Accelerometers, Exciter, Noise
from modallab.rig.sampled import sampled_spectra
from modallab.rig.setup import RigSetup
from modallab.rig.wishart import wishart_spectra

TOLERANCE = 0.05
N_TESTS = 1000


def bench(excitation: str, window: str, n_lines: int, n_out: int, averages: int = 20) -> Chain:
    """Return the chapter 5 beam on a noisy rig with a roving accelerometer."""
    setup = RigSetup(
        (Dof(1, "Y"),),
        tuple(Dof(node, "Y") for node in range(1, 1 + 2 * n_out, 2)),
        exciter=Exciter(armature_mass=0.02),
        accelerometers=Accelerometers(0.02, roving=True),
        noise=Noise(1e-2, 1e-3),
        analyser=Analyser(800.0, n_lines, window, averages, excitation=ExcitationSetting(excitation)),
    )
    return chain(assemble(STRUCTURES["chapter-5-beam"]()), setup)


def estimates(tests: list[CrossSpectra], n_run: int) -> tuple[ComplexArray, FloatArray]:
    """Return H1 and coherence without the line at 0 Hz, (n_tests, n_run, n_freq, n_out) each."""
    h = np.concatenate([ESTIMATORS["h1"](s)[:, 1:, :, 0] for s in tests])
    g2 = np.concatenate([coherence(s)[:, 1:] for s in tests])
    return h.reshape(-1, n_run, *h.shape[1:]), g2.reshape(-1, n_run, *g2.shape[1:])


def scores(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return z of means and of variances over the first axis, tests."""
    n, m = len(a), len(b)
    va, vb = a.var(axis=0, ddof=1), b.var(axis=0, ddof=1)
    mean = (a.mean(axis=0) - b.mean(axis=0)) / np.sqrt(va / n + vb / m)

    def error(x: FloatArray, v: FloatArray) -> FloatArray:  # squared, of a variance
        fourth = ((x - x.mean(axis=0)) ** 4).mean(axis=0)
        return np.asarray((fourth - v**2) / len(x))

    return np.asarray(mean), np.asarray((va - vb) / np.sqrt(error(a, va) + error(b, vb)))


def compare(whole: Chain, n_tests: int, seed: int) -> dict[str, FloatArray]:
    """Return z over the lines of H1 (real and imaginary part) and coherence."""
    rng = np.random.default_rng(seed)
    n_run = len(whole.runs)
    sampled = estimates([sampled_spectra(whole, rng, silent) for _ in range(n_tests)], n_run)
    direct = estimates([wishart_spectra(expected_spectra(whole), rng, n_tests)], n_run)
    comparison: dict[str, FloatArray] = {}
    for name, part in (("H1", 0), ("coherence", 1)):
        a, b = (
            np.stack([route[0].real, route[0].imag], axis=-1) if part == 0 else route[1][..., None]
            for route in (sampled, direct)
        )
        comparison[f"{name} mean"], comparison[f"{name} variance"] = scores(a, b)
    return comparison


def run(n_tests: int = N_TESTS, n_lines: int = 201) -> list[tuple[str, float, float]]:
    """Return how far the standard deviation of z is from 1, with independent records."""
    comparison = compare(bench("periodic_random", "rectangular", n_lines, n_out=8), n_tests, seed=1)
    return [
        (
            f"drawn against sampled, {n_tests:,} tests each: |SD of z - 1|, {name}",
            float(abs(z.std() - 1)),
            TOLERANCE,
        )
        for name, z in comparison.items()
    ]


def main() -> None:
    """Print the figures: independent records, and stationary Hanning records with resonances apart."""
    n_tests = count(__doc__, N_TESTS)
    for excitation, window in (("periodic_random", "rectangular"), ("random", "hann")):
        whole = bench(excitation, window, n_lines=201, n_out=8)
        poles, widths = whole.poles()
        freq = whole.setup.analyser.freq[1:]
        reach = 2 * whole.setup.analyser.spacing + 2 * widths
        near = (np.abs(freq[:, None] - poles[:, None, :]) < reach[:, None, :]).any(axis=2)
        for name, z in compare(whole, n_tests, seed=1).items():
            flat, at = z[~near], z[near]
            print(
                f"{excitation:16} {window:12} {name:19} SD of z {z.std():.3f}, mean {z.mean():+.3f}; "
                f"off resonances {flat.std():.3f}, {flat.mean():+.3f}; "
                f"at them {at.std():.3f}, {at.mean():+.3f}"
            )


BENCH = Bench(run, short=partial(run, n_tests=30, n_lines=11))


if __name__ == "__main__":
    main()
