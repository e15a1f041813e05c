"""Replies of studies."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.api.replies import replies_of, stored_reply, wire_type
from modallab.store.base import Entry
from modallab.updating.studies.study import Study, StudyCell

StudyReply = stored_reply(
    Study,
    "Study",
    wrong=(wire_type(Mapping[str, Mapping[int, float]]), "True coefficients that differ from nominal."),
    cells=(replies_of(StudyCell), "Statistics by level, then division."),
)


def study_reply(study: Study, entry: Entry) -> Any:
    """Return the reply of a stored study."""
    return StudyReply.of(study, entry)


def study_arrays(study: Study) -> dict[str, NDArray[Any]]:
    """Return the coefficients of all runs by the names of `/arrays`.

    `coefficients` (n_runs, n_coefficients), NaN in the rows of failed runs; part, member and true value of
    each column; level, division and seed of each row.
    """
    coefficients = np.full((len(study.runs), study.coefficients.shape[1]), np.nan)
    coefficients[[run.succeeded for run in study.runs]] = study.coefficients
    keys = [(part, number, value) for part, table in study.true.items() for number, value in table.items()]
    parts, members, true = zip(*keys, strict=True)
    return {
        "coefficients": coefficients,
        "parts": np.array(parts),
        "members": np.array(members),
        "true": np.array(true),
        "levels": np.array([run.level for run in study.runs]),
        "divisions": np.array([run.division for run in study.runs]),
        "seeds": np.array([run.seed for run in study.runs]),
    }
