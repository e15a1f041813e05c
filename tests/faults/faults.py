"""What befalls a site while a job runs; nobody starts or stops anything but a supervisor, as on a server."""

import shutil
import signal
import sqlite3
import time
from collections.abc import Callable, Sequence
from contextlib import closing, suppress

import psutil

from modallab.jobs.settings import JOB
from tests.faults.site import SMALL_DISK, Site

Fault = Callable[[Site], None]
POLITE_END = 30.0  # s; 5 on a quiet machine: a host that gives nothing back waits for its job, minutes


def child_killed(site: Site) -> None:
    """Kill every worker process."""
    site.hit(signal.SIGKILL)


def child_killed_ten_times(site: Site) -> None:
    """Kill every worker process ten times."""
    for _ in range(10):
        site.hit(signal.SIGKILL)
        time.sleep(0.7)


def child_stopped(site: Site) -> None:
    """Stop every worker process as a debugger does."""
    site.hit(signal.SIGSTOP)


def hosts_killed(site: Site) -> None:
    """Kill all that runs jobs; a supervisor starts it anew."""
    for host in list(site.hosts):
        host.kill()
        host.wait()
    site.hosts.clear()
    site.start_host()


def one_host_killed(site: Site) -> None:
    """Kill the first of two hosts for good."""
    site.hosts[0].kill()
    site.hosts[0].wait()


def at_work(processes: Sequence[psutil.Process]) -> list[psutil.Process]:
    """Return the processes that are still at work some seconds later."""
    _, living = psutil.wait_procs(processes, timeout=5.0)
    return [process for process in living if process.status() != psutil.STATUS_ZOMBIE]


def hosts_replaced(site: Site) -> None:
    """End each host politely once another stands beside it: a rolling restart with new names."""
    for host in list(site.hosts):
        if site.gate:
            site.start_host()
        children = site.children([host])
        host.send_signal(signal.SIGTERM)
        begin = time.monotonic()
        host.wait(60)
        assert time.monotonic() - begin < POLITE_END, "a host took long to end"
        assert not at_work(children), "a worker process outlives its host"
        site.hosts.remove(host)
        if not site.gate:
            site.start_host()


def hosts_ended_without_database(site: Site) -> None:
    """Ask all that runs jobs to end while the database is away; a supervisor starts it anew."""
    assert site.gate
    with site.gate.shut():
        time.sleep(5.0)
        for host in site.hosts:
            host.send_signal(signal.SIGTERM)
        for host in list(site.hosts):
            host.wait(JOB.longest_end + 5.0)
    site.hosts.clear()
    for _ in range(2):
        site.start_host()


def database_away(seconds: float) -> Fault:
    """Return the fault that the database is away for a time."""

    def fault(site: Site) -> None:
        assert site.gate
        with site.gate.shut():
            time.sleep(seconds)

    return fault


def writer_lock(seconds: float) -> Fault:
    """Return the fault that another program holds the database for a time."""

    def fault(site: Site) -> None:
        with closing(sqlite3.connect(site.data / "modallab.sqlite", isolation_level=None)) as other:
            other.execute("BEGIN IMMEDIATE")
            time.sleep(seconds)
            other.execute("ROLLBACK")

    return fault


def disk_full(seconds: float) -> Fault:
    """Return the fault that the disk with the data, a small one, is full for a time."""

    def fault(site: Site) -> None:
        assert shutil.disk_usage(site.data).total <= SMALL_DISK, "a real disk is not filled"
        filler = site.data / "filler"
        try:
            with suppress(OSError), filler.open("wb", buffering=0) as file:
                while True:
                    file.write(bytes(65536))
            time.sleep(seconds)
        finally:
            filler.unlink()

    return fault


ON_A_SMALL_DISK = "disk full for 10 s"
EVERYWHERE: dict[str, Fault] = {
    "child killed": child_killed,
    "child killed ten times": child_killed_ten_times,
    "child stopped": child_stopped,
    "hosts killed": hosts_killed,
    "hosts replaced": hosts_replaced,
    ON_A_SMALL_DISK: disk_full(10.0),
}
FAULTS: dict[str, dict[str, Fault]] = {
    "sqlite": {**EVERYWHERE, "writer lock of 45 s": writer_lock(45.0)},
    "postgresql": {
        **EVERYWHERE,
        "one host killed": one_host_killed,
        "hosts ended without database": hosts_ended_without_database,
        "database away for 5 s": database_away(5.0),
        "database away for 45 s": database_away(45.0),
        "database away for 120 s": database_away(120.0),
    },
}
