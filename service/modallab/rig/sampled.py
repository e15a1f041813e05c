"""Sampled spectra: time records through window, Fourier transform and averaging (route `sampled`)."""

from dataclasses import replace

import numpy as np

from modallab.core.progress import Progress
from modallab.estimation.averaging import Averager, Densities, effective_averages
from modallab.estimation.spectra import CrossSpectra
from modallab.rig.chain import Chain
from modallab.rig.estimates import SnapshotKeeper
from modallab.rig.expected import acquisition, noise_densities, noise_free
from modallab.rig.records import Recorder
from modallab.rig.time_records import RecordKeeper


def sampled_spectra(
    chain: Chain,
    rng: np.random.Generator,
    progress: Progress,
    keeper: RecordKeeper | None = None,
    snapshots: SnapshotKeeper | None = None,
) -> CrossSpectra:
    """Return the averaged spectra of every run from simulated time records.

    The source's signal is Gaussian; what of it repeats with the record is drawn anew for every
    average, what does not is a stationary process, cut into records that overlap. Force and responses
    follow through the exact frequency responses; the sensors add white noise.

    Parameters
    ----------
    keeper
        Receiver of the records, as the analyser takes them.
    snapshots
        Receiver of the spectra while averages are taken.

    Raises
    ------
    InvalidInputError
        If a mode rings too long for stationary records to be simulated.
    """
    analyser, window = chain.setup.analyser, chain.setup.analyser.line_window
    recorder = Recorder(chain)
    clean = noise_free(chain)
    noise, acquisition_state = noise_densities(chain, clean), acquisition(chain, clean)
    n_run, n_in = len(chain.runs), chain.n_in
    noted = () if snapshots is None else snapshots.counts
    runs: list[Densities] = []
    averager = None
    for batch in recorder.batches(noise, rng):
        if averager is None:
            size = {"n_lines": analyser.n_lines, "n_in": n_in}
            averager = Averager(window, recorder.shape, recorder.sample_rate, **size, noted=noted)
        for effect in chain.effects:
            batch = replace(batch, samples=effect.on_records(batch, acquisition_state, rng))
        run, count = batch.run, averager.count + len(batch.samples)
        averager.add(batch.samples)
        if keeper is not None:
            keeper.add(run, batch.samples)
        del batch  # not kept while the next one is made
        progress(
            (run + count / analyser.simulated_averages) / n_run,
            f"run {run + 1} of {n_run}, average {count} of {analyser.simulated_averages}",
        )
        if count == analyser.simulated_averages:
            runs.append(averager.densities())
            if snapshots is not None:
                snapshots.add(averager.snapshots)
            averager = None
    ff, fx, xx = (np.array(part) for part in zip(*runs, strict=True))
    averages = effective_averages(analyser.simulated_averages, chain.overlap, window)
    return CrossSpectra(analyser.freq, ff, fx, xx, averages)
