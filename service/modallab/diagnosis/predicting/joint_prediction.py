"""Several tests of one structure as if they were one: their lines one below the other."""

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import ComplexArray, FloatArray
from modallab.core.dof import Dof
from modallab.core.errors import InvalidInputError
from modallab.diagnosis.predicting.coarse_prediction import CoarsePrediction
from modallab.diagnosis.predicting.predictor import GLIMPSED, Predictor
from modallab.diagnosis.residuals.observed import Observed
from modallab.diagnosis.residuals.predicted import Predicted, SimulatedDeviations, VarianceRatios
from modallab.fe.modes import ModalBasis
from modallab.rig.chain import Chain
from modallab.rig.change import Change
from modallab.rig.effect import Effect
from modallab.rig.effects_in_other_test import effects_in_other_test
from modallab.rig.measurement import Measurement
from modallab.rig.setup import RigSetup
from modallab.rig.simulated_variance import SimulatedVariance


@dataclass(frozen=True, eq=False)
class FollowUp:
    """A further test of the same structure, and what was changed for it against the first one."""

    measurement: Measurement
    change: Change = field(default_factory=Change)

    def with_consistent_log_book(self, first: Measurement) -> Measurement:
        """Return the measurement with its log book as it must have been.

        Raises
        ------
        InvalidInputError
            If log book, change and what was measured contradict each other.
        """
        own = self.measurement
        setup = self.change.agreed(own.setup, first.setup)
        for name, said, measured in (
            ("drive", setup.drives, own.frf.inputs),
            ("responses", setup.responses, own.frf.outputs),
        ):
            if said != measured:
                raise InvalidInputError(
                    f"the further test has other {name} than its log book with what was changed",
                    field=f"follow_ups.changed.{name}",
                    value=", ".join(map(str, said)),
                    allowed=", ".join(map(str, measured)),
                )
        if setup.accelerometers.roving != first.setup.accelerometers.roving:
            raise InvalidInputError(
                "tests with a roving accelerometer and with fixed ones are not put together",
                field="follow_ups",
                value="roving" if setup.accelerometers.roving else "fixed",
                allowed="roving" if first.setup.accelerometers.roving else "fixed",
            )
        return replace(own, setup=setup)


