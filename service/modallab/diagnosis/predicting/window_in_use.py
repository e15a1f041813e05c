"""Correction of the window that the log book of an uploaded test declares."""

from dataclasses import replace

import numpy as np

from modallab.estimation.line_scatter import likeliest_window
from modallab.rig.excitation import EXCITATIONS
from modallab.rig.measurement import Measurement


def with_window_in_use(measurement: Measurement) -> tuple[Measurement, tuple[str, ...]]:
    """Return a measurement with the window that its random errors show, and a note if that was corrected.

    The window alone determines how the random errors of neighbouring lines are correlated, so that no model
    of the structure is needed. The declared window is corrected only in uploaded tests of one continuous
    force.
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
    shown = likeliest_window(values, coherence[lines].reshape(values.shape), measurement.averages, declared)
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
