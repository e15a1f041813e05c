"""FRFs and coherence of a measurement while its averages were taken."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import NotFoundError
from modallab.rig.measurement import Measurement


def estimate_arrays(measurement: Measurement) -> dict[str, NDArray[Any]]:
    """Return the estimates of a measurement as arrays; the last are its FRFs and coherence.

    Raises
    ------
    NotFoundError
        If none were kept.
    """
    frf, kept = measurement.frf, measurement.estimates
    if kept is None or measurement.coherence is None:
        raise NotFoundError("this measurement kept no estimates: state `estimates` when it is started")
    return {
        "n_averages": np.append(kept.n_averages, measurement.setup.analyser.simulated_averages),
        "freq": frf.freq,
        "values": np.concatenate([kept.values, frf.values[None]]),
        "coherence": np.concatenate([kept.coherence, measurement.coherence[None]]),
        "outputs": np.array([str(dof) for dof in frf.outputs]),
        "inputs": np.array([str(dof) for dof in frf.inputs]),
        "kind": np.array(frf.kind.value),
    }
