"""How much the answers of a diagnosis depend on each setting: varied by a factor of 2 both ways.

The same cases of the blind trial (and, with `--foreign`, of another laboratory) are diagnosed with the
settings as they are and with each settings dataclass varied, all its fields together; where a group moved
an answer, its fields one by one. A probability is varied in odds, a count to the nearest whole. Wins and
losses are paired by case, and a sign test says how likely so uneven a split is by chance. Answers are
written as they come: `--resume` goes on where a run was cut, `--hours` ends one in time.

    python -m benchmarks.sensitivity --out sensitivity.jsonl --resume --hours 6 --report docs/sensitivity.md

A foreign case is a folder with `structure.json` and `rig.json` (request bodies), `measured.npz` or
`measured.uff`, `truth.json` ({"effects": [{"kinds": [..]}]}, several kinds where several names are right)
and, if there are any, `tolerances.json`.
"""

import argparse
import importlib
import json
import pkgutil
import textwrap
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import cache, partial
from pathlib import Path
from typing import Any

from scipy.stats import binomtest

import modallab
from benchmarks.trial.cases import case
from benchmarks.trial.running import Answer, Question, answered_here, run
from modallab.api.from_files import Files, diagnose_files
from modallab.core.progress import silent
from modallab.core.settings import Settings

# Own cases: of sets 1 (exact model), 2 (leakage) and 3 (tolerances), drawn by the trial's own seeds.
N_OF_SETS = {"1": (9001, 28), "2": (10001, 8), "3": (10001, 12)}  # seed, cases


def interleaved(n_of_sets: Mapping[str, tuple[int, int]]) -> tuple[tuple[str, int, int], ...]:
    """Return (set, seed, number) of all cases, so ordered that any first part is a sample of all sets."""
    placed = [
        ((number + 0.5) / count, name, seed, number)
        for name, (seed, count) in n_of_sets.items()
        for number in range(count)
    ]
    return tuple((name, seed, number) for _, name, seed, number in sorted(placed))


GROUPED = interleaved(N_OF_SETS)
ROOMS = ("modallab.diagnosis",)
LEAST_CHANGES = 1  # changed cases from which on the fields of a group are varied one by one
EXPLANATION = """
Each settings dataclass of the diagnosis is halved and doubled, all fields together, and its fields one by
one where that changed an answer; terms are in the [glossary](glossary.md). Wins and losses are cases that are
right only with the variation, or only without it; chance is the two-sided sign test's. Settings that are
not listed changed no answer.
"""
FACTORS = {"halved": 0.5, "doubled": 2.0}


@dataclass(frozen=True)
class Variation:
    """Settings that are varied together by one factor; no field names: all of the group."""

    group: str = ""
    field: str = ""
    direction: str = ""

    def __str__(self) -> str:
        return " ".join(filter(None, (self.group, self.field, self.direction))) or "as they are"


@cache
def groups() -> dict[str, Settings]:
    """Return all settings that decide what a diagnosis says, by module and name."""
    result: dict[str, Settings] = {}
    for module in pkgutil.walk_packages(modallab.__path__, "modallab."):
        if not module.name.endswith("settings") or not module.name.startswith(ROOMS):
            continue
        room = module.name.removeprefix("modallab.").rpartition(".")[0]
        for name, value in vars(importlib.import_module(module.name)).items():
            if isinstance(value, Settings):
                result[f"{room}.{name}"] = value
    return result


def varied(value: Any, unit: str, factor: float) -> Any:
    """Return a setting times a factor: a probability in odds, a count to the nearest whole, one at least."""
    if isinstance(value, tuple):
        return tuple(varied(item, unit, factor) for item in value)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    if unit == "probability":
        odds = factor * value / (1 - value)
        return odds / (1 + odds)
    if isinstance(value, int):
        return max(1, round(value * factor))
    return value * factor


@contextmanager
def applied(variation: Variation) -> Iterator[None]:
    """Vary settings in this process while the context lasts."""
    if not variation.group:
        yield
        return
    settings = groups()[variation.group]
    specs = settings.specs()
    names = [variation.field] if variation.field else [f.name for f in fields(settings)]
    original = {name: getattr(settings, name) for name in names}
    try:
        for name in names:
            changed = varied(original[name], specs[name].unit, FACTORS[variation.direction])
            object.__setattr__(settings, name, changed)
        yield
    finally:
        for name, value in original.items():
            object.__setattr__(settings, name, value)


def ask(variation: Variation, question: Question) -> Answer:
    """Return the answer with varied settings; measuring and scoring see them as they are."""
    with applied(variation):
        return answered_here(question)


def own_case(variation: Variation, name: str, seed: int, number: int) -> dict[str, Any]:
    """Return whether an own case is answered rightly, and the time."""
    start = time.process_time()
    line = run(case(number, seed, name), partial(ask, variation))
    right = bool(line["right"]) and not line.get("trouble")
    return {"case": f"{name}/{seed}/{number}", "right": right, "seconds": time.process_time() - start}


def foreign_case(variation: Variation, folder: Path) -> dict[str, Any]:
    """Return whether a foreign case is answered rightly: every named effect, and no other."""
    start = time.process_time()
    measured = next(path for path in sorted(folder.glob("measured.*")))
    tolerances = folder / "tolerances.json"
    body = {"tolerances": json.loads(tolerances.read_text())} if tolerances.exists() else {}
    files = Files(folder / "structure.json", folder / "rig.json", measured)
    with applied(variation):
        result = diagnose_files(files, body, averages=None, progress=silent).diagnosis
    effects = [step.effect.kind for step in result.steps]
    hidden = [set(effect["kinds"]) for effect in json.loads((folder / "truth.json").read_text())["effects"]]
    right = len(effects) == len(hidden) and all(kinds & set(effects) for kinds in hidden)
    return {"case": folder.name, "right": right, "seconds": time.process_time() - start}


