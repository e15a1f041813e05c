"""A service in a process of its own, for tests that stop, kill and start it."""

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

import httpx

START = 180.0  # s, of which a warm machine needs two: a busy one is no fault of the service


def free_port() -> int:
    """Return a port that nothing listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def running(
    *arguments: str,
    data: Path,
    environment: Mapping[str, str] | None = None,
    within: Sequence[str] = (),
) -> Iterator["subprocess.Popen[bytes]"]:
    """Yield `python -m modallab` with these arguments; what is left of it is killed in the end.

    Parameters
    ----------
    within
        Beginning of the command line of a program that starts it in surroundings of its own.
    """
    clean = {name: value for name, value in os.environ.items() if not name.startswith("MODALLAB_")}
    with (data / "log").open("ab") as log:
        process = subprocess.Popen(
            [*within, sys.executable, "-m", "modallab", *arguments, "--data", str(data)],
            env=clean | dict(environment or {}),
            stdout=log,
            stderr=log,
            # Of low priority within their session alone: beside tests that compute, jobs would wait for ever.
            start_new_session=True,
        )
        try:
            yield process
        finally:
            process.kill()
            process.wait()


class Lab:
    """Requests to a service on a port."""

    def __init__(self, port: int, *, host: str = "127.0.0.1") -> None:
        self._http = httpx.Client(base_url=f"http://{host}:{port}/v1", timeout=60)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self._http.close()

    def wait_until_up(self) -> float:
        """Return how long the service took to answer, s."""
        begin = time.monotonic()
        while time.monotonic() - begin < START:
            try:
                self._http.get("/health").raise_for_status()
                return time.monotonic() - begin
            except httpx.TransportError:
                time.sleep(0.05)
        raise TimeoutError("the service did not answer")

    def request(self, method: str, path: str, **options: Any) -> httpx.Response:
        """Return the reply to a request."""
        return self._http.request(method, path, **options)

    def json(self, method: str, path: str, body: Any = None) -> Any:
        """Return the JSON of a good reply; a busy service is asked again, as the client does."""
        begin = time.monotonic()
        reply = self._http.request(method, path, json=body)
        while "/problems/busy" in reply.text and time.monotonic() - begin < START:
            time.sleep(float(reply.headers["Retry-After"]))
            reply = self._http.request(method, path, json=body)
        assert reply.is_success, reply.text
        return reply.json()

    def wait_for(self, job: str, *, state: str, fraction: float = 0.0, timeout: float = 300.0) -> Any:
        """Return a job as soon as it is in this state and that far."""
        begin = time.monotonic()
        while time.monotonic() - begin < timeout:
            job_status = self.json("GET", f"/jobs/{job}")
            if job_status["state"] == state and job_status["fraction"] >= fraction:
                return job_status
            assert job_status["state"] in ("queued", "running"), job_status
            time.sleep(0.05)
        raise TimeoutError(f"job {job} is not {state}: {job_status}")
