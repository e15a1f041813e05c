"""How often the 95 % intervals of modes read from leaked records hold the truth, over sampled tests.

python -m benchmarks.leaked_errors 300            # so many tests, a table by mode
python -m benchmarks.leaked_errors 300 dobson     # by one method

Sampled: leakage ties the errors of neighbouring lines and of all channels together, and the route that draws
lines knows nothing of that.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from benchmarks.bench import Bench, parser
from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import NoModeInBandError
from modallab.core.progress import silent
from modallab.estimation.windows import WINDOWS
from modallab.extraction.extract import extract
from modallab.extraction.preprocessing.leakage import WindowLeakage
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import ModalDamping
from modallab.fe.structure import Structure
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.hardware import Noise
from modallab.rig.measure import measurement_of
from modallab.rig.measurement import Measurement
from modallab.rig.sampled import sampled_spectra
from modallab.rig.setup import RigSetup

N_TESTS = 100  # of `run`; coverage of some 700 modes is then known to 1.5 %
METHODS = ("dobson", "lscf")
ESTIMATORS = ("h1", "h2")
QUANTITIES = ("frequency", "loss factor", "|A|")
# Half-power bandwidths in lines of the free beam's modes; they lie 19, 33, 46 ... lines apart.
BANDWIDTHS = (0.3, 0.5, 1.0, 2.0, 5.0, 0.7, 3.0, 1.4)
LINES, AVERAGES = Analyser(frequency_max=800.0, n_lines=401), 50
MODES = slice(2, 2 + len(BANDWIDTHS))  # after two rigid bodies
DRIVE = Dof(1, "Y")
RESPONSES = tuple(Dof(node, "Y") for node in (1, 4, 8, 21))
NODE = 0.05  # of a mode's largest constant: below, |A| is no normal number
NEAR = 0.03  # of the frequency: what is read further off is another mode
WITHIN = 1.96  # standard errors
OFF = 0.02  # of 95 %


@dataclass(frozen=True, eq=False)
class Truth:
    """The modes of the beam."""

    frequency: FloatArray  # (n_modes,) Hz
    loss_factor: FloatArray
    constant: ComplexArray  # (n_modes, n_frf) 1/kg


@dataclass(frozen=True, eq=False)
class Scores:
    """Errors over their standard errors; NaN where a mode is not seen or flagged for its leakage."""

    frequency: FloatArray  # (n_tests, n_modes)
    loss_factor: FloatArray
    size: FloatArray  # (n_tests, n_modes, n_frf)
    visible: FloatArray  # (n_tests, n_modes) 1 where it is, flagged or not

    def of(self, quantity: str) -> FloatArray:
        """Return those of a quantity, (n_tests, n_modes, n)."""
        return {
            "frequency": self.frequency[:, :, None],
            "loss factor": self.loss_factor[:, :, None],
            "|A|": self.size,
        }[quantity]


def run(n_tests: int = N_TESTS) -> list[tuple[str, float, float]]:
    """Return (name, how far the share of intervals that hold the truth is from 95 %, limit)."""
    rows = []
    for (method, estimator), scores in all_scores(n_tests).items():
        for quantity in QUANTITIES:
            covered, lower, upper = coverage(scores.of(quantity))
            off = max(lower - 0.95, 0.95 - upper, 0.0)
            rows.append((f"leaked, {method}, {estimator}: {quantity} {100 * covered:.1f} %; off", off, OFF))
    return rows


def coverage(scores: FloatArray) -> tuple[float, float, float]:
    """Return the share within the interval and its Wilson bounds; FRFs of one mode count as one number."""
    statement = np.isfinite(scores)
    n = int(statement.any(axis=2).sum())
    share = float((np.abs(scores[statement]) < WITHIN).mean()) if n else float("nan")
    z2 = WITHIN**2
    middle = (share + z2 / (2 * n)) / (1 + z2 / n) if n else share
    half = WITHIN / (1 + z2 / n) * np.sqrt(share * (1 - share) / n + z2 / (4 * n**2)) if n else share
    return share, float(middle - half), float(middle + half)


def all_scores(
    n_tests: int, methods: Sequence[str] = METHODS, first: int = 0
) -> dict[tuple[str, str], Scores]:
    """Return the scores of every method and estimator, from the same records; seeds from `first` on."""
    true, kinds = truth(), [(method, estimator) for method in methods for estimator in ESTIMATORS]
    kind_scores: dict[tuple[str, str], list[tuple[FloatArray, ...]]] = {kind: [] for kind in kinds}
    for tests in measured(n_tests, first):
        for method, estimator in kinds:
            kind_scores[method, estimator].append(_scores(tests[estimator], method, estimator, true))
    return {
        kind: Scores(*(np.array(part) for part in zip(*tests, strict=True)))
        for kind, tests in kind_scores.items()
    }


def structure() -> Structure:
    """Return the free beam of the 1992 thesis with modes of these bandwidths."""
    plain = STRUCTURES["chapter-5-beam"]()
    frequency = np.sqrt(assemble(plain).modes().eigenvalues.real[MODES]) / (2 * np.pi)
    spacing = LINES.frequency_max / (LINES.n_lines - 1)
    factors = np.array(BANDWIDTHS) * spacing / frequency
    return replace(plain, damping=ModalDamping(tuple(factors.tolist())))


def truth() -> Truth:
    """Return the modes that the tests are of."""
    system = assemble(structure())
    basis = system.modes()
    eigenvalue, shapes = basis.eigenvalues[MODES], basis.shapes[:, MODES]
    at_mode = shapes[system.index(DRIVE)]
    constant = np.array([shapes[system.index(response)] * at_mode for response in RESPONSES]).T
    return Truth(np.sqrt(eigenvalue.real) / (2 * np.pi), eigenvalue.imag / eigenvalue.real, constant)


def measured(n_tests: int, first: int = 0) -> Iterator[dict[str, Measurement]]:
    """Yield tests, of each the measurement by every estimator."""
    analyser = replace(LINES, window="hann", averages=AVERAGES, excitation=ExcitationSetting("random"))
    setup = RigSetup((DRIVE,), RESPONSES, noise=Noise(force=1e-2, response=1e-5), analyser=analyser)
    whole = chain(assemble(structure()), setup)
    by = {kind: replace(setup, analyser=replace(analyser, estimator=kind)) for kind in ESTIMATORS}
    for seed in range(first, first + n_tests):
        spectra = sampled_spectra(whole, np.random.default_rng(seed), silent)
        yield {kind: measurement_of(spectra, mode_values) for kind, mode_values in by.items()}


def _scores(measurement: Measurement, method: str, estimator: str, true: Truth) -> tuple[FloatArray, ...]:
    n_modes, n_frf = true.constant.shape
    out = np.full(n_modes, np.nan), np.full(n_modes, np.nan), np.full((n_modes, n_frf), np.nan)
    visible = np.zeros(n_modes)
    try:
        model = extract(
            measurement.frf,
            coherence=measurement.coherence,
            averages=measurement.averages,
            method=method,
            leakage=WindowLeakage.from_window(WINDOWS["hann"].samples(1024), estimator),
            estimator=estimator,
        )
    except NoModeInBandError:
        return (*out, visible)
    assert model.modal_constant is not None
    assert model.modal_constant_error is not None
    significant = np.abs(true.constant) > NODE * np.abs(true.constant).max(axis=1)[:, None]
    for m, frequency in enumerate(true.frequency):
        at = int(np.abs(model.frequencies - frequency).argmin())
        mode = model.modes[at]
        if abs(mode.frequency - frequency) > NEAR * frequency:
            continue
        visible[m] = 1.0
        if any("leakage_bias" in flag for flag in mode.flags):
            continue
        out[0][m] = (mode.frequency - frequency) / mode.standard_errors["frequency"]
        out[1][m] = (mode.loss_factor - true.loss_factor[m]) / mode.standard_errors["loss_factor"]
        off = np.abs(model.modal_constant[at]) - np.abs(true.constant[m])
        out[2][m] = np.where(significant[m], off / model.modal_constant_error[at], np.nan)
    return (*out, visible)


def report(scores: dict[tuple[str, str], Scores]) -> Iterator[str]:
    """Yield counts and shares by method, estimator and quantity, and by mode."""
    for (method, estimator), kind_scores in scores.items():
        for quantity in QUANTITIES:
            values = kind_scores.of(quantity)
            covered, lower, upper = coverage(values)
            n, visible = int(np.isfinite(values).any(axis=2).sum()), int(kind_scores.visible.sum())
            yield (
                f"{method} {estimator} {quantity:<12} {100 * covered:5.1f} % "
                f"({100 * lower:.1f} to {100 * upper:.1f}) of {n} modes; "
                f"{visible - n} flagged, {kind_scores.visible.size - visible} not seen"
            )
            for m, width in enumerate(BANDWIDTHS):
                z = values[:, m]
                if np.isfinite(z).any():
                    share = (np.abs(z[np.isfinite(z)]) < WITHIN).mean()
                    yield (
                        f"    {width:4.1f} lines {100 * share:6.1f} %  rms {np.sqrt(np.nanmean(z**2)):5.2f} "
                        f"mean {np.nanmean(z):6.2f}  of {int(np.isfinite(z).any(axis=1).sum())}"
                    )


BENCH = Bench(run, short=partial(run, n_tests=1))


def main() -> None:
    """Print the table."""
    arguments = parser(__doc__)
    arguments.add_argument("tests", type=int, nargs="?", default=N_TESTS)
    arguments.add_argument("methods", nargs="*", metavar="method", help=f"default: {' '.join(METHODS)}")
    options = arguments.parse_args()
    for line in report(all_scores(options.tests, options.methods or METHODS)):
        print(line)


if __name__ == "__main__":
    main()
