"""A service that nobody uses costs next to nothing, and stays connected."""

import http.client
import time
from pathlib import Path

import psutil

from modallab.jobs.settings import JOB
from tests.serving import Lab, free_port, running

WATCHED = 10.0  # s
# 0.9 % of a core on a machine that others keep busy; the clock of processor time has steps of 0.01 s, and
# two reconciliations more or less fall into ten seconds.
MOST = 0.02


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
        before = process.cpu_times()
        time.sleep(WATCHED)
        after = process.cpu_times()
        connection.request("GET", "/v1/health")  # 13 s later, on the same connection: httpx waits for 5 s
        assert connection.getresponse().status == 200
        connection.close()
    assert (after.user + after.system - before.user - before.system) / WATCHED < MOST
