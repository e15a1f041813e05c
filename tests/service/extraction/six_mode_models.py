"""Modal models of the responses of `six_modes`, each extracted once for all tests that read it."""

from functools import cache

import numpy as np

from modallab.core.dof import Dof
from modallab.core.frf import FrfKind, FrfSet
from modallab.core.modal_model import ModalModel
from modallab.extraction.extract import extract
from modallab.extraction.options import Damping, ExtractionOptions
from tests.synthetic import six_modes

AVERAGES = 1000.0
DOFS = tuple(Dof(node, "Y") for node in range(1, 13))


def six_mode_model(
    decibels: float,
    seed: int = 0,
    *,
    method: str = "lscf",
    damping: Damping | None,
    measured: bool = True,
    delay: float = 0.0,
) -> ModalModel:
    """Return the modes from 1 Hz on, with the coherence of the noise where `measured`.

    Parameters
    ----------
    damping
        Damping model; None: as the lines indicate.
    delay
        s, of all responses.
    """
    # by position: the cache takes an argument that is named for another than the same without its name
    return _extracted(decibels, seed, method, damping, measured, delay)


@cache
def _extracted(
    decibels: float, seed: int, method: str, damping: Damping | None, measured: bool, delay: float
) -> ModalModel:
    made = six_modes(decibels, seed, lower=1.0)
    noisy = made.noisy * np.exp(-2j * np.pi * made.freq[:, None] * delay)
    coherence = 1 / (1 + AVERAGES * made.variance / np.abs(made.noisy) ** 2)
    return extract(
        FrfSet(made.freq, noisy[:, :, None], DOFS, DOFS[:1], FrfKind.RECEPTANCE),
        coherence=coherence if measured else None,
        averages=AVERAGES,
        method=method,
        options=ExtractionOptions(damping=damping),
    )
