"""Places and sizes of what is hidden, drawn to show beyond the errors of an ordinary model.

Sizes of what is attached follow from the structure: of masses its mass, of springs the stiffness that its
mass has at half the largest frequency.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from benchmarks.laboratory import effects
from benchmarks.laboratory.bars import Bars, Reals
from benchmarks.laboratory.effects import Effect
from benchmarks.laboratory.plan import Plan


@dataclass(frozen=True)
class Draw:
    """A model and a log book, and random numbers."""

    bars: Bars
    plan: Plan
    rng: np.random.Generator

    def between(self, low: float, high: float) -> float:
        """Return a number between two, log-uniform."""
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def either(self, low: tuple[float, float], high: tuple[float, float]) -> float:
        """Return a number from one of two ranges."""
        return self.between(*(low, high)[int(self.rng.integers(2))])

    def frequency(self, low: float, high: float) -> float:
        """Return a frequency, Hz, between two shares of the band."""
        return float(self.plan.frequency_max * self.rng.uniform(low, high))

    @property
    def node(self) -> int:
        """A node that is free."""
        return int(self.rng.choice([n for n in range(len(self.bars.points)) if n not in self.bars.clamped]))

    @property
    def response(self) -> int:
        """A response."""
        return int(self.rng.integers(len(self.plan.listening)))

    @property
    def inner_bar(self) -> int:
        """A bar that starts at the end of another."""
        return int(self.rng.integers(1, len(self.bars.ends)))

    @cached_property
    def lengths(self) -> Reals:
        """(n_bars,), m."""
        ends = self.bars.points[self.bars.ends]
        return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))

    @property
    def weight(self) -> float:
        """Mass of the structure, kg."""
        return float((self.bars.density * self.bars.area * self.lengths).sum())

    @property
    def omega(self) -> float:
        """Half the largest frequency, rad/s."""
        return float(np.pi * self.plan.frequency_max)

    def bending(self, length: float) -> float:
        """Return the rotational stiffness, N m/rad, of a bar of a length, m."""
        return float(self.bars.modulus[0] * self.bars.second_moment / length)

    def misplaced(self) -> Effect:
        """Return an accelerometer on one of the nearest nodes that nobody measures."""
        response = self.response
        place = self.bars.points[self.plan.listening[response]]
        free = set(range(len(self.bars.points))) - {*self.bars.clamped, *self.plan.listening}
        near = sorted(free, key=lambda node: float(np.linalg.norm(self.bars.points[node] - place)))
        return effects.Misplaced(0.0, response, other=near[int(self.rng.integers(2))])

    def swapped(self) -> Effect:
        """Return two responses whose accelerometers are exchanged."""
        one, other = (int(i) for i in self.rng.choice(len(self.plan.listening), 2, replace=False))
        return effects.Swapped(0.0, one, other=other)


HIDDEN: dict[str, Callable[[Draw], Effect]] = {
    "extra_mass": lambda d: effects.ExtraMass(d.weight * d.between(0.02, 0.15), d.node),
    "ground_spring": lambda d: effects.GroundSpring(d.weight * d.omega**2 * d.between(0.002, 0.1), d.node),
    "rotational_ground_spring": lambda d: effects.RotationalGroundSpring(
        d.bending(d.lengths.sum()) * d.between(3.0, 100.0), d.node
    ),
    "local_damping": lambda d: effects.LocalDamping(d.weight * d.omega * d.between(0.003, 0.03), d.node),
    "attached_oscillator": lambda d: effects.Oscillator(
        d.weight * d.between(0.01, 0.05), d.node, d.frequency(0.15, 0.8), d.between(0.01, 0.05)
    ),
    "fractional_damper": lambda d: effects.FractionalDamper(
        d.weight * d.omega**1.5 * d.between(0.01, 0.05), d.node
    ),
    "stiffness_error": lambda d: effects.StiffnessError(
        d.either((0.3, 0.7), (1.5, 3.0)), int(d.rng.integers(len(d.bars.ends)))
    ),
    "joint_flexibility": lambda d: effects.JointFlexibility(
        d.between(0.5, 4.0) / d.bending(float(d.lengths.mean())), d.inner_bar
    ),
    "loss_factor_error": lambda d: effects.LossFactor(d.either((0.3, 0.5), (2.0, 4.0))),
    "accelerometer_mass": lambda d: effects.AccelerometerMass(d.weight * d.between(0.005, 0.03)),
    "force_transducer_mass": lambda d: effects.TransducerMass(d.weight * d.between(0.02, 0.1)),
    "stinger_axial": lambda d: effects.Stinger(0.0, frequency=d.frequency(0.2, 0.8), loss=0.02),
    "gain_error": lambda d: effects.Gain(d.either((0.7, 0.9), (1.1, 1.4)), d.response),
    "polarity": lambda d: effects.Polarity(-1.0, d.response),
    "gain_bump": lambda d: effects.GainBump(d.between(0.2, 0.8), d.response, d.frequency(0.3, 0.7)),
    "channel_delay": lambda d: effects.Delay(d.between(0.02, 0.1) / d.plan.frequency_max),
    "ac_coupling": lambda d: effects.HighPass(d.plan.frequency_max * d.between(0.01, 0.05)),
    "mains_hum": lambda d: effects.Hum(d.between(0.05, 0.3)),
    "misplaced_accelerometer": Draw.misplaced,
    "swapped_channels": Draw.swapped,
}


def hide(name: str, plan: Plan, bars: Bars, rng: np.random.Generator) -> Effect:
    """Return an effect by its name, place and size drawn."""
    return HIDDEN[name](Draw(bars, plan, rng))
