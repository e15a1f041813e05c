"""Excess variance of spectra with intermittent distortion, by simulated tests."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from scipy.special import digamma, polygamma

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.errors import DivergedError, InvalidInputError
from modallab.core.numerics import COHERENCE_ROUNDING
from modallab.estimation.averaging import Averager, effective_averages
from modallab.estimation.coherence import coherence
from modallab.estimation.estimators.h1 import h1
from modallab.estimation.partial_coherence import coherence_of_frfs
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.added_noise import AddedNoise
from modallab.rig.chain import Chain
from modallab.rig.effect import Effect
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.expected import acquisition, expected_spectra, noise_densities, noise_free
from modallab.rig.periodic_variance import VarianceFactors
from modallab.rig.record_correlation import correlated_excess_variance
from modallab.rig.records import Recorder
from modallab.rig.settled_chain import settled_chain
from modallab.rig.setup import RigSetup
from modallab.rig.spectrum_settings import SIMULATED_VARIANCE

Numbers = TypeVar("Numbers", FloatArray, ComplexArray)


def is_intermittent(effects: Sequence[Effect], setup: RigSetup) -> bool:
    """Return whether an effect causes intermittent distortion under random excitation."""
    excitation = EXCITATIONS[setup.analyser.excitation.kind]
    return (
        not excitation.deterministic and excitation.transient is None and any(e.intermittent for e in effects)
    )


class SimulatedVariance:
    """Cache of simulated variance factors, by place and rounded parameters of the intermittent effects."""

    def __init__(self) -> None:
        self._known: dict[Hashable, VarianceFactors | None] = {}
        self.n_simulated = 0  # tests that were gone through

    def factors(
        self,
        chain: Chain,
        spectra: CrossSpectra,
        effects: Sequence[Effect],
        *,
        noise: Callable[[], AddedNoise | None] = lambda: None,
        repeats: int | None = None,
    ) -> VarianceFactors | None:
        """Return the variance factors of a chain with some effects; None if it cannot be simulated.

        Parameters
        ----------
        spectra
            `expected_spectra(chain)`.
        noise
            Returns noise that the chain's log book leaves open; called only where tests are simulated.
        repeats
            Number of simulated tests; None: as the settings have it.
        """
        if repeats is None:
            repeats = (
                SIMULATED_VARIANCE.n_stepped_tests
                if chain.runs[0].local_forces
                else SIMULATED_VARIANCE.n_tests
            )
        key = (repeats, *sorted((e.kind, str(e.at), *_octaves(e)) for e in effects if e.intermittent))
        if key not in self._known:
            self.n_simulated += repeats
            try:
                self._known[key] = _settled_factors(chain, spectra, repeats, noise())
            except (DivergedError, InvalidInputError):  # too steep, or rings too long
                self._known[key] = None
        return self._known[key]


def _octaves(effect: Effect) -> list[int]:
    """Return the logarithms of an effect's parameters, rounded to a fraction of an octave."""
    values = np.maximum(np.abs(list(effect.parameters.values())), np.finfo(float).tiny)
    return [int(size) for size in np.rint(SIMULATED_VARIANCE.values_per_octave * np.log2(values))]


def _settled_factors(
    chain: Chain, spectra: CrossSpectra, repeats: int, noise: AddedNoise | None
) -> VarianceFactors:
    settled = settled_chain(chain)
    if settled is chain:
        return simulated_factors(chain, spectra, repeats, noise=noise)
    return simulated_factors(settled, expected_spectra(settled), repeats, noise=noise)


