"""An effect hidden in a second test of the beam, and its diagnosis."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from modallab_client import ModalLab, results
from modallab_client.demo.chapter_5 import Say
from modallab_client.methods.diagnoses import place
from modallab_client.results import Measurement

Place = str | dict[str, list[int]] | None


@dataclass(frozen=True)
class Suspect:
    """Kind of effect that may be hidden: its parameter, and the range of a log-uniform draw."""

    parameter: str
    unit: str
    lower: float
    upper: float
    location: str = "everywhere"  # or member, node


SUSPECTS: Mapping[str, Suspect] = {
    "accelerometer_mass": Suspect("mass", "kg", 0.003, 0.015),
    "density_error": Suspect("factor", "", 1.05, 1.4, "member"),
    "exciter_armature": Suspect("mass", "kg", 0.005, 0.05),
    "extra_mass": Suspect("mass", "kg", 0.01, 0.1, "node"),
    "force_noise": Suspect("ratio", "", 3e-3, 3e-2),
    "force_transducer_mass": Suspect("mass", "kg", 0.003, 0.02),
    "leakage": Suspect("share", "", 0.02, 0.2),
    "response_noise": Suspect("ratio", "", 1e-5, 1e-3),
    "stiffness_error": Suspect("factor", "", 1.05, 1.4, "member"),
}


@dataclass(frozen=True)
class Hidden:
    """The truth that the diagnosis is not told."""

    kind: str
    at: Place
    parameter: str
    value: float
    unit: str

    @property
    def effect(self) -> dict[str, Any]:
        """The effect as the service takes it."""
        return {"kind": self.kind, "at": self.at, "parameters": {self.parameter: self.value}}

    def __str__(self) -> str:
        size = f"{self.parameter} {self.value:.4g} {self.unit}".strip()
        return f"{described(self.kind, self.at)}, {size}"


@dataclass(frozen=True, eq=False)
class Case:
    """The second test and its diagnosis."""

    hidden: Hidden
    test: Measurement
    diagnosis: results.Diagnosis
    report: str


def described(kind: str, at: str | Mapping[str, Any] | None) -> str:
    """Return kind and place of an effect in words."""
    name = kind.replace("_", " ")
    return name if at is None else f"{name} at {place(at).replace('member', 'element')}"


def sized(effect: results.FittedEffect) -> str:
    """Return a fitted effect in words: its place, and its parameters with standard errors."""
    numbers = [f"{name} {size}" for name, size in effect.parameters.items()]
    return ", ".join([described(effect.kind, effect.at), *numbers])


def share(step: results.Step) -> str:
    """Return the probability of a step in words, `> 0.999` at most."""
    if step.probability is None:
        return ""
    return "> 0.999" if step.probability > 0.999 else f"{step.probability:.3f}"


def closed(step: results.Step) -> tuple[str, str]:
    """Return the gap before and after a step: over the FRFs that were fitted, and over those held out."""
    held_out = (step.held_out_gap_before, step.held_out_gap_after)
    pairs = ((step.gap_before, step.gap_after), held_out)
    fitted, held_out_text = (
        "" if gap_before is None or gap_after is None else f"{gap_before:.4g} → {gap_after:.3g}"
        for gap_before, gap_after in pairs
    )
    return fitted, held_out_text


def draw(seed: int, kind: str | None = None) -> Hidden:
    """Return an effect of a random kind, place and size; the same seed gives the same.

    Parameters
    ----------
    kind
        A kind to hide instead of a random one.
    """
    rng = np.random.default_rng([seed, 5])  # 5: not the numbers that the tests' noise is drawn from
    random_kind = str(rng.choice(sorted(SUSPECTS)))
    name = random_kind if kind is None else kind
    suspect = SUSPECTS[name]
    value = float(np.exp(rng.uniform(np.log(suspect.lower), np.log(suspect.upper))))
    if suspect.parameter == "factor" and rng.random() < 0.5:
        value = 1 / value
    member, node = int(rng.integers(1, 21)), int(rng.integers(1, 22))
    places: dict[str, Place] = {"member": {"members": [member]}, "node": f"{node}:+Y", "everywhere": None}
    return Hidden(name, places[suspect.location], suspect.parameter, value, suspect.unit)


def run(lab: ModalLab, model_id: str, rig_id: str, hidden: Hidden, *, seed: int, say: Say) -> Case:
    """Return a test of the model with the effect hidden in it, and the diagnosis of that test."""
    say("measuring the beam again, now with one effect hidden that neither model nor log book has")
    job = lab.measurements.start(model_id, rig_id, effects=[hidden.effect], seed=seed + 1)
    test = job.result()
    say("diagnosing: every suspect at every place")
    diagnosis_job = lab.diagnoses.start(model_id, test.id, seed=seed, act=True)
    result = diagnosis_job.result(on_progress=_milestones(say))
    return Case(hidden, test, result, lab.diagnoses.report(result.id))


def _milestones(say: Say) -> Callable[[float, str], None]:
    """Return a callback that says a quarter of the way once."""
    quarters = [0]

    def report(fraction: float, message: str) -> None:
        if int(4 * fraction) > quarters[0]:
            quarters[0] = int(4 * fraction)
            say(f"  {fraction:4.0%} {message}")

    return report


def compared(hidden: Hidden, diagnosis: results.Diagnosis) -> str:
    """Return the error of the fitted size in words; an empty text if the effect was not named."""
    for step in diagnosis.steps:
        parameter = step.effect.parameters.get(hidden.parameter)
        if (step.effect.kind, step.effect.at) != (hidden.kind, hidden.at) or parameter is None:
            continue
        if parameter.value is None:
            return f"Its {hidden.parameter} needs a level."
        error = parameter.value - hidden.value
        share = f"{100 * abs(error) / abs(hidden.value):.2g} % off the hidden {hidden.value:.5g}"
        if not parameter.standard_error:
            return f"Its {hidden.parameter} is {share}."
        errors = f"{abs(error) / parameter.standard_error:.1f} standard errors"
        return f"Its {hidden.parameter} is {share}, which is {errors}."
    return ""


def outcome(hidden: Hidden, diagnosis: results.Diagnosis) -> str:
    """Return whether the hidden effect was named."""
    truth = (hidden.kind, hidden.at)
    if not diagnosis.steps:
        return "It was not named."
    first = diagnosis.steps[0]
    if (first.effect.kind, first.effect.at) == truth:
        equivalents = [described(rival.kind, rival.at) for rival in first.rivals_alike]
        suffix = f"; this test cannot tell it from {', '.join(equivalents)}" if equivalents else ""
        return f"It was named first{suffix}."
    if truth in [(rival.kind, rival.at) for rival in first.rivals_alike]:
        return "It is among those that this test cannot tell from the one named first."
    if truth in [(step.effect.kind, step.effect.at) for step in diagnosis.steps]:
        return "It was named, but not first."
    return "It was not named."
