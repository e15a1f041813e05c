"""The same figures before and after a change of the code that shall change none.

Measurements on all routes, extractions and updates by all methods go through the client and the contract's
fields, 60 cases of the blind trial's set 1 are run in this process. `--write` keeps the answers in a folder,
best outside the tree; `--against` compares with an earlier one and ends with 1 where an answer differs.

    python -m benchmarks.same_figures --write /tmp/before
    python -m benchmarks.same_figures --write /tmp/after --against /tmp/before
"""

import argparse
import json
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.blind_trial import run_case as trial_case
from benchmarks.trial.running import answered_here
from modallab_client import ModalLab

SEED = 9001
# Six of every ten: singles of all kinds, pairs, tests with nothing missing, unknown effects.
CASES = tuple(np.sort(np.random.default_rng(SEED).permutation(416)[:60]).tolist())
RELATIVE = 1e-6  # parameters and figures
FLOOR = 1e-12  # of an array's largest entry: below it rounding differs with the order of sums
NO_ERROR = 1e-12  # Hz: a standard error below is rounding, of a method that has no model of the noise
RESPONSES = [f"{n}:+Y" for n in range(1, 22, 2)]
RIGS: dict[str, dict[str, Any]] = {
    "ideal": {"drive": "1:+Y", "responses": RESPONSES},
    "roving": {
        "drive": "1:+Y",
        "responses": RESPONSES,
        "exciter": {"kind": "shaker", "armature_mass": 0.02},
        "force_transducer": {"mass_below": 0.01},
        "accelerometers": {"mass": 0.02, "roving": True},
        "noise": {"force": 1e-3, "response": 1e-3},
    },
    "leaking": {
        "drive": "1:+Y",
        "responses": RESPONSES,
        "analyser": {"window": "hann", "excitation": {"kind": "random", "level": 1.0}},
        "noise": {"force": 1e-4, "response": 1e-4},
    },
}


def client_answers() -> dict[str, Any]:
    """Return measured, extracted and updated figures by name, as plain lists."""
    answers: dict[str, Any] = {}
    with ModalLab.embedded() as lab:
        beam = lab.structures.catalogue("chapter-5-beam")
        truth = lab.structures.change(beam.id, members=[7], property="modulus", factor=1.3)
        for rig_name, body in RIGS.items():
            rig = lab.rigs.create(**body)
            for route in ("expected", "drawn", "sampled"):
                name = f"{rig_name}/{route}"
                test = lab.measurements.start(truth.id, rig.id, route=route, seed=5).result()
                sampling = slice(None, None, 7)
                values = test.values[sampling]
                assert test.coherence is not None
                answers[f"measurement/{name}"] = {
                    "real": values.real.tolist(),
                    "imag": values.imag.tolist(),
                    "coherence": test.coherence[sampling].tolist(),
                }
                if route == "sampled":
                    answers |= _extractions(lab, test.id, name)
        answers |= _updates(lab, beam.id, truth.id)
    return answers


def _extractions(lab: ModalLab, test_id: str, name: str) -> dict[str, Any]:
    """Return frequencies and loss factors by each extraction method."""
    answers: dict[str, dict[str, Any]] = {}
    for method in sorted(m["kind"] for m in lab.request("GET", "/v1/catalog/extraction-methods")):
        job = lab.modal_models.start(test_id, method=method, n_modes=8)
        try:
            model = job.result()
        except Exception as error:  # the same refusal counts as the same answer
            answers[f"extraction/{name}/{method}"] = {"refused": type(error).__name__}
            continue
        answers[f"extraction/{name}/{method}"] = {
            "frequency": [mode.frequency for mode in model.modes],
            "loss_factor": [mode.loss_factor for mode in model.modes],
            "standard_errors": [mode.standard_errors.get("frequency") for mode in model.modes],
        }
    return answers