def simulated_factors(
    chain: Chain,
    spectra: CrossSpectra,
    repeats: int = SIMULATED_VARIANCE.n_tests,
    seed: int = 0,
    *,
    noise: AddedNoise | None = None,
) -> VarianceFactors:
    """Return the variance of spectra over that of averages of Gaussian records, from simulated tests.

    Intermittent distortion is carried by few records, those with large amplitudes or clipped peaks, so that
    averages scatter far more than a Gamma distribution. Equivalent linearisation also leaves out that a
    resonance shifts from record to record. Simulated tests in the time domain with the same effects show
    both: the factor is the mean square of ln(simulated/expected) over the variance of Gaussian records.
    Its bias does not depend on the number of averages; its scatter falls with them.

    With a roving sensor one run with all channels is simulated.

    Parameters
    ----------
    spectra
        `expected_spectra(chain)`.
    repeats
        Number of simulated tests.
    noise
        Noise that the chain's log book leaves open. Its own scatter is that of Gaussian records.

    Raises
    ------
    InvalidInputError
        If a roving sensor follows several simultaneous forces, which is not simulated.
    """
    if chain.n_in > 1 and len(chain.runs) > 1:
        raise InvalidInputError(
            "bursts of distortion are not simulated with a roving accelerometer and several forces",
            field="accelerometers.roving",
            value=True,
            allowed=False,
        )
    n = min(chain.setup.analyser.simulated_averages, SIMULATED_VARIANCE.max_averages)
    if len(chain.runs) > 1:
        chain = _single_run(chain)
        single_run_spectra = expected_spectra(chain)
        single_run_noise = None if noise is None else noise.in_single_run()
        factors = simulated_factors(chain, single_run_spectra, repeats, seed, noise=single_run_noise)
        return _by_run(factors, spectra)
    tests = _simulated_tests(chain, repeats, n, np.random.default_rng(seed))
    if noise is not None:
        spectra, *tests = (noise.added_to(each) for each in (spectra, *tests))
    effective = effective_averages(n, chain.overlap, chain.setup.analyser.line_window)
    share = effective / spectra.averages
    g2 = coherence(spectra)
    incoherent = spectra.xx * (1 - g2 + COHERENCE_ROUNDING)
    error = np.array([_frf_error(test) for test in tests])
    force, response = (np.array(part) for part in zip(*(_powers(test) for test in tests), strict=True))
    # digamma(n) - ln(n) is the mean of the logarithm of an average of Gaussian records.
    force = np.log(force / _powers(spectra)[0]) - digamma(effective) + np.log(effective)
    conditional = effective - (chain.n_in - 1)  # each further force takes up an average
    response = np.log(response / incoherent) - digamma(max(conditional - 1, 0.5)) + np.log(effective)
    frf: ComplexArray = np.log(np.array([_frfs(test) for test in tests]) / _frfs(spectra))
    factors = VarianceFactors(
        _factor(force, polygamma(1, effective), share),
        _factor(frf / error, 1 / max(conditional - 2, 1), share),
        _factor(response, polygamma(1, max(conditional - 1, 0.5)), share),
        (_rescaled_scatter(force, share), _rescaled_scatter(frf, share), _rescaled_scatter(response, share)),
    )
    if chain.source.continuous == 0:
        return factors
    # The correlation of successive records is accounted for separately.
    return replace(
        factors, response=np.maximum(factors.response / correlated_excess_variance(chain, spectra), 1.0)
    )


def _frf_error(test: CrossSpectra) -> FloatArray:
    """Return the standard error of H1 in one average by the test's own coherence, as a fit will weight it."""
    test_coherence = _frf_coherence(test)
    return np.asarray(
        np.sqrt((1 - test_coherence + COHERENCE_ROUNDING) / np.maximum(test_coherence, COHERENCE_ROUNDING))
    )


def _powers(spectra: CrossSpectra) -> tuple[FloatArray, FloatArray]:
    """Return the auto spectra of the forces, of one force without their axis, and the incoherent ones."""
    own = np.arange(spectra.ff.shape[2])
    force = spectra.ff[..., own, own].real
    incoherent = spectra.xx * (1 - coherence(spectra) + COHERENCE_ROUNDING)
    return force[..., 0] if len(own) == 1 else force, incoherent


def _frfs(spectra: CrossSpectra) -> ComplexArray:
    """Return H1 (n_run, n_freq, n_out, n_in), without the axis of the forces if there is one."""
    h = h1(spectra)
    return h[..., 0] if h.shape[3] == 1 else h


def _frf_coherence(spectra: CrossSpectra) -> FloatArray:
    """Return the coherence of each FRF, shaped as `_frfs`: the partial one with several forces."""
    of_frfs = coherence_of_frfs(spectra, h1(spectra), coherence(spectra))
    return of_frfs[..., 0] if of_frfs.shape[3] == 1 else of_frfs


