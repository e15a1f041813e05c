"""Arrays of updates: matrices of direct methods, covariance, draws from the posterior."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.updating.direct.result import DirectResult
from modallab.updating.identifiability import Identifiability
from modallab.updating.posterior import PosteriorSample


def direct_arrays(result: DirectResult) -> Mapping[str, NDArray[Any]]:
    """Return updated matrices and errors (n, n) by the names of `/arrays`, with their DoFs."""
    updated = {"mass": result.mass, "stiffness": result.stiffness}
    arrays: dict[str, NDArray[Any]] = {"dofs": np.array([str(dof) for dof in result.dofs])}
    arrays |= {name: matrix for name, matrix in updated.items() if matrix is not None}
    for name, matrix in result.errors.items():
        arrays[name if name == "force_balance" else f"{name}_error"] = matrix
    return arrays


def covariance_arrays(identifiability: Identifiability) -> Mapping[str, NDArray[Any]]:
    """Return the covariance of coefficients, if known, by the names of `/covariance`."""
    arrays = {
        "coefficients": np.array([str(macro) for macro in identifiability.macros]),
        "intervals": identifiability.intervals,
        "singular_values": identifiability.singular_values,
    }
    covariance = identifiability.covariance
    return arrays if covariance is None else arrays | {"covariance": covariance}


def posterior_arrays(sample: PosteriorSample) -> Mapping[str, NDArray[Any]]:
    """Return the draws of coefficients by the names of `/sample`."""
    return {
        "coefficients": np.array([str(macro) for macro in sample.macros]),
        "draws": sample.draws,
        "log_density": sample.log_density,
    }
