"""A service that nobody uses costs next to nothing, and stays connected."""

import http.client
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import psutil

from modallab.jobs.settings import JOB
from tests.serving import Lab, free_port, running

WATCHED = 10.0  # s: more than one reconciliation of an idle service
# A process that asks a database one thing ten times a second. What such a step costs, and with it what the
# service costs, differs by a factor of three from machine to machine.
PEER = """
import sys, time, sqlalchemy
engine = sqlalchemy.create_engine("sqlite:///" + sys.argv[1])
while True:
    with engine.begin() as connection:
        connection.execute(sqlalchemy.text("SELECT 1"))
    time.sleep(0.1)
"""
# 2.5 times the processor time of the peer by itself, which is 0.9 to 2.7 % of a core; its clock has steps of
# 0.01 s, and two reconciliations more or less fall into ten seconds.
MOST = 5.5
# Work beside it on the same core makes caches cold, so that the same steps take longer: one of these spells
# has to be undisturbed. What the service does every few seconds it does in each.
SPELLS = 4


def _ratio_of_times(processes: Sequence[psutil.Process]) -> float:
    """Return the processor time of the first of two processes in `WATCHED` seconds, over the second's."""
    before = [sum(process.cpu_times()[:2]) for process in processes]
    time.sleep(WATCHED)
    service, peer = (
        sum(process.cpu_times()[:2]) - start for process, start in zip(processes, before, strict=True)
    )
    return float(service / peer)


def test_an_idle_service_takes_hardly_any_processor_time(tmp_path: Path) -> None:
    port = free_port()
    asking = [sys.executable, "-c", PEER, str(tmp_path / "peer.db")]
    with running("serve", "--port", str(port), data=tmp_path) as service, Lab(port) as lab:
        lab.wait_until_up()
        connection = http.client.HTTPConnection("127.0.0.1", port)
        connection.request("GET", "/v1/health")
        connection.getresponse().read()
        connection.auto_open = 0
        with subprocess.Popen(asking) as peer, ExitStack() as ending:
            ending.callback(peer.kill)
            time.sleep(JOB.attentive + 1.0)
            processes = psutil.Process(service.pid), psutil.Process(peer.pid)
            ratios = [_ratio_of_times(processes)]
            connection.request("GET", "/v1/health")  # 13 s later, on the same connection: httpx waits for 5 s
            assert connection.getresponse().status == 200
            connection.close()
            while ratios[-1] >= MOST and len(ratios) < SPELLS:
                ratios.append(_ratio_of_times(processes))
    assert ratios[-1] < MOST, ratios
