"""A study is shared out over worker hosts, and outlives the death of a worker process."""

import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from modallab.api.settings import ServiceSettings
from tests.databases import database
from tests.serving import Lab, free_port, running

Served = tuple[Lab, ServiceSettings, dict[str, str]]
SEEDS = 16


@contextmanager
def served(folder: Path) -> Iterator[Served]:
    """A service that only takes jobs, and what its workers need to know."""
    port = free_port()
    with Lab(port) as lab, database("postgresql", folder) as (url, schema):
        environment = {"MODALLAB_DATABASE_URL": url, "MODALLAB_DATABASE_SCHEMA": schema}
        with running("init", data=folder, environment=environment) as init:
            assert init.wait(60) == 0
        arguments = ("serve", "--role", "api", "--port", str(port))
        with running(*arguments, data=folder, environment=environment):
            lab.wait_until_up()
            yield lab, ServiceSettings(data=folder, database_url=url, database_schema=schema), environment


def question(lab: Lab) -> dict[str, Any]:
    """Return the body of a study of the bay, some seconds of work."""
    model = lab.json("POST", "/structures", {"kind": "catalogue", "name": "bay"})["id"]
    changes = [{"members": [25, 26], "property": "density", "factor": 1.5}]
    truth = lab.json("POST", f"/structures/{model}/changes", {"changes": changes})["id"]
    dofs = [f"{n}:+{d}" for n in range(1, 31, 2) for d in "XY"]
    return {
        "structure_id": model,
        "truth_id": truth,
        "dofs": dofs,
        "levels": ["NL3"],
        "seeds": list(range(SEEDS)),
    }


def hosts_of_shares(settings: ServiceSettings) -> dict[str, int]:
    """Return how many runs each worker host made."""
    place = settings.job_place
    engine = sa.create_engine(sa.make_url(place.url).set(drivername="postgresql+psycopg"))
    asked = sa.text(
        f'SELECT executor_id, count(*) FROM "{place.schema}".workflow_status '
        "WHERE name = 'share' AND status = 'SUCCESS' GROUP BY executor_id"
    )
    with engine.begin() as connection:
        found = {str(host): int(n) for host, n in connection.execute(asked)}
    engine.dispose()
    return found


def kill_children(process: "subprocess.Popen[bytes]") -> int:
    """Kill the processes that a worker host works with; return their number."""
    found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, text=True)
    for child in found.stdout.split():
        os.kill(int(child), signal.SIGKILL)
    return len(found.stdout.split())


def test_two_hosts_share_a_study_and_the_death_of_a_process_costs_no_run(tmp_path: Path) -> None:
    with served(tmp_path) as (lab, settings, environment):
        body = question(lab)
        one = running("worker", "--executor-id", "host-1", data=tmp_path, environment=environment)
        two = running("worker", "--executor-id", "host-2", data=tmp_path, environment=environment)
        with one as process, two:
            job = lab.json("POST", "/studies", body)["id"]
            lab.wait_for(job, state="running", fraction=0.05)
            killed = kill_children(process)
            ended = lab.wait_for(job, state="succeeded")
        made = hosts_of_shares(settings)
        assert killed >= 1
        assert set(made) == {"host-1", "host-2"}
        assert sum(made.values()) == SEEDS
        (cell,) = lab.json("GET", f"/studies/{ended['result_id']}")["cells"]
        assert (cell["n_runs"], cell["n_failed"], cell["suspected"]) == (SEEDS, 0, 1.0)
