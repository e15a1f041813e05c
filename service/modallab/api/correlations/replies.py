"""Replies of correlations."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.api.replies import stored_reply
from modallab.core.dof import Dof
from modallab.correlation.compare import Correlation
from modallab.store.base import Entry

CorrelationReply = stored_reply(Correlation, "Correlation")


def correlation_reply(correlation: Correlation, entry: Entry) -> Any:
    """Return the reply of a stored correlation."""
    return CorrelationReply.of(correlation, entry)


def correlation_arrays(correlation: Correlation) -> Mapping[str, NDArray[Any]]:
    """Return the matrices of a correlation by the names of `/arrays`, the FDAC and its lines with them."""
    orthogonality, responses = correlation.orthogonality, correlation.responses
    arrays: dict[str, NDArray[Any] | None] = {
        "mac": correlation.mac,
        "pairs": np.array(correlation.pairs, dtype=int).reshape(-1, 2),
        "frequency_differences": correlation.frequency_differences,
        "comac": correlation.comac,
        "dofs": _names(correlation.dofs),
        "ecomac": correlation.ecomac,
        "pole_weighted_mac": correlation.pole_weighted_mac,
    }
    if orthogonality is not None:
        arrays |= {"cross_orthogonality": orthogonality.cross, "auto_orthogonality": orthogonality.auto}
    if responses is not None:
        arrays |= {"outputs": _names(responses.outputs), "inputs": _names(responses.inputs)}
        arrays |= {"frac": responses.frac, "fdac_freq": responses.freq, "fdac": responses.fdac}
    return {name: array for name, array in arrays.items() if array is not None}


def _names(dofs: tuple[Dof, ...]) -> NDArray[Any]:
    return np.array([str(dof) for dof in dofs])
