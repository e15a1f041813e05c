"""Effects of the laboratory: what each does to the structure, the transducers and the signals."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from benchmarks.laboratory.bars import Attachment, Bars, Complexes, Reals, Y
from benchmarks.laboratory.plan import Run


@dataclass(frozen=True)
class Effect:
    """An effect that acts; `at` is a node, a bar or a response, by its kind."""

    size: float
    at: int = -1
    frequency: float = 0.0
    """Hz."""
    loss: float = 0.0
    other: int = -1
    kind: ClassVar[str]
    place: ClassVar[str] = ""
    """Name of what `at` counts: node, bar, response; empty: the effect has no place."""

    def altered(self, bars: Bars) -> Bars:
        """Return the bars with the effect."""
        return bars

    def attachments(self, bars: Bars, run: Run) -> list[Attachment]:
        """Return what is attached in a run."""
        return []

    def true_runs(self, runs: Sequence[Run]) -> list[Run]:
        """Return the runs as they really are."""
        return list(runs)

    def stinger_flexibility(self, omega: Reals, armature_mass: float) -> Complexes | float:
        """Return the flexibility (n_freq,), m/N, between armature and structure."""
        return 0.0

    def filter(self, response: int, omega: Reals | Complexes) -> Complexes | float:
        """Return by what a response's spectrum is multiplied, (n_freq,)."""
        return 1.0

    def hum(self, n_samples: int, step: float, rms: float, rng: np.random.Generator) -> Reals | float:
        """Return a signal (n_samples,) added to a response."""
        return 0.0


def translations(bars: Bars, node: int, mass: float) -> list[Attachment]:
    """Return a mass, kg, that moves with both translations of a node."""
    return [(bars.column(node, axis), lambda omega: -mass * omega**2 + 0j) for axis in (0, 1)]


class ExtraMass(Effect):
    """A mass, kg, at a node."""

    kind, place = "extra_mass", "node"

    def attachments(self, bars: Bars, run: Run) -> list[Attachment]:
        """See `Effect.attachments`."""
        return translations(bars, self.at, self.size)


class GroundSpring(Effect):
    """A spring, N/m, from a node to the ground, along Y."""

    kind, place = "ground_spring", "node"

    def attachments(self, bars: Bars, run: Run) -> list[Attachment]:
        """See `Effect.attachments`."""
        return [(bars.column(self.at, Y), lambda omega: self.size + 0j * omega)]


class RotationalGroundSpring(Effect):
    """A spring, N m/rad, from a node's rotation to the ground."""

    kind, place = "rotational_ground_spring", "node"

    def attachments(self, bars: Bars, run: Run) -> list[Attachment]:
        """See `Effect.attachments`."""
        return [(bars.column(self.at, 2), lambda omega: self.size + 0j * omega)]


class LocalDamping(Effect):
    """A damper, N s/m, from a node to the ground, along Y."""

    kind, place = "local_damping", "node"

    def attachments(self, bars: Bars, run: Run) -> list[Attachment]:
        """See `Effect.attachments`."""
        return [(bars.column(self.at, Y), lambda omega: 1j * omega * self.size)]


class Oscillator(Effect):
    """A mass, kg, on a spring with loss, at a node, along Y."""

    kind, place = "attached_oscillator", "node"

    def attachments(self, bars: Bars, run: Run) -> list[Attachment]:
        """See `Effect.attachments`."""
        spring = self.size * (2 * np.pi * self.frequency) ** 2 * (1 + 1j * self.loss)
        return [
            (
                bars.column(self.at, Y),
                lambda w: -(w**2) * self.size * spring / (spring - w**2 * self.size),
            )
        ]


class FractionalDamper(Effect):
    """A force from a node to the ground in proportion to the half derivative of its displacement."""

    kind, place = "", "node"

    def attachments(self, bars: Bars, run: Run) -> list[Attachment]:
        """See `Effect.attachments`."""
        return [(bars.column(self.at, Y), lambda omega: self.size * (1j * omega) ** 0.5)]


class StiffnessError(Effect):
    """A bar's modulus, over its value in the model."""

    kind, place = "stiffness_error", "bar"

    def altered(self, bars: Bars) -> Bars:
        """See `Effect.altered`."""
        modulus = bars.modulus.copy()
        modulus[self.at] *= self.size
        return replace(bars, modulus=modulus)


class JointFlexibility(Effect):
    """A flexibility, rad/(N m), between a node and the bar that starts there."""

    kind, place = "joint_flexibility", "bar"

    def altered(self, bars: Bars) -> Bars:
        """See `Effect.altered`."""
        return replace(bars, joints={self.at: self.size})


