"""Tells whether times, events and messages of jobs betray a hidden nonlinear effect.

    python -m tests.faults.timing --jobs 400
    python -m tests.faults.timing --jobs 0 --following 60

Half of the jobs measure a test with a hidden cubic spring, half one with a hidden mass, in random order and
some at a time. A linear classifier is trained on half of them; its AUC on the rest is 0.5 where it can tell
nothing, and scatters by 0.04 for 200 jobs. `--following` asks a service in a process of its own whether the
beginning of a job that waits for two of these tells more.
"""

import argparse
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import mannwhitneyu

from modallab.api.settings import ServiceSettings
from modallab.jobs.sealing import SEALING
from tests.faults.documented import school_of
from tests.service.api.authorisation import School, assignment, open_school
from tests.service.api.conftest import service_of

NAMES = ("s waiting", "s working", "s beyond a step", "events", "bytes of job", "bytes of measurement")
Array = NDArray[np.float64]


def new_assignment(school: School, kind: str) -> str:
    """Return the id of an assignment with one hidden effect."""
    body = assignment(school.ids["class"]) | {"hidden": [{"kind": kind, "at": "2:+Y"}], "quota": 1000}
    reply = school.send("instructor", "POST", "/v1/assignments", json=body)
    assert reply.status_code == 201, reply.text
    return str(reply.json()["id"])


def seen(school: School, id: str) -> list[float]:
    """Return what a student sees of a measurement's job, in the order of `NAMES`."""
    reply = school.send("student", "POST", f"/v1/assignments/{id}/measurements", json={})
    path = f"/v1/jobs/{reply.json()['id']}"
    job = school.send("student", "GET", path).json()
    assert job["state"] == "succeeded", job
    events = school.send("student", "GET", f"{path}/events").text
    made = school.send("student", "GET", f"/v1/measurements/{job['result_id']}").content
    created, started, ended = (datetime.fromisoformat(job[name]) for name in ("created", "started", "ended"))
    working = (ended - started).total_seconds()
    waiting = (started - created).total_seconds()
    sizes = [float(events.count("data:")), float(len(str(job))), float(len(made))]
    return [waiting, working, working % SEALING.step, *sizes]


def scores(features: Array, labels: Array, n_training: int) -> Array:
    """Return the scores of all jobs by the linear discriminant of the first ones."""
    ranks = features.argsort(axis=0).argsort(axis=0).astype(float)  # nothing of the order in size is lost
    training, known = ranks[:n_training], labels[:n_training]
    means = [training[known == label].mean(axis=0) for label in (0, 1)]
    spread = np.cov(training.T) + np.eye(training.shape[1])
    return np.asarray(ranks @ np.linalg.solve(spread, means[1] - means[0]))


def auc(values: Array, labels: Array) -> float:
    """Return the area under the receiver operating characteristic."""
    positive, negative = values[labels == 1], values[labels == 0]
    return float(mannwhitneyu(positive, negative).statistic / (len(positive) * len(negative)))


def following(n: int, seed: int) -> float:
    """Return the AUC of the time until a third job begins, over a number of trials."""
    labels = np.random.default_rng(seed).permutation(np.arange(n) % 2).astype(float)
    with tempfile.TemporaryDirectory() as folder, school_of("sqlite", Path(folder)) as (school, _):
        ids = [new_assignment(school, kind) for kind in ("extra_mass", "cubic_stiffness")]
        times = np.array([until_the_third(school, ids[int(label)]) for label in labels])
    for label in (0, 1):
        print(f"s until the next begins, of {label}: {np.sort(times[labels == label])[:: max(1, n // 10)]}")
    return auc(times, labels)


def until_the_third(school: School, id: str) -> float:
    """Return the time, s, from the beginning of two measurements to that of a third, which waits for them."""
    replies = [
        school.send("student", "POST", f"/v1/assignments/{id}/measurements", json={}) for _ in range(3)
    ]
    paths = [f"/v1/jobs/{reply.json()['id']}" for reply in replies]
    while True:
        jobs = [school.send("student", "GET", path).json() for path in paths]
        if all(job["ended"] for job in jobs):
            break
        time.sleep(0.2)
    first, _, third = sorted(datetime.fromisoformat(job["started"]) for job in jobs)
    return (third - first).total_seconds()


def main() -> None:
    """Measure, train, and print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--jobs", type=int, default=400)
    parser.add_argument("--at-a-time", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--following", type=int, default=0, help="trials of three jobs")
    options = parser.parse_args()
    if options.following:
        print(f"beginning of the next job: AUC {following(options.following, options.seed):.3f}")
    if options.jobs:
        classified(options.jobs, options.at_a_time, options.seed)


def classified(n: int, at_a_time: int, seed: int) -> None:
    """Print what a classifier tells from so many jobs."""
    labels = np.random.default_rng(seed).permutation(np.arange(n) % 2).astype(float)
    with tempfile.TemporaryDirectory() as folder, service_of(ServiceSettings(data=Path(folder))) as service:
        school = open_school(service)
        ids = [new_assignment(school, kind) for kind in ("extra_mass", "cubic_stiffness")]
        with ThreadPoolExecutor(at_a_time) as pool:
            features = np.array(list(pool.map(lambda label: seen(school, ids[int(label)]), labels)))
    n_training = n // 2
    rest = labels[n_training:]
    steps = [f"{np.unique(np.floor(features[labels == label, 1] / SEALING.step))}" for label in (0, 1)]
    print(f"steps of {SEALING.step:g} s: linear {steps[0]}, nonlinear {steps[1]}")
    for name, column in zip(NAMES, features.T, strict=True):
        print(f"{name}: AUC {auc(column[n_training:], rest):.3f}")
    value = auc(scores(features, labels, n_training)[n_training:], rest)
    print(f"{n} jobs, {n_training} for training: AUC {value:.3f} on the rest")


if __name__ == "__main__":
    main()
