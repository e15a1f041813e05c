"""Places of an unknown cause: every DoF, every channel, and the drive."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import ComplexArray, IntArray
from modallab.core.dof import Dof
from modallab.core.place import Channels, Place
from modallab.diagnosis.predicting.single_test_predictor import SingleTestPredictor
from modallab.diagnosis.result import UnknownCause
from modallab.diagnosis.searching.run_receptances import RunReceptances
from modallab.diagnosis.unknown.line_by_line import Influence
from modallab.rig.effect import Effect
from modallab.rig.frf_channel import FrfChannel


@dataclass(frozen=True)
class UnknownPlace:
    """Where an unknown cause may act, and as what."""

    cause: UnknownCause
    """Force on the structure, gain of one channel, or gain of all."""
    at: Place
    """DoF of the force, or channel; None: all channels."""


class Influences:
    """Influence on the FRFs of a cause at any place, from the receptances of the runs.

    Parameters
    ----------
    accepted
        Effects that act in every prediction.
    lines
        (n_freq,) indices of the lines from 0 Hz on.
    """

    def __init__(self, predictor: SingleTestPredictor, accepted: Sequence[Effect], lines: IntArray) -> None:
        self._system = predictor.system
        self._channels: tuple[FrfChannel, ...] = predictor.observed.channels
        self._runs = RunReceptances(predictor, accepted, lines)
        self._n_lines = len(lines)

    @property
    def places(self) -> Iterator[UnknownPlace]:
        """Every DoF, every channel, and the drive."""
        for dof in self._system.dofs:
            yield UnknownPlace(UnknownCause.INTERNAL_FORCE, dof)
        for point in dict.fromkeys(channel.response.point for channel in self._channels):
            yield UnknownPlace(UnknownCause.CHANNEL_GAIN, Channels((point,)))
        yield UnknownPlace(UnknownCause.COMMON_GAIN, None)

    def of(self, place: UnknownPlace) -> Influence:
        """Return the influence of a cause at a place: of a force, by the motion of its own DoF."""
        return self.driven_by(place, place.at if isinstance(place.at, Dof) else None)

    def sources(self, at: Place) -> list[Dof | None]:
        """Return the DoFs whose motion may drive a cause, its own first; None alone for a gain."""
        if not isinstance(at, Dof):
            return [None]
        alike = [dof for dof in self._system.dofs if dof.translational == at.translational and dof != at]
        return [at, *alike]

    def driven_by(self, place: UnknownPlace, source: Dof | None) -> Influence:
        """Return the influence of a force at a place that the motion of some DoF drives, or of a gain.

        A force -z u_y at x has the coupling alpha_ox alpha_yd / alpha_od and the own receptance alpha_yx.
        """
        if isinstance(place.at, Dof) and source is not None:
            both = np.hstack([self._system.selection((place.at,)), self._system.selection((source,))])
            to_outputs, within, from_drive = self._runs.receptances(both)
            coupling = to_outputs[..., 0] * from_drive[..., 1, :] / self._runs.direct
            own = np.broadcast_to(within[..., 1, :1], coupling.shape)
            return Influence(self._by_frf(coupling), self._by_frf(own))
        points = place.at.points if isinstance(place.at, Channels) else None
        acts = [points is None or channel.response.point in points for channel in self._channels]
        coupling = np.tile(-np.array(acts, complex), (self._n_lines, 1))
        return Influence(coupling, np.zeros_like(coupling))

    def _by_frf(self, by_force: ComplexArray) -> ComplexArray:
        return np.moveaxis(by_force, 0, 1).reshape(self._n_lines, -1)
