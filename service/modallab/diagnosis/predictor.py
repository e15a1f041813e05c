"""What the log book and a list of effects predict for a measurement."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import partial

import numpy as np

from modallab.core.arrays import ComplexArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.observed import Observed, Predicted
from modallab.diagnosis.residual import Residual, residual
from modallab.fe.assembly import assemble
from modallab.fe.modes import ModalBasis
from modallab.fe.structure import Structure
from modallab.rig.chain import chain
from modallab.rig.channel import Channel
from modallab.rig.effect import Effect, build
from modallab.rig.expected import expected_spectra, glimpse
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.rig.succession import excess_variance

GOLDEN = (5**0.5 - 1) / 2
GLIMPSED = 130  # lines that a first look uses


class Predictor:
    """Predicts the measurement exactly as the log book says, with some effects more."""

    def __init__(self, structure: Structure, setup: RigSetup, observed: Observed) -> None:
        self.setup, self.observed = setup, observed
        self.system = assemble(structure)
        self._own = [build(spec) for spec in structure.effects]
        self.step = max(1, setup.analyser.n_lines // GLIMPSED)

    def predict(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra."""
        whole = chain(self.system, self.setup, [*self._own, *effects])
        spectra = expected_spectra(whole)
        leaking = whole.source.continuous > 0
        return Predicted.of(spectra, partial(excess_variance, whole, spectra) if leaking else None)

    def residual(self, effects: Sequence[Effect]) -> Residual:
        """Return the whitened residual of the prediction at every line."""
        return residual(self.observed, self.predict(effects))

    def detuned(self, effects: Sequence[Effect], shift: float) -> Predicted:
        """Return the expected spectra with every natural frequency moved by a small share of itself."""
        system = self.system.scaled(stiffness=(1 + shift) ** 2)
        whole = chain(system, self.setup, [*self._own, *effects])
        return Predicted.of(expected_spectra(whole))

    def glimpse(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra at every `step`-th line, leakage coarse."""
        whole = chain(self.system, self.setup, [*self._own, *effects])
        return Predicted.of(glimpse(whole, self.step))

    def without_lines(self, every: int) -> "Predictor":
        """Return the same with one of so many lines held out of its fits as well.

        At steps of the golden section: at even steps harmonics would all be held out, or none of them.
        """
        lines = np.arange(len(self.observed.freq)) * GOLDEN % 1 < 1 / every
        other = copy(self)
        other.observed = replace(self.observed, held_lines=self.observed.held_lines | lines)
        return other

    def near(self, effects: Sequence[Effect]) -> "Glimpses":
        """Return first looks at what is added to some effects."""
        return Glimpses(self, effects)

    def modes(self) -> ModalBasis:
        """Return the elastic modes of the model with what the first run attaches to it."""
        first = chain(self.system, self.setup, self._own).runs[0].system
        top = self.setup.analyser.frequency_max
        basis = first.modes(top).elastic()
        return basis.elastic(max(1, int((basis.frequencies <= top).sum())))

    def unmeasured(self, effects: Sequence[Effect], dofs: tuple[Dof, ...]) -> ComplexArray:
        """Return the inertance (n_freq, n_dof, 1) at DoFs where nothing was measured.

        A roving accelerometer is thought to visit them; fixed ones stay where they are.
        """
        extended = [*self._own, *effects]
        freq = self.observed.freq
        if self.setup.accelerometers.roving:
            visited = chain(self.system, replace(self.setup, responses=dofs), extended)
            return np.asarray(visited.respond(freq).inertance[:, :, 0, 0].T[..., None])
        first = chain(self.system, self.setup, extended).runs[0]
        shot = replace(first.shot, outputs=dofs)
        elsewhere = replace(first, shot=shot, responses=tuple(map(Channel.ideal, dofs)))
        whole = replace(chain(self.system, self.setup), runs=(elsewhere,))
        return np.asarray(whole.respond(freq).inertance[0])


class Glimpses:
    """First looks: coarse predictions, set right by what is exact without the addition.

    What a coarse grid gets wrong about leakage is nearly the same with and without a small
    addition, and so cancels in their ratio.
    """

    def __init__(self, predictor: Predictor, base: Sequence[Effect]) -> None:
        self.predictor = predictor
        self.observed = predictor.observed.thinned(predictor.step)
        exact, coarse = predictor.predict(base), predictor.glimpse(base)
        every = slice(None, None, predictor.step)
        self._h = exact.h[every] / coarse.h
        self._force = exact.force[every] / coarse.force
        self._incoherent = exact.incoherent[every] / coarse.incoherent

    def predict(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra at every `step`-th line with all these effects."""
        coarse = self.predictor.glimpse(effects)
        return Predicted(
            coarse.h * self._h,
            coarse.coherence,
            coarse.force * self._force,
            coarse.incoherent * self._incoherent,
        )


def check_comparable(structure: Structure, measurement: Measurement) -> None:
    """Raise unless the model and the log book can predict the measurement.

    Raises
    ------
    InvalidInputError
        If the frequency axis is not the log book's, 0 Hz apart, or several forces act at once.
    UnknownDofError
        If the model lacks a measured DoF.
    """
    for dof in (measurement.setup.drive, *measurement.frf.outputs):
        structure.index(dof)
    if measurement.frf.values.shape[2] != 1:
        raise InvalidInputError("one force at a time", field="inputs", allowed="1")
    axis, freq = measurement.setup.analyser.freq, measurement.frf.freq
    if freq[0] > 0:
        axis = axis[1:]
    if len(axis) != len(freq) or not np.allclose(axis, freq, rtol=1e-6, atol=1e-6 * axis[-1]):
        raise InvalidInputError(
            "the frequency axis is not the one that the log book declares",
            field="freq",
            value=f"{len(freq)} lines to {freq[-1]:g} Hz",
            allowed=f"{len(axis)} lines to {axis[-1]:g} Hz",
        )
