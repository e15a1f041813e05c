"""Simulated measurement by any route."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import ComplexArray, FloatArray, IntArray
from modallab.core.errors import InvalidInputError
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.progress import Progress, silent
from modallab.estimation.coherence import coherence
from modallab.estimation.condition import independent_condition
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.assembly import assemble
from modallab.fe.structure import Structure
from modallab.rig.acquisition import sample_rate_of
from modallab.rig.analyser import Analyser
from modallab.rig.chain import Chain, chain
from modallab.rig.compatibility import check_compatible
from modallab.rig.distortion import check_first_order
from modallab.rig.effect import Effect, build
from modallab.rig.estimates import Estimates, SnapshotKeeper, check_estimates
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.expected import expected_spectra, noise_free, noise_in_lines, with_noise
from modallab.rig.measurement import Measurement
from modallab.rig.periodic import periodic_signals
from modallab.rig.sampled import sampled_spectra
from modallab.rig.settings import SOURCE
from modallab.rig.setup import RigSetup
from modallab.rig.time_records import RecordKeeper, check_records
from modallab.rig.wishart import wishart_spectra
from modallab.rig.wishart_periodic import noncentral_wishart_spectra, signal_of


class Route(StrEnum):
    """How a measurement comes about."""

    EXPECTED = "expected"  # spectra without random error
    DRAWN = "drawn"  # a draw from the law of averaged spectra around the expected ones
    SAMPLED = "sampled"  # time records through window, transform and averages


def measure(
    structure: Structure,
    setup: RigSetup,
    effects: Sequence[Effect] = (),
    *,
    route: Route = Route.SAMPLED,
    rng: np.random.Generator,
    progress: Progress = silent,
    records: int = 0,
    estimates: int = 0,
) -> Measurement:
    """Return the simulated measurement of a structure on a rig.

    Parameters
    ----------
    effects
        Effects beside the declared hardware; they do not appear in the measurement's log book.
    rng
        The only source of randomness; not drawn from on the expected route.
    records
        Number of time records that the measurement keeps of every run.
    estimates
        Number of estimates of FRFs and coherence that it keeps while averages are taken, the last after all.

    Raises
    ------
    UnknownDofError
        If the rig drives or listens where the structure has no DoF.
    InvalidInputError
        If an effect, declared or not, cannot sit where it is said to.
    """
    route = Route(route)  # its plain name is taken for it too
    declared, setup = setup, setup.simulated
    check_compatible(setup)
    _check_band(setup)
    check_records(records, setup, sampled=route is Route.SAMPLED)
    check_estimates(estimates, setup, sampled=route is Route.SAMPLED)
    modelled = [build(spec) for spec in structure.effects]
    for effect in [*modelled, *(build(spec) for spec in setup.effects), *effects]:
        effect.check(structure, setup)
    measuring_chain = chain(assemble(structure), setup, [*modelled, *effects])
    if route is not Route.SAMPLED:
        check_first_order(measuring_chain.runs, measuring_chain.setup.analyser, measuring_chain.source)
    analyser = measuring_chain.setup.analyser
    keeper = RecordKeeper(records, sample_rate_of(analyser)) if records else None
    snapshots = SnapshotKeeper(estimates, analyser, measuring_chain.n_in) if estimates else None
    if route is Route.SAMPLED:
        spectra = sampled_spectra(measuring_chain, rng, progress, keeper, snapshots)
    elif route is Route.DRAWN:
        spectra = draw(measuring_chain, rng)
    else:
        spectra = expected_spectra(measuring_chain)
    progress(1.0, "measured")
    lines = analyser.lines_at(setup.analyser.freq)
    measured = measurement_of(spectra.at(lines), declared)
    return replace(
        measured,
        records=keeper.records(measuring_chain.n_in) if keeper else None,
        estimates=_estimates(snapshots, measuring_chain, lines, measured) if snapshots else None,
    )


def _estimates(snapshots: SnapshotKeeper, chain: Chain, lines: IntArray, measured: Measurement) -> Estimates:
    """Return the estimates after the first averages, from as many on as tell the forces apart."""
    counts, tests = [], []
    for count, spectra in snapshots.spectra(chain):
        with suppress(InvalidInputError):  # too few averages for the forces that act at once
            tests.append(measurement_of(spectra.at(lines), measured.setup))
            counts.append(count)
    tests.append(measured)  # of the same shape, even where it is alone
    values = np.array([test.frf.values for test in tests], np.complex64)
    coherence = np.array([test.coherence for test in tests], np.float32)
    return Estimates(np.array(counts, int), values[:-1], coherence[:-1])


def _check_band(setup: RigSetup) -> None:
    """Raise unless a source can be simulated in its band."""
    analyser = setup.analyser
    if analyser.excitation.band is None:
        return
    kind, (first, last) = analyser.excitation.kind, analyser.driven_lines
    if EXCITATIONS[kind].transient is not None:
        raise InvalidInputError(
            f"{kind} is simulated over the whole band only: cut to a band, it would not end in the record",
            field="excitation.band",
            value=list(analyser.excitation.band),
            allowed="null",
        )
    top = round(analyser.frequency_max / analyser.spacing)
    if last > top or last - first < SOURCE.min_band_lines:
        raise InvalidInputError(
            "the source's band is too narrow, or ends above that of the analyser",
            field="excitation.band",
            value=list(analyser.excitation.band),
            allowed=f"{SOURCE.min_band_lines} lines and more, up to {analyser.frequency_max:g} Hz",
        )


def draw(chain: Chain, rng: np.random.Generator) -> CrossSpectra:
    """Return spectra drawn from the sampling distribution of averages."""
    clean, steady = noise_free(chain), periodic_signals(chain)
    expected = with_noise(chain, clean)
    noise = noise_in_lines(chain, clean)[:, 0]
    if steady is not None:
        return noncentral_wishart_spectra(expected, clean, noise, steady, rng)
    return wishart_spectra(expected, rng, signal=signal_of(expected, clean, noise))


def measurement_of(spectra: CrossSpectra, setup: RigSetup) -> Measurement:
    """Return FRFs, coherence and auto spectra from the averaged spectra of all runs.

    Raises
    ------
    InvalidInputError
        If several forces act at once and are not independent of each other.
    """
    condition = independent_condition(spectra) if spectra.ff.shape[2] > 1 else None
    table = _Table(setup)
    force = spectra.ff.real[..., np.arange(spectra.ff.shape[2]), np.arange(spectra.ff.shape[2])]
    single = len(setup.drives) == 1 or setup.exciter.kind != "hammer"

    def by_response(values: FloatArray) -> FloatArray:
        """Return one value a response, or, where the hammer roves, one for each FRF."""
        placed = table.placed(np.broadcast_to(values[..., None], (*values.shape, spectra.ff.shape[2])))
        return placed[:, :, 0] if single else placed

    return Measurement(
        frf=FrfSet(
            spectra.freq,
            table.placed(ESTIMATORS[setup.analyser.estimator](spectra)),
            setup.responses,
            setup.drives,
            FrfKind.INERTANCE,
        ),
        coherence=by_response(coherence(spectra)),
        averages=spectra.averages,
        setup=setup,
        force_spectrum=table.placed(np.broadcast_to(force[:, :, None], spectra.fx.swapaxes(2, 3).shape)),
        response_spectrum=by_response(spectra.xx),
        # of all runs the worst: none of the FRFs is worse off
        input_condition=None if condition is None else condition.max(axis=0),
        force_cross_spectra=None if condition is None else _of_responses(spectra.ff, setup),
        notes=_notes(setup.analyser),
    )


def _of_responses(ff: ComplexArray, setup: RigSetup) -> ComplexArray:
    """Return G_ff (n_run, n_freq, n_in, n_in) of all runs by response, (n_freq, n_out, n_in, n_in)."""
    run_of_response = [i for i, run in enumerate(setup.acquisition_runs) for _ in run.outputs]
    return np.asarray(ff[run_of_response].swapaxes(0, 1))


def _notes(analyser: Analyser) -> tuple[str, ...]:
    """Return notes on systematic changes of the FRFs by the analyser."""
    end = analyser.line_window.end
    if end == 1:
        return ()
    sigma = -np.log(end) / analyser.record_length
    return (
        f"the exponential window adds 2 sigma/omega, sigma = {sigma:.4g} 1/s, to every loss factor: "
        f"{sigma / np.pi:.4g} over the frequency in Hz",
    )


class _Table:
    """Where the channels of every run stand among all responses and drive points of a test."""

    def __init__(self, setup: RigSetup) -> None:
        rows = {dof: i for i, dof in enumerate(setup.responses)}
        columns = {dof: i for i, dof in enumerate(setup.drives)}
        self._size = len(rows), len(columns)
        self._places = [
            np.ix_([rows[d] for d in acquisition_run.outputs], [columns[d] for d in acquisition_run.drives])
            for acquisition_run in setup.acquisition_runs
        ]

    def placed(self, runs: NDArray[Any]) -> NDArray[Any]:
        """Return values (n_run, n_freq, n_out, n_in) of all runs side by side, (n_freq, all, all)."""
        combined = np.empty((runs.shape[1], *self._size), runs.dtype)
        for run, (rows, columns) in zip(runs, self._places, strict=True):
            combined[:, rows, columns] = run
        return combined
