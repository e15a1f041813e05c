"""How |H|, phase and coherence of averaged records scatter: drawn, simulated pair by pair, and printed.

`simulate_wishart` is the rig's own draw of averaged spectra. `simulated` shares nothing with it: it
averages the products of complex Gaussian pairs and forms H1 and coherence by hand. `printed` are the
forms of first order in 1/n_d, 1992 thesis eq. [5.16] to [5.19].

    python -m benchmarks.averaging_scatter [tests]
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.bench import Bench, count
from modallab.core.arrays import ComplexArray, FloatArray
from modallab.estimation.coherence import coherence, coherence_error, frf_error
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.wishart import wishart_spectra

COHERENCES: FloatArray = np.array([0.5, 0.9, 0.99])
N_TESTS, N_LINES = 20_000, 10  # repeats of a test, and lines of one coherence in it
TOGETHER = 2**15  # pairs simulated at once


@dataclass(frozen=True, eq=False)
class Scatter:
    """Normalised errors of estimates at each of `COHERENCES`, and the mean of the coherence."""

    magnitude: FloatArray
    phase: FloatArray  # rad
    coherence: FloatArray
    mean_coherence: FloatArray

    @property
    def errors(self) -> FloatArray:
        """(3, n_coherences): magnitude, phase and coherence."""
        return np.array([self.magnitude, self.phase, self.coherence])


def simulate_wishart(averages: float, seed: int, n_tests: int = N_TESTS, n_lines: int = N_LINES) -> Scatter:
    """Return the scatter of drawn tests, `n_lines` lines of each coherence side by side in one run."""
    g2: FloatArray = np.repeat(COHERENCES, n_lines)
    unit = np.ones((1, len(g2), 1, 1), complex)
    lines: FloatArray = np.arange(1.0, len(g2) + 1)
    whole = CrossSpectra(lines, unit, unit, 1 / g2[None, :, None], averages)
    spectra = wishart_spectra(whole, np.random.default_rng(seed), n_tests)
    # every line of a coherence is one more sample of it
    place = np.arange(len(g2)).reshape(len(COHERENCES), n_lines).T
    h = ESTIMATORS["h1"](spectra)[:, place, 0, 0]
    rows = coherence(spectra)[:, place, 0]
    return _scatter(h.reshape(-1, len(COHERENCES)), rows.reshape(-1, len(COHERENCES)))


def simulated(averages: int, seed: int, n_tests: int = N_TESTS * N_LINES) -> Scatter:
    """Return the scatter of as many averages of force and response, H = 1 and white noise on the response."""
    rng = np.random.default_rng(seed)
    parts: list[tuple[ComplexArray, FloatArray]] = []
    batch = max(1, TOGETHER // averages)
    for start in range(0, n_tests, batch):
        shape = (min(batch, n_tests - start), averages, len(COHERENCES), 2)
        force, noise = (rng.standard_normal(shape).view(complex)[..., 0] for _ in "fn")
        response = force + noise * np.sqrt(1 / COHERENCES - 1)
        ff, xx = ((part.real**2 + part.imag**2).sum(axis=1) for part in (force, response))
        fx = (force.conj() * response).sum(axis=1)
        parts.append((fx / ff, np.abs(fx) ** 2 / (ff * xx)))
    h, g2 = (np.concatenate(part) for part in zip(*parts, strict=True))
    return _scatter(h, g2)


def printed(averages: float) -> FloatArray:
    """Return the printed errors of magnitude, phase and coherence, (3, n_coherences)."""
    error = frf_error(COHERENCES, averages)
    return np.array([error, np.arcsin(error), coherence_error(COHERENCES, averages)])


def _scatter(h: ComplexArray, g2: FloatArray) -> Scatter:
    """Return the scatter of H1, true value 1, and coherence, (n_tests, n_coherences) each."""
    return Scatter(
        np.abs(h).std(axis=0), np.angle(h).std(axis=0), (g2 / COHERENCES).std(axis=0), g2.mean(axis=0)
    )


def run(n_tests: int = N_TESTS) -> list[tuple[str, float, float]]:
    """Return the largest difference of the draw from the simulation and from the printed forms."""
    few = simulate_wishart(10, 1, n_tests).errors / simulated(10, 2, n_tests * N_LINES).errors
    rows = [("drawn against simulated scatter, n_d = 10: largest difference", few, 0.02)]
    for averages in (30, 100):
        many = simulate_wishart(averages, 1, n_tests).errors / printed(averages)
        rows.append((f"drawn scatter against [5.16-5.19], n_d = {averages}: largest", many, 0.05))
    return [(name, float(np.abs(ratio - 1).max()), limit) for name, ratio, limit in rows]


def main() -> None:
    """Print all scatters."""
    n_tests = count(__doc__, N_TESTS)
    print("n_d  coherence  error of    printed   drawn     simulated  drawn/printed  drawn/simulated")
    for averages in (10, 30, 100):
        ours, sampled, form = (
            simulate_wishart(averages, 1, n_tests).errors,
            simulated(averages, 2, n_tests * N_LINES).errors,
            printed(averages),
        )
        for i, g2 in enumerate(COHERENCES):
            for j, name in enumerate(("|H|", "phase", "coherence")):
                a, b, c = ours[j, i], sampled[j, i], form[j, i]
                print(
                    f"{averages:3d}  {g2:<9g}  {name:10}  {c:.5f}   {a:.5f}   {b:.5f}"
                    f"    {100 * (a / c - 1):+6.2f} %       {100 * (a / b - 1):+6.2f} %"
                )


BENCH = Bench(run, short=partial(run, n_tests=50))


if __name__ == "__main__":
    main()