def _updates(lab: ModalLab, beam_id: str, truth_id: str) -> dict[str, Any]:
    """Return coefficients by each updating method that takes modes."""
    answers = {}
    modes = lab.request(
        "POST",
        f"/v1/structures/{truth_id}/synthetic-modes",
        json={
            "count": 10,
            "dofs": [f"{n}:+Y" for n in range(1, 22)],
            "noise": {"eigenvalue": 1e-4},
            "seed": 3,
        },
    )
    for method in sorted(m["kind"] for m in lab.request("GET", "/v1/catalog/updating-methods")):
        try:
            update = lab.updates.start(beam_id, modes["id"], method=method).result()
        except Exception as error:
            answers[f"update/{method}"] = {"refused": type(error).__name__}
            continue
        reply = lab.request("GET", f"/v1/updates/{update.id}")
        answers[f"update/{method}"] = {
            name: reply.get(name, {})
            for name in ("coefficients", "suspected", "frequencies", "stopped_because")
        }
    return answers


def trial_answer(number: int) -> dict[str, Any]:
    """Return kind, place, verdict and numbers of one case of set 1."""
    line = trial_case(number, SEED, "1", answered_here)
    steps = [
        {name: step[name] for name in ("kind", "at", "parameters", "gap_before", "gap_after")}
        for step in line.get("steps", ())
    ]
    return {"verdict": line.get("verdict"), "void": line.get("void"), "steps": steps}


def differences(reference: Any, current: Any, path: str = "") -> Iterator[str]:
    """Yield where two answers differ by more than rounding."""
    if isinstance(reference, dict) and isinstance(current, dict):
        if {"real", "imag"} <= reference.keys() & current.keys():
            yield from _array_difference(_complex(reference), _complex(current), path)
            reference, current = ({"coherence": answer["coherence"]} for answer in (reference, current))
        for name in reference.keys() | current.keys():
            yield from differences(reference.get(name), current.get(name), f"{path}/{name}")
    elif _numeric(reference) and _numeric(current):
        yield from _array_difference(np.array(reference, float), np.array(current, float), path)
    elif isinstance(reference, list) and isinstance(current, list) and len(reference) == len(current):
        for i, pair in enumerate(zip(reference, current, strict=True)):
            yield from differences(*pair, f"{path}/{i}")
    elif reference != current:
        yield f"{path}: {str(reference)[:80]!r} is now {str(current)[:80]!r}"


def _array_difference(reference: Any, current: Any, path: str) -> Iterator[str]:
    """Yield one line where two arrays differ; rounding of a complex number is relative to its magnitude."""
    if reference.shape != current.shape:
        yield f"{path}: shape {reference.shape} is now {current.shape}"
        return
    floor = (
        NO_ERROR if path.endswith("standard_errors") else FLOOR * np.nanmax(np.abs(reference), initial=0.0)
    )
    if not np.allclose(reference, current, rtol=RELATIVE, atol=floor, equal_nan=True):
        yield f"{path}: numbers differ, at most by {np.nanmax(np.abs(reference - current)):.3g}"


def _complex(answer: dict[str, Any]) -> Any:
    return np.array(answer["real"]) + 1j * np.array(answer["imag"])


def _numeric(values: Any) -> bool:
    if isinstance(values, float):
        return True
    if not isinstance(values, list):
        return False
    try:
        return np.array(values).dtype.kind in "fiu"
    except ValueError:
        return False


def main() -> int:
    """Write the answers, compare them, and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--write", type=Path, required=True, help="folder for the answers")
    parser.add_argument("--against", type=Path, help="folder of earlier answers")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--cases", type=int, default=len(CASES), help="of the trial, the first so many")
    parser.add_argument("--parts", nargs="+", default=["client", "trial"], choices=["client", "trial"])
    options = parser.parse_args()
    options.write.mkdir(parents=True, exist_ok=True)
    changed = 0
    for name in options.parts:
        if name == "client":
            answers = client_answers()
        else:
            with ProcessPoolExecutor(options.workers) as pool:
                numbers = CASES[: options.cases]
                figures = pool.map(trial_answer, numbers)
                answers = {str(number): answer for number, answer in zip(numbers, figures, strict=True)}
        # as an earlier run was read: tuples are lists, keys are text
        answers = json.loads(json.dumps(answers))
        (options.write / f"{name}.json").write_text(json.dumps(answers))
        if options.against:
            lines = list(differences(json.loads((options.against / f"{name}.json").read_text()), answers))
            print(f"{name}: {len(answers)} answers, {len(lines)} differences", *lines, sep="\n  ")
            changed += len(lines)
    return int(changed > 0)


if __name__ == "__main__":
    sys.exit(main())
