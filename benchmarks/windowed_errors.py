"""How often the 95 % intervals of modes of impact tests hold the truth, through an exponential window.

python -m benchmarks.windowed_errors 300            # so many tests of each noise
python -m benchmarks.windowed_errors 300 dobson     # by one method

Sampled: the window ties the errors of neighbouring lines together. The true modes are those of the decaying
records: the window moves every pole, and adds 1.5 lines to every bandwidth.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from benchmarks.bench import Bench, parser
from benchmarks.leaked_errors import NODE, coverage
from modallab.core.arrays import FloatArray
from modallab.core.dof import Dof
from modallab.core.progress import silent
from modallab.estimation.windows import added_loss_factor
from modallab.extraction.extract import extract
from modallab.extraction.method_options import options_type
from modallab.extraction.options import Damping
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.damping import ModalDamping
from modallab.fe.structure import Structure
from modallab.jobs.extracting import correlation_of
from modallab.rig.analyser import Analyser, ExcitationSetting
from modallab.rig.chain import chain
from modallab.rig.hardware import Exciter, Noise
from modallab.rig.measure import Route, measurement_of
from modallab.rig.measurement import Measurement
from modallab.rig.sampled import sampled_spectra
from modallab.rig.setup import RigSetup

N_TESTS = 200  # of each noise; 1,400 modes
METHODS = ("lscf", "dobson")
QUANTITIES = ("frequency", "loss factor", "|A|")
NOISE = {
    "of the force": Noise(1e-2, 1e-5),
    "of both": Noise(1e-3, 1e-3),
    "of the responses": Noise(0.0, 1e-3),
}
BLOWS = ExcitationSetting("impact", level_scatter=0.2)
ANALYSER = Analyser(800.0, 401, window="exponential", averages=20, excitation=BLOWS)
BANDWIDTHS = np.array([1.0, 1.5, 2.0, 3.0, 1.2, 2.5, 1.0, 2.0])  # lines: all modes ring out in a record
# After two rigid bodies and a mode of 24 Hz, to which the window adds a viscous loss factor of 0.12.
FIRST = 3
DRIVE = Dof(1, "Y")
RESPONSES = tuple(Dof(node, "Y") for node in (1, 4, 8, 21))
OFF = 0.02  # of 95 %


@dataclass(frozen=True, eq=False)
class Truth:
    """Modes of the windowed records."""

    frequency: FloatArray  # (n_modes,) Hz
    loss_factor: FloatArray
    size: FloatArray  # (n_modes, n_frf) 1/kg

    @property
    def significant(self) -> FloatArray:
        """(n_modes, n_frf) 1, NaN near a node, where |A| is no normal number."""
        return np.where(self.size > NODE * self.size.max(axis=1)[:, None], 1.0, np.nan)


def structure() -> Structure:
    """Return the free beam of the 1992 thesis with modes of these bandwidths."""
    plain = STRUCTURES["chapter-5-beam"]()
    modes = slice(2, 2 + len(BANDWIDTHS))
    frequency = np.sqrt(assemble(plain).modes().eigenvalues.real[modes]) / (2 * np.pi)
    return replace(plain, damping=ModalDamping(tuple((BANDWIDTHS * ANALYSER.spacing / frequency).tolist())))


def truth() -> Truth:
    """Return the modes of records that decay by exp(-sigma t): every pole moves by i sigma."""
    system = assemble(structure())
    basis, modes = system.modes(), slice(FIRST, 2 + len(BANDWIDTHS))
    pole, shapes = np.sqrt(basis.eigenvalues[modes]), basis.shapes[:, modes]
    frequency = pole.real / (2 * np.pi)
    added = added_loss_factor(ANALYSER.window_end, ANALYSER.record_length, frequency)
    moved = pole + 1j * np.pi * frequency * added
    rows = [system.index(response) for response in RESPONSES]
    constant = (shapes[rows] * shapes[system.index(DRIVE)]).T * (moved / pole)[:, None]
    eigenvalue = moved**2
    return Truth(np.sqrt(eigenvalue.real) / (2 * np.pi), eigenvalue.imag / eigenvalue.real, np.abs(constant))


def measured(noise: Noise, n_tests: int) -> Iterator[Measurement]:
    """Yield sampled hammer tests."""
    setup = RigSetup((DRIVE,), RESPONSES, exciter=Exciter("hammer"), noise=noise, analyser=ANALYSER)
    whole = chain(assemble(structure()), setup)
    for seed in range(n_tests):
        spectra = sampled_spectra(whole, np.random.default_rng(seed), silent)
        yield replace(measurement_of(spectra, setup), route=Route.SAMPLED)


def scores_of(measurement: Measurement, method: str, true: Truth) -> tuple[FloatArray, ...]:
    """Return errors over standard errors, (n_modes, 1), the same and (n_modes, n_frf)."""
    model = extract(
        measurement.frf,
        coherence=measurement.coherence,
        averages=measurement.averages,
        method=method,
        options=options_type(method)(damping=Damping.STRUCTURAL),
        estimator=measurement.setup.analyser.estimator,
        correlation=correlation_of(measurement),
    )
    rows = np.abs(model.frequencies - true.frequency[:, None]).argmin(axis=1)
    errors = [model.modes[row].standard_errors for row in rows]
    assert model.modal_constant is not None
    assert model.modal_constant_error is not None
    by_frequency = (model.frequencies[rows] - true.frequency) / [e["frequency"] for e in errors]
    by_damping = (model.loss_factors[rows] - true.loss_factor) / [e["loss_factor"] for e in errors]
    off = (np.abs(model.modal_constant[rows]) - true.size) / model.modal_constant_error[rows]
    return by_frequency[:, None], by_damping[:, None], off * true.significant


def figures(n_tests: int, methods: Sequence[str] = METHODS) -> Iterator[tuple[str, float, float, float]]:
    """Yield names, shares of intervals that hold the truth, and their Wilson bounds."""
    true = truth()
    for name, noise in NOISE.items():
        tests = list(measured(noise, n_tests))
        for method in methods:
            of_tests = [scores_of(test, method, true) for test in tests]
            for quantity, values in zip(QUANTITIES, zip(*of_tests, strict=True), strict=True):
                yield (f"{method}, noise {name}, {quantity}", *coverage(np.array(values)))


def run(n_tests: int = N_TESTS) -> list[tuple[str, float, float]]:
    """Return (name, how far the share of intervals that hold the truth is from 95 %, limit)."""
    return [
        (f"windowed, {name} {100 * covered:.1f} %; off", max(lower - 0.95, 0.95 - upper, 0.0), OFF)
        for name, covered, lower, upper in figures(n_tests)
    ]


BENCH = Bench(run, short=partial(run, n_tests=1))


def main() -> None:
    """Print the shares."""
    arguments = parser(__doc__)
    arguments.add_argument("tests", type=int, nargs="?", default=N_TESTS)
    arguments.add_argument("methods", nargs="*", metavar="method", help=f"default: {' '.join(METHODS)}")
    options = arguments.parse_args()
    for name, covered, lower, upper in figures(options.tests, options.methods or METHODS):
        print(f"{name:<48} {100 * covered:5.1f} %  ({100 * lower:.1f} to {100 * upper:.1f})", flush=True)


if __name__ == "__main__":
    main()
