"""The window that the records of an uploaded test really had, where its log book contradicts the lines."""

from dataclasses import replace

import numpy as np

from modallab.estimation.line_scatter import window_shown
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.measurement import Measurement


def with_window_in_use(measurement: Measurement) -> tuple[Measurement, tuple[str, ...]]:
    """Return a measurement with the window that its random errors show, and a note of a correction.

    The window correlates the random errors of neighbouring lines whatever the structure does, and so is told
    without a model. A window that the lines do not contradict stays; so do all windows of tests that this
    service simulated, of transients, and of simultaneous forces.
    """
    setup = measurement.setup
    excitation = EXCITATIONS[setup.analyser.excitation.kind]
    coherence = measurement.frf_coherence
    simulated, transient = measurement.route is not None, excitation.transient is not None
    if simulated or transient or excitation.line_by_line or coherence is None or setup.n_simultaneous > 1:
        return measurement, ()
    lines = measurement.frf.freq > 0
    values = np.asarray(measurement.frf.values, complex)[lines].reshape(int(lines.sum()), -1)
    declared = setup.analyser.window
    shown = window_shown(values, coherence[lines].reshape(values.shape), measurement.averages, declared)
    if shown == declared:
        return measurement, ()
    contradiction = (
        f"The log book declares the window {declared}; the random errors of neighbouring lines are "
        f"correlated as by {shown}"
    )
    if excitation.continuous > 0 and shown == "rectangular":
        # Random excitation through no window would leak far more than the one declared.
        return measurement, (f"{contradiction}, as of a source that repeats with the record",)
    setup = replace(setup, analyser=replace(setup.analyser, window=shown))
    return replace(measurement, setup=setup), (f"{contradiction}: taken to be {shown}",)
