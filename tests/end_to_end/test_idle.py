"""A service that nobody uses costs next to nothing, and stays connected."""

import http.client
import time
from pathlib import Path

import psutil

from modallab.jobs.settings import JOB
from tests.serving import Lab, free_port, running

WATCHED = 10.0  # s: more than one reconciliation of an idle service
# 0.9 % of a core by itself; the clock of processor time has steps of 0.01 s, and two reconciliations more or
# less fall into ten seconds.
MOST = 0.02
# Work beside it on the same core makes caches cold, so that the same steps take longer: one of these spells
# has to be undisturbed. What the service does every few seconds it does in each.
SPELLS = 4


def _share_of_a_core(process: psutil.Process) -> float:
    """Return the processor time of a process in `WATCHED` seconds, over these."""
    before = process.cpu_times()
    time.sleep(WATCHED)
    after = process.cpu_times()
    return (after.user + after.system - before.user - before.system) / WATCHED


def test_an_idle_service_takes_hardly_any_processor_time(tmp_path: Path) -> None:
    port = free_port()
    with running("serve", "--port", str(port), data=tmp_path) as service, Lab(port) as lab:
        lab.wait_until_up()
        connection = http.client.HTTPConnection("127.0.0.1", port)
        connection.request("GET", "/v1/health")
        connection.getresponse().read()
        connection.auto_open = 0
        time.sleep(JOB.attentive + 1.0)
        process = psutil.Process(service.pid)
        shares = [_share_of_a_core(process)]
        connection.request("GET", "/v1/health")  # 13 s later, on the same connection: httpx waits for 5 s
        assert connection.getresponse().status == 200
        connection.close()
        while shares[-1] >= MOST and len(shares) < SPELLS:
            shares.append(_share_of_a_core(process))
    assert shares[-1] < MOST, shares