def name_of(case: Any) -> str:
    """Return the name of an own case (set, seed, number) or of a foreign one, its folder's."""
    return case.name if isinstance(case, Path) else "/".join(map(str, case))


def answer(variation: Variation, case: Any) -> dict[str, Any]:
    """Return one answer as plain data; one that fails counts as wrong."""
    try:
        line = foreign_case(variation, case) if isinstance(case, Path) else own_case(variation, *case)
    except Exception as error:
        line = {
            "case": name_of(case),
            "right": False,
            "seconds": 0.0,
            "trouble": f"{type(error).__name__}: {error}",
        }
    return line | {"group": variation.group, "field": variation.field, "direction": variation.direction}


def read(path: Path) -> dict[tuple[Variation, str], dict[str, Any]]:
    """Return the answers of earlier runs by variation and case."""
    lines = path.read_text().splitlines() if path.exists() else []
    parsed = [json.loads(line) for line in lines if line.endswith("}")]
    return {(Variation(p["group"], p["field"], p["direction"]), p["case"]): p for p in parsed}


class Study:
    """Answers known so far, and the work that is left until the deadline."""

    def __init__(self, cases: Sequence[Any], out: Path, workers: int, deadline: float) -> None:
        self.cases, self.out, self.workers, self.deadline = cases, out, workers, deadline
        self.answers = read(out)

    def run(self, variations: Sequence[Variation]) -> None:
        """Answer all cases with each variation, each answer written down at once."""
        names = {case: name_of(case) for case in self.cases}
        waiting = [
            (variation, case)
            for variation in variations
            for case in self.cases
            if (variation, names[case]) not in self.answers
        ]
        with ProcessPoolExecutor(self.workers) as pool:
            tasks = {}
            for variation, case in waiting:
                tasks[pool.submit(answer, variation, case)] = variation
            for task in as_completed(tasks):
                line = task.result()
                self.answers[tasks[task], line["case"]] = line
                with self.out.open("a") as file:
                    file.write(json.dumps(line) + "\n")
                if time.monotonic() > self.deadline:
                    pool.shutdown(cancel_futures=True)
                    return

    def compare(self, variation: Variation) -> tuple[int, int, int]:
        """Return cases that are right only with the variation, only without it, and all compared."""
        wins = losses = compared = 0
        for (varied_by, name), line in self.answers.items():
            original = self.answers.get((Variation(), name))
            if varied_by != variation or original is None:
                continue
            compared += 1
            wins += line["right"] and not original["right"]
            losses += original["right"] and not line["right"]
        return wins, losses, compared


def report(study: Study) -> str:
    """Return the table, the most fragile settings first."""
    base = [line for (variation, _), line in study.answers.items() if variation == Variation()]
    right = sum(line["right"] for line in base)
    troubles = [line["trouble"] for line in base if "trouble" in line]
    failed = f"; {len(troubles)} failed, the first with {troubles[0]}" if troubles else ""
    rows = []
    for variation in dict.fromkeys(variation for variation, _ in study.answers):
        if variation == Variation():
            continue
        wins, losses, compared = study.compare(variation)
        chance = binomtest(wins, wins + losses).pvalue if wins + losses else 1.0
        rows.append((losses - wins, losses + wins, variation, wins, losses, compared, chance))
    rows.sort(key=lambda row: (-row[0], -row[1], str(row[2])))
    lines = [
        "# How sensitive answers are to settings",
        "",
        *textwrap.wrap(EXPLANATION.strip(), 120),
        "",
        f"{right} of {len(base)} cases are right with the settings as they are{failed}.",
        "",
        "| settings | wins | losses | cases | chance |",
        "|---|---:|---:|---:|---:|",
    ]
    lines += [
        f"| {variation} | {wins} | {losses} | {compared} | {chance:.2g} |"
        for _, n_changed, variation, wins, losses, compared, chance in rows
        if n_changed
    ]
    steady = sum(not row[1] for row in rows)
    return "\n".join([*lines, "", f"{steady} of {len(rows)} variations changed no answer.", ""])


def main() -> None:
    """Vary settings in groups, then singly, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, required=True, help="file of JSON lines")
    parser.add_argument("--resume", action="store_true", help="go on with the answers of --out")
    parser.add_argument("--foreign", type=Path, help="folder of another laboratory's cases")
    parser.add_argument("--hours", type=float, default=6.0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--cases", type=int, default=len(GROUPED), help="own cases, the first so many")
    parser.add_argument("--groups", nargs="+", help="these groups alone")
    parser.add_argument("--report", type=Path, help="write the table to this file")
    options = parser.parse_args()
    if options.out.exists() and not options.resume:
        parser.error(f"{options.out} exists: --resume goes on with it")
    cases = [
        *GROUPED[: options.cases],
        *(sorted(p for p in options.foreign.iterdir() if p.is_dir()) if options.foreign else ()),
    ]
    study = Study(cases, options.out, options.workers, time.monotonic() + 3600 * options.hours)
    names = options.groups or list(groups())
    study.run([Variation()])
    for name in names:
        variations = [Variation(name, "", direction) for direction in FACTORS]
        study.run(variations)
        if time.monotonic() > study.deadline:
            break
        if any(sum(study.compare(variation)[:2]) >= LEAST_CHANGES for variation in variations):
            singles = [f.name for f in fields(groups()[name])]
            study.run([Variation(name, field, direction) for field in singles for direction in FACTORS])
    text = report(study)
    print(text)
    if options.report:
        options.report.write_text(text)


if __name__ == "__main__":
    main()
