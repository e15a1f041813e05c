"""Mistakes in a log book, each by a believable factor, and the effect that amounts to it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from modallab.core.dof import Dof
from modallab.rig.effect import EFFECTS, Effect
from modallab.rig.hardware import Noise
from modallab.rig.setup import RigSetup

Misled = tuple[RigSetup, tuple[Effect, ...]]  # the rig as it was, and what makes up for the mistake


def _factor(rng: np.random.Generator, low: float = 1.2, high: float = 3.0) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _effect(kind: str, at: Dof | None = None, **values: float) -> Effect:
    return EFFECTS[kind](at=at).with_parameters(values)


def _heavier(setup: RigSetup, rng: np.random.Generator) -> Misled:
    declared = setup.accelerometers.mass
    mass = declared * _factor(rng)
    actual = replace(setup, accelerometers=replace(setup.accelerometers, mass=mass))
    return actual, (_effect("accelerometer_mass", mass=mass - declared),)


def _armature(setup: RigSetup, rng: np.random.Generator) -> Misled:
    declared = setup.exciter.armature_mass
    mass = declared * _factor(rng)
    return replace(setup, exciter=replace(setup.exciter, armature_mass=mass)), (
        _effect("exciter_armature", mass=mass - declared),
    )


def _transducer(setup: RigSetup, rng: np.random.Generator) -> Misled:
    declared = setup.force_transducer.mass_below
    mass = declared * _factor(rng)
    return replace(setup, force_transducer=replace(setup.force_transducer, mass_below=mass)), (
        _effect("force_transducer_mass", mass=mass - declared),
    )


def _noisier(setup: RigSetup, rng: np.random.Generator) -> Misled:
    ratio = setup.noise.response_ratio * _factor(rng, 1.5, 30.0)
    mistake = _effect("response_noise", ratio=ratio - setup.noise.response_ratio)
    return replace(setup, noise=Noise(setup.noise.force_ratio, ratio)), (mistake,)


def _noisier_force(setup: RigSetup, rng: np.random.Generator) -> Misled:
    ratio = setup.noise.force_ratio * _factor(rng, 1.5, 30.0)
    mistake = _effect("force_noise", ratio=ratio - setup.noise.force_ratio)
    return replace(setup, noise=Noise(ratio, setup.noise.response_ratio)), (mistake,)


def _mounting(setup: RigSetup, rng: np.random.Generator) -> Misled:
    frequency = _factor(rng, 1.5e3, 1e4)
    actual = replace(setup, accelerometers=replace(setup.accelerometers, mounted_frequency=frequency))
    mounting = actual.accelerometers.effective_mounting
    assert mounting is not None
    return actual, (_effect("mounted_resonance", frequency=mounting.frequency, loss=mounting.loss),)


def _drive(setup: RigSetup, _: np.random.Generator) -> Misled:
    """Return the rig driven one node further than written down: no effect amounts to that."""
    return replace(setup, drives=(Dof(setup.drive.node + 1, setup.drive.direction),)), ()


def _window(setup: RigSetup, _: np.random.Generator) -> Misled:
    """Return the rig with another window than written down: no effect amounts to that."""
    window = "flat_top" if setup.analyser.window == "hann" else "hann"
    return replace(setup, analyser=replace(setup.analyser, window=window)), ()


MISTAKES: dict[str, Callable[[RigSetup, np.random.Generator], Misled]] = {
    "accelerometer": _heavier,
    "armature": _armature,
    "transducer": _transducer,
    "response_noise": _noisier,
    "force_noise": _noisier_force,
    "mounting": _mounting,
    "drive": _drive,
    "window": _window,
}
