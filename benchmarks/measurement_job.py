"""A measurement as a job against the bare measurement: what queue, database and files add to the numerics.

Processor time of the process that runs the job. The request, the queue and its engine work in the service's
process, whose share `python -m benchmarks.measurement_job` prints, too: with the client's own requests.
"""

import os
import statistics
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.bench import Bench, parser
from benchmarks.measuring import measuring, setup
from benchmarks.updating_job import children
from modallab.fe.catalogued import STRUCTURES
from modallab.jobs.book import JobBook
from modallab.jobs.measuring import MeasurementInputs, MeasurementOptions
from modallab.jobs.tasks import MEASUREMENT
from modallab.jobs.work import perform
from modallab.rig.measure import Route
from modallab.store.place import StorePlace, engine_of, open_store
from modallab_client import ModalLab

ROUNDS = 15
SERVED = 20  # jobs of the service, one after another
AVERAGES = 100
MOST_SAMPLED = 1.4  # of the processor time of the bare measurement
MOST_EXPECTED = 15.0  # ms more
RIG = setup("periodic_random", averages=AVERAGES)
REQUEST: dict[str, Any] = {
    "drive": "1:+Y",
    "responses": [str(dof) for dof in RIG.responses],
    "exciter": {"armature_mass": 0.02},
    "force_transducer": {"mass_below": 0.01},
    "accelerometers": {"mass": 0.02, "roving": True},
    "noise": {"force": 1e-3, "response": 1e-3},
    "analyser": {
        "frequency_max": 800.0,
        "n_lines": 801,
        "window": "rectangular",
        "averages": AVERAGES,
        "excitation": {"kind": "periodic_random"},
    },
}


def spent(run: Callable[[], object]) -> float:
    """Return the processor time, s, of this process for a call."""
    begun = time.process_time()
    run()
    return time.process_time() - begun


def pairs(route: Route, rounds: int) -> list[tuple[float, float]]:
    """Return the processor times, s, of a job and of the bare measurement, one after the other."""
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder)
        place = StorePlace(f"sqlite:///{data / 'modallab.sqlite'}", "unused", data / "arrays")
        place.prepare()
        store, book = open_store(place), JobBook(engine_of(place), queue_length=1)
        structure_id = store.structures.add(STRUCTURES["chapter-5-beam"](), owner="local")
        inputs = MeasurementInputs(structure_id, store.rigs.add(RIG, owner="local"))
        arguments = MEASUREMENT.arguments(inputs, MeasurementOptions(route=route))
        bare, times = measuring(RIG, route), []
        for _ in range(rounds + 1):
            job = book.open(MEASUREMENT.name, arguments, owner="local")
            times.append((spent(partial(perform, place, job.id)), spent(bare)))
            assert book.get(job.id).error is None
        engine_of(place).dispose()
    return times[1:]  # the first imports and compiles


def run(rounds: int = ROUNDS) -> list[tuple[str, float, float]]:
    """Return (name, figure, limit)."""
    sampled = statistics.median(job / bare for job, bare in pairs(Route.SAMPLED, rounds))
    more = statistics.median(job - bare for job, bare in pairs(Route.EXPECTED, rounds))
    return [
        (f"sampled: a job of {AVERAGES} averages against the bare measurement", sampled, MOST_SAMPLED),
        ("expected: a job, ms more than the bare measurement", 1e3 * more, MOST_EXPECTED),
    ]


def running_time(process: int) -> float:
    """Return the processor time, s, of the living threads of a process."""
    threads = Path(f"/proc/{process}/task").iterdir()
    return sum(int((thread / "schedstat").read_text().split()[0]) for thread in threads) / 1e9


def main() -> None:
    """Print the processor time of each process of a service for one job."""
    arguments = parser(__doc__)
    arguments.add_argument(
        "--rounds", type=int, default=ROUNDS, help="pairs of a job and the bare measurement"
    )
    arguments.add_argument("--jobs", type=int, default=SERVED, help="jobs of the service, one after another")
    chosen = arguments.parse_args()
    for name, figure, limit in run(chosen.rounds):
        print(f"{figure:8.2f} of {limit:g}  {name}")
    with ModalLab.embedded() as lab:
        beam, rig = lab.structures.catalogue("chapter-5-beam"), lab.rigs.create(**REQUEST)
        for route in (Route.EXPECTED, Route.SAMPLED):
            lab.measurements.start(beam, rig, route=route).result()
            before = {process: running_time(process) for process in children(os.getpid())}
            begun = time.monotonic()
            for seed in range(chosen.jobs):
                lab.measurements.start(beam, rig, route=route, seed=seed).result()
            took = time.monotonic() - begun
            for process, earlier in before.items():
                worked = 1e3 * (running_time(process) - earlier) / chosen.jobs
                print(f"{route}: process {process} works {worked:.0f} ms a job")
            print(f"{route}: {1e3 * took / chosen.jobs:.0f} ms from request to result")


BENCH = Bench(run, short=partial(run, rounds=1))

if __name__ == "__main__":
    main()