class LossFactor(Effect):
    """The loss factor of all bars, over its value in the model."""

    kind = "loss_factor_error"

    def altered(self, bars: Bars) -> Bars:
        """See `Effect.altered`."""
        return replace(bars, loss_factor=bars.loss_factor * self.size)


class AccelerometerMass(Effect):
    """A mass, kg, of each accelerometer beyond what the log book has."""

    kind = "accelerometer_mass"

    def attachments(self, bars: Bars, run: Run) -> list[Attachment]:
        """See `Effect.attachments`."""
        return [each for node in run.true for each in translations(bars, node, self.size)]


class TransducerMass(Effect):
    """A mass, kg, between force gauge and structure."""

    kind = "force_transducer_mass"

    def attachments(self, bars: Bars, run: Run) -> list[Attachment]:
        """See `Effect.attachments`."""
        return translations(bars, run.drive, self.size)


class Stinger(Effect):
    """A stinger on which the armature resonates, `frequency` and `loss`."""

    kind = "stinger_axial"

    def stinger_flexibility(self, omega: Reals, armature_mass: float) -> Complexes | float:
        """See `Effect.stinger_flexibility`."""
        stiffness = armature_mass * (2 * np.pi * self.frequency) ** 2 * (1 + 1j * self.loss)
        return np.asarray(1 / stiffness + 0j * omega)


class Gain(Effect):
    """The sensitivity of one response, over what the log book has."""

    kind, place = "gain_error", "response"

    def filter(self, response: int, omega: Reals | Complexes) -> Complexes | float:
        """See `Effect.filter`."""
        return self.size if response == self.at else 1.0


class Polarity(Effect):
    """A response of wrong sign."""

    kind, place = "polarity", "response"

    def filter(self, response: int, omega: Reals | Complexes) -> Complexes | float:
        """See `Effect.filter`."""
        return -1.0 if response == self.at else 1.0


class GainBump(Effect):
    """A response that reads too high in a part of the band."""

    kind, place = "", "response"

    def filter(self, response: int, omega: Reals | Complexes) -> Complexes | float:
        """See `Effect.filter`."""
        off = (omega / (2 * np.pi) - self.frequency) / (0.15 * self.frequency)
        return np.asarray(1 + self.size * np.exp(-(off**2)) + 0j) if response == self.at else 1.0


class Delay(Effect):
    """All responses late, s."""

    kind = "channel_delay"

    def filter(self, response: int, omega: Reals | Complexes) -> Complexes | float:
        """See `Effect.filter`."""
        return np.asarray(np.exp(-1j * omega * self.size))


class HighPass(Effect):
    """A first-order high-pass filter, Hz, in all responses."""

    kind = "ac_coupling"

    def filter(self, response: int, omega: Reals | Complexes) -> Complexes | float:
        """See `Effect.filter`."""
        ratio = 1j * omega / (2 * np.pi * self.size)
        return np.asarray(ratio / (1 + ratio))


class Hum(Effect):
    """50 Hz and its second and third harmonic in each response, over its rms."""

    kind = "mains_hum"

    def hum(self, n_samples: int, step: float, rms: float, rng: np.random.Generator) -> Reals | float:
        """See `Effect.hum`."""
        time = step * np.arange(n_samples)
        phases = rng.uniform(0, 2 * np.pi, 3)
        waves = [
            share * np.cos(2 * np.pi * 50 * order * time + phase)
            for order, share, phase in zip((1, 2, 3), (1.0, 0.1, 0.4), phases, strict=True)
        ]
        return np.asarray(np.sqrt(2) * self.size * rms * np.sum(waves, axis=0))


def _at(run: Run, index: int, node: int) -> Run:
    return replace(run, true=tuple(node if i == index else true for i, true in enumerate(run.true)))


class Misplaced(Effect):
    """An accelerometer at another node than the log book has."""

    kind, place = "misplaced_accelerometer", "response"

    def true_runs(self, runs: Sequence[Run]) -> list[Run]:
        """See `Effect.true_runs`."""
        if len(runs[0].listening) > 1:
            return [_at(run, self.at, self.other) for run in runs]
        return [_at(run, 0, self.other) if i == self.at else run for i, run in enumerate(runs)]


class Swapped(Effect):
    """Two lines of the log book exchanged: the accelerometers of two responses are at each other's nodes."""

    kind, place = "swapped_channels", "response"

    def true_runs(self, runs: Sequence[Run]) -> list[Run]:
        """See `Effect.true_runs`."""
        a, b = self.at, self.other
        if len(runs[0].listening) > 1:
            return [_at(_at(run, a, run.true[b]), b, run.true[a]) for run in runs]
        exchanged = {a: runs[b].true[0], b: runs[a].true[0]}
        return [_at(run, 0, exchanged[i]) if i in exchanged else run for i, run in enumerate(runs)]
