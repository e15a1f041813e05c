"""Disturbs jobs at random moments, and tells what became of each.

    python -m tests.faults --moments 20 --database postgresql
    python -m tests.faults --moments 2 --only "child killed"

A clock jump needs rights: that no clock but the monotonic one counts is tested in `test_executors.py`. The
disk that is full is one of 256 MB in memory, which needs rights too; without them that fault is left out.
"""

import argparse
import tempfile
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from tests.faults.faults import FAULTS, ON_A_SMALL_DISK, Fault
from tests.faults.site import LIMIT, Question, Site, may_mount, questions, site, small_disk


def disturbed(
    place: Site, question: Question, fault: Fault, moment: float, limit: float = LIMIT
) -> tuple[object, float]:
    """Return a job's result, and the seconds that it took after the fault had ended."""
    job = question.start(place.lab)
    time.sleep(moment)
    fault(place)
    ended = time.monotonic()
    return question.result(place.lab, job, limit), time.monotonic() - ended


def main() -> None:
    """Run faults and print what became of each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--moments", type=int, default=20)
    parser.add_argument("--database", choices=FAULTS, nargs="*", default=list(FAULTS))
    parser.add_argument("--only", nargs="*", help="names of faults")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    outcomes: Counter[str] = Counter()
    for kind in options.database:
        for name, fault in FAULTS[kind].items():
            if options.only and name not in options.only:
                continue
            if name == ON_A_SMALL_DISK and not may_mount():
                print(f"{kind}, {name}: left out, no file system may be mounted here", flush=True)
                continue
            rng, slowest = np.random.default_rng(options.seed), 0.0
            with ExitStack() as stack:
                folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
                if name == ON_A_SMALL_DISK:
                    stack.enter_context(small_disk(folder))
                place = stack.enter_context(site(kind, folder))
                asked = questions(place.lab)
                begin = time.monotonic()
                expected = [q.result(place.lab, q.start(place.lab)) for q in asked]
                usual = (time.monotonic() - begin) / len(asked)
                for moment in range(options.moments):
                    i = moment % len(asked)
                    while len(place.hosts) < 2 and place.gate:
                        place.start_host()
                    try:
                        found, seconds = disturbed(place, asked[i], fault, float(rng.uniform(0, usual)))
                        outcome = "same result" if found == expected[i] else "ANOTHER RESULT"
                        slowest = max(slowest, seconds)
                    except (TimeoutError, AssertionError) as error:
                        outcome = f"LOST: {str(error)[:300]}"
                        print(outcome, flush=True)
                    place.hosts[:] = [host for host in place.hosts if host.poll() is None]
                    outcomes[outcome.partition(":")[0]] += 1
                time.sleep(5.0)
                agree = place.unfinished()
            print(
                f"{kind}, {name}: {options.moments} moments, slowest {slowest:.1f} s, left {agree}",
                flush=True,
            )
    print(dict(outcomes))


if __name__ == "__main__":
    main()