class FollowUpPredictor(Predictor):
    """Predicts a further test: effects are named as they sit in the first one."""

    def __init__(self, first: Predictor, setup: RigSetup, observed: Observed) -> None:
        vars(self).update(vars(first))  # the same model, and whatever else the first test knows of it
        self.setup, self.observed, self._first = setup, observed, first.setup
        self._rehearsals = SimulatedVariance()
        self.step = max(1, setup.analyser.n_lines // GLIMPSED)

    def _here(self, effects: Sequence[Effect]) -> list[Effect]:
        return effects_in_other_test(effects, self._first, self.setup)

    def chain(
        self,
        effects: Sequence[Effect],
        *,
        same_in_all_runs: bool = False,
        initial_rms: FloatArray | None = None,
    ) -> Chain:
        """Return the measuring chain, see `Predictor.chain`."""
        return super().chain(self._here(effects), same_in_all_runs=same_in_all_runs, initial_rms=initial_rms)

    def with_frequency_shift(self, effects: Sequence[Effect], shift: float) -> Predicted:
        """Return the expected spectra of other natural frequencies, see `Predictor.with_frequency_shift`."""
        return super().with_frequency_shift(self._here(effects), shift)


class JointPredictor(Predictor):
    """Predicts several tests at once; what is asked of one alone is answered by the first.

    All have the same outputs, and where one of them did not measure, nothing is usable.
    """

    def __init__(self, tests: Sequence[Predictor]) -> None:
        first = tests[0]
        vars(self).update(vars(first))
        self._tests = tuple(tests)
        self._outputs = tuple(dict.fromkeys(dof for test in tests for dof in test.observed.outputs))
        self.observed = self._seen([test.observed for test in tests])

    @property
    def tests(self) -> tuple[Predictor, ...]:
        """The predictors of the single tests."""
        return self._tests

    def with_nuisances_at(self, position: FloatArray) -> "JointPredictor":
        """Return the same with what may differ a little so many standard deviations (n,) off."""
        other = copy(self)
        other.position = position
        other._tests = tuple(test.with_nuisances_at(position) for test in self._tests)
        return other

    def folded_into_matrices(self, effects: Sequence[Effect]) -> "JointPredictor":
        """Return the same with effects in the structure's matrices, see `Predictor.folded_into_matrices`."""
        other = copy(self)
        other._tests = tuple(test.folded_into_matrices(effects) for test in self._tests)
        return other

    def predict(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra of all tests."""
        return self.stacked([test.predict(effects) for test in self._tests])

    def linearisation_at(self, effects: Sequence[Effect]) -> Callable[[Sequence[Effect]], Predicted]:
        """Return predictions to differentiate with, see `Predictor.linearisation_at`."""
        sketches = [test.linearisation_at(effects) for test in self._tests]
        return lambda near: self.stacked([sketch(near) for sketch in sketches])

    def with_frequency_shift(self, effects: Sequence[Effect], shift: float) -> Predicted:
        """Return the expected spectra with every natural frequency moved by a small share of itself."""
        return self.stacked([test.with_frequency_shift(effects, shift) for test in self._tests])

    def coarse(self, effects: Sequence[Effect]) -> Predicted:
        """Return a first look at all tests."""
        return self.stacked([test.coarse(effects) for test in self._tests])

    def with_intermittent_errors(self, effects: Sequence[Effect]) -> "Predictor":
        """Return the same with errors as large as bursts make them, see `Predictor`."""
        return JointPredictor([test.with_intermittent_errors(effects) for test in self._tests])

    def simulate_variance(self, effects: Sequence[Effect]) -> VarianceRatios | None:
        """Return what all tests are like, see `Predictor.simulate_variance`; None if one has no bursts."""
        each = [found for test in self._tests if (found := test.simulate_variance(effects)) is not None]
        return self._factors(each) if len(each) == len(self._tests) else None

    def without_lines(self, every: int) -> "Predictor":
        """Return the same with one of so many lines of each test held out of its fits as well."""
        return JointPredictor([test.without_lines(every) for test in self._tests])

    def coarse_prediction(self, effects: Sequence[Effect]) -> CoarsePrediction:
        """Return first looks at what is added to some effects."""
        return _JointGlimpses(self, effects)

    def modes(self) -> ModalBasis:
        """Return the elastic modes of the first test."""
        return self._tests[0].modes()

    def unmeasured_inertance(self, effects: Sequence[Effect], dofs: tuple[Dof, ...]) -> ComplexArray:
        """Return the inertance at DoFs where nothing was measured, in the first test."""
        return self._tests[0].unmeasured_inertance(effects, dofs)

    def stack_channels(self, parts: Sequence[NDArray[Any]], absent: complex) -> NDArray[Any]:
        """Return (.., n_freq of all, n_outputs of all), see `Predictor.stack_channels`."""
        whole = []
        for test, part in zip(self._tests, parts, strict=True):
            own = [self._outputs.index(dof) for dof in test.observed.outputs]
            padded = np.full((*part.shape[:-1], len(self._outputs)), absent, part.dtype)
            padded[..., own] = part
            whole.append(padded)
        return np.concatenate(whole, axis=-2)

    def _of_runs(self, parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Return the same of what every run has once: a roving sensor's runs are its outputs."""
        if self.setup.accelerometers.roving:
            return self.stack_channels(parts, 1.0)
        return np.concatenate(parts, axis=-2)

    def stacked(self, parts: Sequence[Predicted]) -> Predicted:
        """Return the predictions of all tests, one below the other."""
        return Predicted(
            h=self.stack_channels([part.h for part in parts], 1.0),
            coherence=self.stack_channels([part.coherence for part in parts], 1.0),
            force=self._of_runs([part.force for part in parts]),
            incoherent=self.stack_channels([part.incoherent for part in parts], 1.0),
            excess_variance=partial(self._excess, parts)
            if any(part.excess_variance for part in parts)
            else None,
            variance_ratios=partial(self._steady, parts)
            if any(part.variance_ratios for part in parts)
            else None,
            lines_correlated=any(part.lines_correlated for part in parts),
        )

    def _excess(self, parts: Sequence[Predicted]) -> FloatArray:
        each = [
            np.ones(part.incoherent.shape) if part.excess_variance is None else part.excess_variance()
            for part in parts
        ]
        return self.stack_channels(each, 1.0)

    def _steady(self, parts: Sequence[Predicted]) -> VarianceRatios:
        return self._factors(
            [_anew(part) if part.variance_ratios is None else part.variance_ratios() for part in parts]
        )

    def _factors(self, each: Sequence[VarianceRatios]) -> VarianceRatios:
        # They multiply the variance of as many averages as `observed` says, the fewest of all tests.
        shares = [self.observed.averages / test.observed.averages for test in self._tests]
        return VarianceRatios(
            self._of_runs([one.force * share for one, share in zip(each, shares, strict=True)]),
            self.stack_channels([one.frf for one in each], 1.0),
            self.stack_channels([one.response for one in each], 1.0),
            self._together([one.deviations for one in each]),
        )

    def _together(self, each: Sequence[SimulatedDeviations | None]) -> SimulatedDeviations | None:
        """Return what tests lie off, those of each further one another draw: one seed drew them all."""
        drawn = [
            [np.roll(part, i, axis=0) for part in tests] for i, tests in enumerate(each) if tests is not None
        ]
        if len(drawn) < len(each):
            return None
        force, frf, response = zip(*drawn, strict=True)
        return self._of_runs(force), self.stack_channels(frf, 0.0), self.stack_channels(response, 0.0)

    def _seen(self, parts: Sequence[Observed]) -> Observed:
        """Return the measurements of all tests, one below the other."""
        held = {dof.point for part in parts for dof in np.array(part.outputs, object)[part.held_out]}
        return Observed(
            freq=np.concatenate([part.freq for part in parts]),
            outputs=self._outputs,
            held_out=np.array([dof.point in held for dof in self._outputs]),
            held_out_lines=np.concatenate([part.held_out_lines for part in parts]),
            correlation_length=max(part.correlation_length for part in parts),
            averages=min(part.averages for part in parts),
            variance_floor=max(part.variance_floor for part in parts),
            **self._spectra(parts),
        )

    def _spectra(self, parts: Sequence[Observed]) -> Mapping[str, Any]:
        """Return what a test has by line and output; of auto spectra those that all tests have."""
        every: dict[str, Any] = {
            "h": self.stack_channels([part.h for part in parts], 1.0),
            "error": self.stack_channels([part.error for part in parts], 1.0),
            "bias": self.stack_channels([np.broadcast_to(part.bias, part.h.shape) for part in parts], 0.0),
            "coherence": self.stack_channels([part.coherence for part in parts], 0.0),
            "usable": self.stack_channels([part.usable for part in parts], False),
            "shared_noise": self.stack_channels([_in_common(part) for part in parts], 0.0),
            "force": None,
            "force_variance": 1.0,
            "incoherent": None,
            "incoherent_variance": None,
        }
        force = [part.force for part in parts if part.force is not None]
        if len(force) == len(parts):
            every["force"] = self._of_runs(force)
            each = [
                np.broadcast_to(part.force_variance, one.shape)
                for part, one in zip(parts, force, strict=True)
            ]
            every["force_variance"] = self._of_runs(each)
        for name in ("incoherent", "incoherent_variance"):
            known = [one for part in parts if (one := getattr(part, name)) is not None]
            every[name] = self.stack_channels(known, 1.0) if len(known) == len(parts) else None
        return every


def _in_common(part: Observed) -> FloatArray:
    return np.zeros(part.h.shape) if part.shared_noise is None else part.shared_noise


def _anew(part: Predicted) -> VarianceRatios:
    """Return the factors of records that are drawn anew."""
    nothing = np.ones(part.h.shape)
    return VarianceRatios(np.ones(part.force.shape), nothing, nothing)


class _JointGlimpses(CoarsePrediction):
    """First looks at several tests."""

    def __init__(self, predictor: JointPredictor, base: Sequence[Effect]) -> None:
        self.predictor: JointPredictor = predictor
        self.base = base
        self._each = [test.coarse_prediction(base) for test in predictor.tests]
        self.observed = predictor._seen([one.observed for one in self._each])

    def predict(self, effects: Sequence[Effect]) -> Predicted:
        """Return the expected spectra of all tests at every few lines with all these effects."""
        return self.predictor.stacked([one.predict(effects) for one in self._each])
