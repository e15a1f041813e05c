"""The one way to a measurement, whatever the route."""

from collections.abc import Sequence
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import FrfKind, FrfSet
from modallab.core.progress import Progress, silent
from modallab.estimation.coherence import coherence
from modallab.estimation.estimator import ESTIMATORS
from modallab.estimation.spectra import CrossSpectra
from modallab.fe.assembly import assemble
from modallab.fe.structure import Structure
from modallab.rig.chain import chain
from modallab.rig.drawn import drawn_spectra
from modallab.rig.effect import Effect, build
from modallab.rig.expected import expected_spectra
from modallab.rig.measurement import Measurement
from modallab.rig.sampled import sampled_spectra
from modallab.rig.setup import RigSetup


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
) -> Measurement:
    """Return what the rig measures on a structure.

    Parameters
    ----------
    effects
        What acts beside the declared hardware; it does not show in the measurement's log book.
    rng
        The only source of randomness; not drawn from on the expected route.

    Raises
    ------
    UnknownDofError
        If the rig drives or listens where the structure has no DoF.
    InvalidInputError
        If an effect, declared or not, cannot sit where it is said to.
    """
    own = [build(spec) for spec in structure.effects]
    for effect in [*own, *(build(spec) for spec in setup.effects), *effects]:
        effect.check(structure, setup)
    whole = chain(assemble(structure), setup, [*own, *effects])
    if route is Route.SAMPLED:
        spectra = sampled_spectra(whole, rng, progress)
    else:
        spectra = expected_spectra(whole)
        if route is Route.DRAWN:
            spectra = drawn_spectra(spectra, rng)
    progress(1.0, "measured")
    return measurement_of(spectra, setup)


def measurement_of(spectra: CrossSpectra, setup: RigSetup) -> Measurement:
    """Return FRFs, coherence and auto spectra from the averaged spectra of all runs."""
    h = ESTIMATORS[setup.analyser.estimator](spectra)  # (n_run, n_freq, n_out, 1)
    n_run, n_freq, n_out, n_in = h.shape

    def by_line(values: NDArray[Any]) -> NDArray[Any]:
        return values.swapaxes(0, 1).reshape(n_freq, n_run * n_out)

    force = np.broadcast_to(spectra.ff[:, :, 0].real, (n_run, n_freq, n_out))
    return Measurement(
        frf=FrfSet(
            spectra.freq,
            by_line(h[..., 0])[:, :, None],
            setup.responses,
            (setup.drive,) * n_in,
            FrfKind.INERTANCE,
        ),
        coherence=by_line(coherence(spectra)),
        averages=spectra.averages,
        setup=setup,
        force_spectrum=by_line(force)[:, :, None],
        response_spectrum=by_line(spectra.xx),
    )
