"""How often the 95 % intervals of close modes hold the truth: three pairs one half-power bandwidth apart.

python -m benchmarks.pair_errors 300            # so many tests of each noise

Drawn: periodic random, 100 averages, 401 lines. The modes of a pair are three lines wide, three lines apart,
and have different shapes over five responses.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.bench import Bench, count
from benchmarks.close_modes import ALIKE, MASS, Truth, mac, structure_of
from benchmarks.extraction_errors import AT_ONCE
from benchmarks.leaked_errors import coverage
from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.fe.assembly import assemble
from modallab.fe.structure import Structure
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Noise
from modallab.rig.measure import measurement_of
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.rig.wishart import wishart_spectra

N_TESTS = 200  # of each noise; 1,200 modes
METHOD = "lscf"
QUANTITIES = ("frequency", "loss factor", "|A|")
NOISE = {
    "of the force": Noise(1e-2, 1e-5),
    "of both": Noise(1e-3, 1e-3),
    "of the responses": Noise(0.0, 1e-3),
}
ANALYSER = Analyser(excitation=ExcitationSetting("periodic_random"))
WIDTH = 3 * ANALYSER.spacing  # Hz, half-power bandwidth of every mode, and distance of the modes of a pair
PAIRS = np.array([150.0, 380.0, 610.0])  # Hz, lower mode of each
ABOVE = np.array([1000.0, 1500.0])  # Hz
N_POINTS, N_RESPONSES = 8, 5
DRIVEN = 0.5  # least part of the rms of its shape that a mode has at the drive point
NODE = 0.05  # of a mode's largest constant: below, |A| is no normal number
FAR = 1e6  # standard errors, of a mode that is not found
LEAST, MOST = 0.90, 0.98


def truth_of() -> Truth:
    """Return modes whose shapes the drive point shows, those of a pair unlike at the responses."""
    frequency = np.sort(np.concatenate([PAIRS, PAIRS + WIDTH]))
    rng, responses = np.random.default_rng(0), slice(N_RESPONSES)
    while True:
        shapes = np.linalg.qr(rng.standard_normal((N_POINTS, N_POINTS)))[0] / np.sqrt(MASS)
        truth = Truth(WIDTH / frequency, np.concatenate([frequency, ABOVE]), shapes, (0,))
        modes = shapes[:, : len(frequency)]
        unlike = all(
            mac(modes[responses, n], modes[responses, n + 1]) < ALIKE for n in range(0, len(frequency), 2)
        )
        if unlike and (np.abs(modes[0]) > DRIVEN * np.sqrt((modes**2).mean(axis=0))).all():
            return truth


def setup_of(noise: Noise) -> RigSetup:
    """Return the rig: a shaker at the first point, accelerometers at some."""
    responses = tuple(Dof(point + 1, "Z") for point in range(N_RESPONSES))
    return RigSetup(responses[:1], responses, noise=noise, analyser=ANALYSER)


def drawn(structure: Structure, noise: Noise, n_tests: int) -> Iterator[Measurement]:
    """Yield drawn tests."""
    setup, rng = setup_of(noise), np.random.default_rng(0)
    expected = expected_spectra(chain(assemble(structure), setup))
    for start in range(0, n_tests, AT_ONCE):
        n = min(AT_ONCE, n_tests - start)
        spectra = wishart_spectra(expected, rng, n)
        for i in range(n):
            row = slice(i, i + 1)
            yield measurement_of(
                replace(spectra, ff=spectra.ff[row], fx=spectra.fx[row], xx=spectra.xx[row]), setup
            )


def scores_of(model: ModalModel, eigenvalue: ComplexArray, size: FloatArray) -> tuple[FloatArray, ...]:
    """Return errors over standard errors, (n_modes, 1), the same and (n_modes, n_frf); far if not found."""
    n, significant = len(eigenvalue), size > NODE * size.max(axis=1)[:, None]
    if len(model.modes) != n:
        return np.full((n, 1), FAR), np.full((n, 1), FAR), np.where(significant, FAR, np.nan)
    assert model.modal_constant is not None
    assert model.modal_constant_error is not None
    errors = [mode.standard_errors for mode in model.modes]
    frequency, loss_factor = np.sqrt(eigenvalue.real) / (2 * np.pi), eigenvalue.imag / eigenvalue.real
    by_frequency = (model.frequencies - frequency) / [error["frequency"] for error in errors]
    by_damping = (model.loss_factors - loss_factor) / [error["loss_factor"] for error in errors]
    off = (np.abs(model.modal_constant) - size) / model.modal_constant_error
    return by_frequency[:, None], by_damping[:, None], np.where(significant, off, np.nan)


def figures(n_tests: int) -> Iterator[tuple[str, float]]:
    """Yield names and shares of intervals that hold the truth; modes that are not found count as outside."""
    structure = structure_of(truth_of())
    system, n = assemble(structure), 2 * len(PAIRS)
    basis = system.modes()
    for name, noise in NOISE.items():
        rows = [system.index(response) for response in setup_of(noise).responses]
        size = np.abs(basis.shapes[rows, :n] * basis.shapes[rows[0], :n]).T
        scores = [
            scores_of(
                extract(
                    test.frf,
                    coherence=test.coherence,
                    averages=test.averages,
                    method=METHOD,
                    estimator=ANALYSER.estimator,
                ),
                basis.eigenvalues[:n],
                size,
            )
            for test in drawn(structure, noise, n_tests)
        ]
        for quantity, values in zip(QUANTITIES, zip(*scores, strict=True), strict=True):
            yield f"{METHOD}, noise {name}, {quantity}", coverage(np.array(values))[0]


def run(n_tests: int = N_TESTS) -> list[tuple[str, float, float]]:
    """Return (name, how far the share of intervals that hold the truth is outside 90 to 98 %, limit)."""
    return [
        (f"pairs, {name} {100 * covered:.1f} %; off", max(LEAST - covered, covered - MOST, 0.0), 0.0)
        for name, covered in figures(n_tests)
    ]


BENCH = Bench(run, short=partial(run, n_tests=1))


def main() -> None:
    """Print the shares."""
    for name, covered in figures(count(__doc__, N_TESTS)):
        print(f"{name:<44} {100 * covered:5.1f} %", flush=True)


if __name__ == "__main__":
    main()