def _single_run(chain: Chain) -> Chain:
    """Return one run with all channels of a roving test, the sensor at the middle place."""
    run = chain.runs[len(chain.runs) // 2]
    responses = tuple(channel for other_run in chain.runs for channel in other_run.responses)
    acquisition_run = replace(
        run.acquisition_run,
        outputs=tuple(dof for other_run in chain.runs for dof in other_run.acquisition_run.outputs),
    )
    return replace(chain, runs=(replace(run, acquisition_run=acquisition_run, responses=responses),))


def _by_run(factors: VarianceFactors, spectra: CrossSpectra) -> VarianceFactors:
    """Return the factors of the single run, split into the runs of the test."""
    n_run, n_lines, n_out = spectra.xx.shape
    rng = np.random.default_rng(n_run)

    def by_run_axis(part: Numbers) -> Numbers:
        """Return an array (.., 1, n_lines, n_run n_out) split by run."""
        by_run = part.reshape(*part.shape[:-3], n_lines, n_run, n_out)
        out: Numbers = np.ascontiguousarray(np.moveaxis(by_run, -2, -3))
        return out

    def with_independent_runs(part: Numbers) -> Numbers:
        """Return deviations whose scatter is independent from run to run."""
        mean, signs = part.mean(axis=0), rng.choice([-1.0, 1.0], (len(part), n_run, 1, 1))
        out: Numbers = mean + signs * (part - mean)
        return out

    assert factors.tests is not None
    force, frf, response = factors.tests
    runs = with_independent_runs(np.repeat(force[..., None], n_run, axis=1))[..., 0]
    return VarianceFactors(
        np.repeat(factors.force, n_run, axis=0),
        by_run_axis(factors.frf),
        by_run_axis(factors.response),
        (runs, with_independent_runs(by_run_axis(frf)), with_independent_runs(by_run_axis(response))),
    )


def _rescaled_scatter(deviation: Numbers, share: float) -> Numbers:
    """Return deviations of tests with their scatter rescaled to another number of averages."""
    mean = deviation.mean(axis=0)
    out: Numbers = mean + np.sqrt(share) * (deviation - mean)
    return out


def _factor(deviation: FloatArray | ComplexArray, variance: float, share: float) -> FloatArray:
    """Return mean squares (n_run, n_freq, ..) over the variance of Gaussian records, at least 1.

    Parameters
    ----------
    deviation
        (n_tests, n_run, n_freq, ..) from what was expected.
    share
        Averages of these tests over those of the test itself.
    """
    mean = deviation.mean(axis=0)
    scatter = (np.abs(deviation - mean) ** 2).sum(axis=0) / (len(deviation) - 1)
    bias = np.maximum(_smooth(np.abs(mean) ** 2 - scatter / len(deviation)), 0.0)
    total = _smooth(scatter) / variance + bias / (share * variance)
    return np.where(total > SIMULATED_VARIANCE.significance_ratio, total, 1.0)


def _smooth(squares: FloatArray) -> FloatArray:
    """Return running means over lines, the second axis."""
    width = min(SIMULATED_VARIANCE.smoothing_lines, squares.shape[1])
    squares = np.concatenate([squares[:, 1:2], squares[:, 1:]], axis=1)  # 0 Hz carries no signal
    padded = np.pad(
        squares, [(0, 0), (width // 2, (width - 1) // 2), *[(0, 0)] * (squares.ndim - 2)], mode="reflect"
    )
    total = np.cumsum(np.concatenate([np.zeros_like(padded[:, :1]), padded], axis=1), axis=1)
    return np.asarray((total[:, width:] - total[:, :-width]) / width)


def _simulated_tests(chain: Chain, repeats: int, n: int, rng: np.random.Generator) -> list[CrossSpectra]:
    """Return the spectra of some tests of n averages each."""
    analyser = replace(chain.setup.analyser, averages=repeats * n)
    longer = replace(chain, setup=replace(chain.setup, analyser=analyser))
    recorder, clean = Recorder(longer), noise_free(chain)
    noise, acquisition_state = noise_densities(chain, clean), acquisition(chain, clean)
    n_run, n_in = len(chain.runs), chain.n_in

    def averager() -> Averager:
        window, shape, rate = analyser.line_window, recorder.shape, recorder.sample_rate
        return Averager(window, shape, rate, n_lines=analyser.n_lines, n_in=n_in)

    sums = [[averager() for _ in range(n_run)] for _ in range(repeats)]
    n_recorded = np.zeros(n_run, int)
    for batch in recorder.batches(noise, rng):
        for effect in chain.effects:
            batch = replace(batch, samples=effect.on_records(batch, acquisition_state, rng))
        test = (n_recorded[batch.run] + np.arange(len(batch.samples))) // n
        n_recorded[batch.run] += len(test)
        for number in np.unique(test):
            sums[number][batch.run].add(batch.samples[test == number])
    spectra = []
    for averagers in sums:
        ff, fx, xx = (np.array(part) for part in zip(*(run.densities() for run in averagers), strict=True))
        spectra.append(CrossSpectra(analyser.freq, ff, fx, xx, n))
    return spectra
