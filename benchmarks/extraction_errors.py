"""How often the 95 % intervals of extracted modes hold the truth, over 1,000 drawn tests of the beam.

    python -m benchmarks.extraction_errors [tests]

This prints drawn tests through a Hann window too, without a limit: lines that are drawn one by one do not
scatter as those of leaking records, which go together. Those are in `benchmarks.leaked_errors`.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.bench import Bench, count
from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.dof import Dof
from modallab.core.modal_model import ModalModel
from modallab.estimation.windows import WINDOWS
from modallab.extraction.extract import extract
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.expected import expected_spectra
from modallab.rig.hardware import Noise
from modallab.rig.measure import measurement_of
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.rig.wishart import wishart_spectra

N_TESTS = 1000
AT_ONCE = 50  # tests drawn together
METHODS = ("lscf", "dobson")
COVERED, MOST_OFF = 0.95, 0.02
MODES = slice(2, 10)  # of the free beam: two rigid bodies, then eight below 800 Hz
DRIVE = Dof(1, "Y")
RESPONSES = tuple(Dof(node, "Y") for node in range(1, 22, 2))


def run(n_tests: int = N_TESTS) -> list[tuple[str, float, float]]:
    """Return (name, how far the share of intervals that hold the truth is from 95 %, limit)."""
    rows = []
    for method in METHODS:
        for quantity, covered in coverages(method, n_tests).items():
            name = f"{method}: {100 * covered:.1f} % of intervals of {quantity} hold the truth; off"
            rows.append((name, abs(covered - COVERED), MOST_OFF))
    return rows


def coverages(
    method: str, n_tests: int = N_TESTS, estimator: str = "h2", window: str | None = None
) -> dict[str, float]:
    """Return the share of 95 % intervals that hold the truth, of frequency, loss factor and |A|.

    Eleven accelerometers, periodic random, 100 averages, 401 lines, noise of 1e-2 on the force and 1e-5
    on the responses. |A| is of all modes in all FRFs, those at nodes left out, where it is no normal number.
    With a window the force is random, and modes flagged for leakage do not count.
    """
    frequency, loss_factor, constant = _truth()
    size, significant = np.abs(constant), np.abs(constant) > 0.05 * np.abs(constant).max(axis=1)[:, None]
    inside: dict[str, list[FloatArray]] = {"frequency": [], "loss factor": [], "|A|": []}
    leakage = None if window is None else WindowLeakage.from_window(WINDOWS[window].samples(1024), estimator)
    for measurement in _tests(n_tests, estimator, window):
        model = extract(
            measurement.frf,
            coherence=measurement.coherence,
            averages=measurement.averages,
            method=method,
            leakage=leakage,
            estimator=estimator,
        )
        assert leakage is not None or len(model.modes) == len(frequency)
        matched, true = _matched(model, frequency)
        assert model.modal_constant is not None
        assert model.modal_constant_error is not None
        off = np.abs(np.abs(model.modal_constant[matched]) - size[true]) / model.modal_constant_error[matched]
        for name, exact, rows in (
            ("frequency", frequency, model.frequencies),
            ("loss_factor", loss_factor, model.loss_factors),
        ):
            score = np.abs(rows[matched] - exact[true]) / _errors(model, name)[matched]
            inside[name.replace("_", " ")].append(score)
        inside["|A|"].append(off[significant[true]])
    return {quantity: float((np.concatenate(scores) < 1.96).mean()) for quantity, scores in inside.items()}


def _matched(model: ModalModel, frequency: FloatArray) -> tuple[IntArray, IntArray]:
    """Return which modes are those of which frequencies, the ones left out that leakage may bias."""
    nearest = np.abs(model.frequencies - frequency[:, None]).argmin(axis=1)
    flagged = np.array([any("leakage_bias" in flag for flag in mode.flags) for mode in model.modes])
    true = np.flatnonzero(~flagged[nearest])
    return nearest[true], true


def _errors(model: ModalModel, of: str) -> FloatArray:
    return np.array([mode.standard_errors[of] for mode in model.modes])


def _truth() -> tuple[FloatArray, FloatArray, ComplexArray]:
    system = assemble(STRUCTURES["chapter-5-beam"]())
    basis = system.modes()
    eigenvalue, shapes = basis.eigenvalues[MODES], basis.shapes[:, MODES]
    drive_shapes = shapes[system.index(DRIVE)]
    constant = np.array([shapes[system.index(response)] * drive_shapes for response in RESPONSES]).T
    return np.sqrt(eigenvalue.real) / (2 * np.pi), eigenvalue.imag / eigenvalue.real, constant


def _tests(n_tests: int, estimator: str, window: str | None) -> Iterator[Measurement]:
    excitation = ExcitationSetting("periodic_random" if window is None else "random")
    setup = RigSetup(
        (DRIVE,),
        RESPONSES,
        noise=Noise(force=1e-2, response=1e-5),
        analyser=Analyser(estimator=estimator, window=window or "rectangular", excitation=excitation),
    )
    expected = expected_spectra(chain(assemble(STRUCTURES["chapter-5-beam"]()), setup))
    rng = np.random.default_rng(0)
    for start in range(0, n_tests, AT_ONCE):
        n = min(AT_ONCE, n_tests - start)
        spectra = wishart_spectra(expected, rng, n)
        for i in range(n):
            frf_slice = slice(i, i + 1)
            yield measurement_of(
                replace(
                    spectra, ff=spectra.ff[frf_slice], fx=spectra.fx[frf_slice], xx=spectra.xx[frf_slice]
                ),
                setup,
            )


BENCH = Bench(run, short=partial(run, n_tests=1))


def main() -> None:
    """Print the shares of drawn tests, and of a fifth as many through a Hann window."""
    n_tests = count(__doc__, N_TESTS)
    for kind in METHODS:
        print(kind, coverages(kind, n_tests))
        for spectrum in ("h1", "h2"):
            print(kind, "hann", spectrum, coverages(kind, max(1, n_tests // 5), spectrum, "hann"))


if __name__ == "__main__":
    main()
