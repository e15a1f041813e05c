"""A blind trial of the diagnosis: hidden effects, sealed truths, a score.

Each case is a measurement by the `sampled` route of a structure and a rig in which effects are hidden: one,
two, none, one that no catalogue holds, or a mistake in the log book. Place and sense are drawn; the strength
is such that the gap it opens is log-uniform from 2 to 10,000. The diagnosis is given the model and the
measurement with its log book; the scorer alone knows the truth.

Sets: 1 exact model, periodic random; 2 pure random through a Hann window; 3 with tolerances, all varied; 3a
the same with up to two of the proposed tests done, scored before them as well; 4 single effects of kinds that
joined the catalogue after these sets were drawn, as set 1. A case is the same whatever
others are run with it: a trial may be cut and continued, and its cases run one by one.

    python -m benchmarks.blind_trial --set 1 --cases 416 --seed 1 --workers 2 --out set1.jsonl --resume
    python -m benchmarks.blind_trial --out set1.jsonl set2.jsonl --report docs/trial.md

`make trial` runs all sets and writes `docs/trial.md`. Its lines go to `benchmarks/trial/results`, which git
ignores: the page names command, seeds and commit, from which the same lines follow.

With `--service` each question is a job of a service (`embedded`: of one started for it), which shares the
jobs out over its workers; cases are drawn, measured and scored here all the same, `--workers` at a time. The
service is sent model, log book and measurement. Seconds are then those for which a job ran, not CPU time.

    python -m benchmarks.blind_trial --service http://host:8000 --workers 8 --out set1.jsonl --resume
"""

import argparse
import json
import subprocess
import traceback
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import nullcontext
from functools import cache, partial
from pathlib import Path
from typing import Any

from benchmarks.trial.cases import ROUND, SETS, case, type_of
from benchmarks.trial.reporting import report, row
from benchmarks.trial.running import Ask, answered_here, run
from benchmarks.trial.through_service import answered_by, service_at
from modallab_client.errors import UnreachableError

TITLE = """# The blind trial

Terms and symbols: [glossary](glossary.md).

Effects are hidden in simulated tests. A diagnosis that knows model, log book and measurement alone names
them. `python -m benchmarks.blind_trial` draws the cases, runs them and writes this page; its docstring
defines the sets. Another effect counts as correct (equivalent) where the two predictions differ by less than
the random error of all data together; the scorer computes this from the true effects.

`make trial` repeats all sets, with the seeds and the code revisions stated with each set. The results of
single cases are not kept in git.
"""


def run_case(number: int, seed: int, set_name: str, ask: Ask) -> dict[str, Any]:
    """Return the score of one case by its number; a case that cannot be drawn says why.

    Raises
    ------
    UnreachableError
        If a service that is asked does not answer.
    """
    try:
        return run(case(number, seed, set_name), ask) | {"seed": seed, "revision": revision()}
    except UnreachableError:
        raise
    except Exception as error:  # nothing was asked of the diagnosis: the case does not count
        traceback.print_exc()  # the line says why, and nothing of where on this machine
        return {"number": number, "set": set_name, "seed": seed, "void": f"{type(error).__name__}: {error}"}


@cache
def revision() -> str:
    """Return which commit runs, and whether with other code; empty where it is not known."""
    git = ["git", "-C", str(Path(__file__).parent.parent)]
    code = ["status", "--porcelain", "--", "*.py", "pyproject.toml", "requirements.lock"]
    try:
        commit, changed = (
            subprocess.run([*git, *revision_query], capture_output=True, text=True, check=True).stdout.strip()
            for revision_query in (["describe", "--always"], code)
        )
    except (OSError, subprocess.CalledProcessError):
        return ""
    return f"{commit}-dirty" if changed else commit


def case_numbers(text: str) -> list[int]:
    """Return case numbers from `3,7,10-14`."""
    listed: list[int] = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        listed += range(int(first), int(last or first) + 1)
    return listed


def read(paths: Iterable[Path]) -> list[dict[str, Any]]:
    """Return the lines of earlier runs, the last of each case; one that was cut off does not count."""
    records: dict[tuple[str, int, int], dict[str, Any]] = {}
    for path in paths:
        for text in path.read_text().splitlines() if path.exists() else []:
            try:
                line = json.loads(text)
            except json.JSONDecodeError:
                continue
            # Before any further test a case of 3a is one of 3.
            identity = {name: line[name] for name in ("seed", "revision") if name in line}
            for record in (line, *([line["first"] | identity] if "first" in line else [])):
                records[record["set"], record["seed"], record["number"]] = record
    return list(records.values())


def _write(line: dict[str, Any], path: Path) -> None:
    whole = not path.exists() or path.read_bytes()[-1:] in (b"", b"\n")
    with path.open("a") as file:
        file.write(("" if whole else "\n") + json.dumps(line) + "\n")


def trial(
    numbers: Sequence[int], seed: int, set_name: str, out: Path | None, workers: int, ask: Ask = answered_here
) -> list[dict[str, Any]]:
    """Run cases, each written down as soon as it is done."""
    lines = []
    with ProcessPoolExecutor(workers) as pool:
        tasks = [pool.submit(run_case, number, seed, set_name, ask) for number in numbers]
        for n_done, task in enumerate(as_completed(tasks), 1):
            try:
                line = task.result()
            except UnreachableError:
                pool.shutdown(cancel_futures=True)
                raise
            lines.append(line)
            if out is not None:
                _write(line, out)
            outcome = f"{line['number']:4d} void {line['void']}" if "void" in line else row(line)
            print(f"[{n_done}/{len(tasks)}] {outcome}", flush=True)
    return lines


def main() -> None:
    """Run cases, or write the page from those that were run."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--set", choices=SETS, default="1")
    parser.add_argument("--cases", type=int, default=ROUND, help="numbers 0 to this; a round has 52")
    parser.add_argument("--only", type=case_numbers, help="case numbers instead, such as 3,7,10-14")
    parser.add_argument("--types", nargs="*", choices=sorted({type_of(n) for n in range(ROUND)}))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--service", metavar="URL", help="ask a service, or `embedded`; without follow-ups")
    parser.add_argument("--out", type=Path, nargs="*", default=[], help="lines of results, one a case")
    parser.add_argument("--resume", action="store_true", help="leave out cases that are in --out already")
    parser.add_argument("--report", type=Path, help="write tables of --out to this file and run nothing")
    options = parser.parse_args()
    if options.service and options.set == "3a":
        parser.error("set 3a measures further tests on the sealed truth: it is run without --service")
    if options.report:
        lines = [line for line in read(options.out) if "void" not in line]
        if not lines:
            print(f"No lines to report: `make trial` makes them; {options.report} stays as it is.")
            return
        options.report.write_text(TITLE + "\n" + report(lines))
        return
    numbers = options.only if options.only is not None else range(options.cases)
    if options.types:
        numbers = [number for number in numbers if type_of(number, options.set) in options.types]
    if options.resume:
        finished = {(line["set"], line["seed"], line["number"]) for line in read(options.out)}
        numbers = [number for number in numbers if (options.set, options.seed, number) not in finished]
    with service_at(options.service) if options.service else nullcontext() as url:
        ask = partial(answered_by, url) if url else answered_here
        out = options.out[0] if options.out else None
        lines = trial(numbers, options.seed, options.set, out, options.workers, ask)
    print(report([line for line in lines if "void" not in line]))


if __name__ == "__main__":
    main()
