"""What costs much memory or time from little input, sent to a service: what is answered, and how fast.

python -m tests.faults.heavy
python -m tests.faults.heavy --only vtk "one plate of 200 x 200"
"""

import argparse
import io
import itertools
import tempfile
import threading
import time
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import psutil

from tests.serving import Lab, free_port, running

ABAQUS = """*NODE
1, 0., 0., 0.
2, 1., 0., 0.
*ELEMENT, TYPE=B31
1, 1, 2
*NSET, NSET=all, GENERATE
1, 1000000000, 1
"""
VTK = """# vtk DataFile Version 3.0
grid
ASCII
DATASET STRUCTURED_POINTS
DIMENSIONS 500 500 200
ORIGIN 0 0 0
SPACING 1 1 1
"""
GMSH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$Nodes
1 1 268435456 268435456
0 1 0 1
268435456
0 0 0
$EndNodes
$Elements
0 0 0 0
$EndElements
"""
MESH = {"groups": {"all": {"material": {"modulus": 2e11, "density": 7800.0}, "thickness": 0.001}}}
STEEL = {"modulus": 2.09e11, "density": 7800.0}
LIMIT_SECONDS, LIMIT_BYTES, LIMIT_HEALTH = 10.0, 1e9, 0.2
LEAST_HEALTH = 100  # requests that have a 99th percentile
GOOD = (200, 201, 413, 422, 503)  # a right result is best


@dataclass
class Observation:
    """What was seen of a service while something was asked of it."""

    replies: list[tuple[int, str, float]] = field(default_factory=list)
    """Status, code and seconds of each request."""
    health: list[float] = field(default_factory=list)
    """s, times of requests for the health."""
    memory: float = 0.0
    """bytes, resident in the largest process."""

    @property
    def slowest(self) -> float:
        """s, longest time of a request."""
        return max(seconds for _, _, seconds in self.replies)

    @property
    def health_p99(self) -> float:
        """s, 99th percentile of the times of requests for the health."""
        return float(np.quantile(self.health, 0.99))

    @property
    def statuses(self) -> Counter[tuple[int, str]]:
        """How many requests had each status and code."""
        return Counter((status, code) for status, code, _ in self.replies)

    def faults(self, limit_seconds: float = LIMIT_SECONDS) -> list[str]:
        """Return what exceeds a limit, among them the longest time that a request may take (s)."""
        bad = [f"status {status}" for status, _ in self.statuses if status not in GOOD]
        slow = [f"{self.slowest:.1f} s"] if self.slowest > limit_seconds else []
        large = [f"{self.memory / 1e6:.0f} MB"] if self.memory > LIMIT_BYTES else []
        enough = len(self.health) >= LEAST_HEALTH
        late = [f"health {1e3 * self.health_p99:.0f} ms"] if enough and self.health_p99 > LIMIT_HEALTH else []
        return [*bad, *slow, *large, *late]


@contextmanager
def observed(port: int, pid: int) -> Iterator[Observation]:
    """Yield what a service shows until the block ends: its health, and the memory of its processes."""
    seen, ended = Observation(), threading.Event()

    def ask_for_health() -> None:
        with httpx.Client(base_url=f"http://127.0.0.1:{port}/v1", timeout=60) as http:
            while not ended.wait(0.02):
                begin = time.monotonic()
                http.get("/health").raise_for_status()
                seen.health.append(time.monotonic() - begin)

    def look_at_memory() -> None:
        while not ended.wait(0.05):
            with suppress(psutil.NoSuchProcess):
                service = psutil.Process(pid)
                for process in (service, *service.children(recursive=True)):
                    with suppress(psutil.NoSuchProcess):
                        seen.memory = max(seen.memory, float(process.memory_info().rss))

    threads = [threading.Thread(target=look) for look in (ask_for_health, look_at_memory)]
    for thread in threads:
        thread.start()
    try:
        yield seen
    finally:
        ended.set()
        for thread in threads:
            thread.join()


Send = Callable[[], httpx.Response]


def _timed(send: Send) -> tuple[int, str, float]:
    begin = time.monotonic()
    reply = send()
    seconds = time.monotonic() - begin
    told = reply.json() if "json" in reply.headers["content-type"] else {}
    assert reply.status_code != 503 or "retry-after" in reply.headers
    assert reply.status_code != 422 or told["context"].get("field"), told
    return reply.status_code, told.get("code", ""), seconds


def _post_file(lab: Lab, path: str, name: str, content: bytes, **form: str) -> Send:
    return lambda: lab.request("POST", path, files={"file": (name, content)}, data=form)


def _mesh(name: str, text: str) -> Callable[[Lab], list[Send]]:
    mesh = httpx.Response(200, json=MESH).text
    return lambda lab: [_post_file(lab, "/structures/import", name, text.encode(), mesh=mesh)]


def _inflated_npz(lab: Lab) -> list[Send]:
    n = 199_000_000 // 16 // 8
    packed = io.BytesIO()
    np.savez_compressed(packed, freq=np.arange(1.0, n + 1), values=np.zeros((n, 8, 1), complex))
    return 10 * [_post_file(lab, "/measurements/import", "test.npz", packed.getvalue())]


def _grid_cards(lab: Lab) -> list[Send]:
    cards = "".join(f"GRID,{i},,{i % 1000}.,{i // 1000}.,0.\n" for i in range(1, 2_000_001))
    return [_post_file(lab, "/structures/import", "grid.bdf", f"BEGIN BULK\n{cards}ENDDATA\n".encode())]


def _entries(path: str) -> Callable[[Lab], list[Send]]:
    def sends(lab: Lab) -> list[Send]:
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as archive:
            for i in range(400_000):
                archive.writestr(f"{i}", b"")
        return [_post_file(lab, path, "many.zip", packed.getvalue())]

    return sends


def plate(n: int) -> dict[str, Any]:
    """Return the body of a plate with n x n elements."""
    size = {"length": 0.6, "width": 0.4, "thickness": 0.004, "n_elements": [n, n]}
    return {"kind": "plate", **size, "material": STEEL, "edges": {"left": "clamped"}}


def _many_modes(lab: Lab) -> list[Send]:
    id = lab.json("POST", "/structures", plate(60))["id"]
    return 45 * [lambda: lab.request("GET", f"/structures/{id}/modes?count=100")]


def _modes_of_many(lab: Lab) -> list[Send]:
    ids = [lab.json("POST", "/structures", plate(60))["id"] for _ in range(15)]
    return [
        lambda id=id: lab.request("GET", f"/structures/{id}/modes?count=100")  # type: ignore[misc]
        for id in itertools.chain(ids, ids, ids)
    ]


def _large_plate(lab: Lab) -> list[Send]:
    return [lambda: lab.request("POST", "/structures", json=plate(200))]


def _modes_of_large_plate(lab: Lab) -> list[Send]:
    made = lab.request("POST", "/structures", json=plate(200))
    if not made.is_success:  # a slow machine refuses the plate itself
        return [lambda: made]
    return [lambda: lab.request("GET", f"/structures/{made.json()['id']}/modes")]


CASES: dict[str, Callable[[Lab], list[Send]]] = {
    "abaqus": _mesh("mesh.inp", ABAQUS),
    "vtk": _mesh("mesh.vtk", VTK),
    "gmsh": _mesh("mesh.msh", GMSH),
    "ten npz of 199 MB": _inflated_npz,
    "two million GRID cards": _grid_cards,
    "model zip of 400,000 entries": _entries("/structures/import"),
    "test zip of 400,000 entries": _entries("/measurements/import"),
    "45 times the modes of a plate of 60 x 60": _many_modes,
    "45 times the modes of 15 such plates": _modes_of_many,
    "one plate of 200 x 200": _large_plate,
    "modes of a plate of 200 x 200": _modes_of_large_plate,
}


def observe(lab: Lab, port: int, pid: int, case: str) -> Observation:
    """Return what a service showed while all requests of a case came at once."""
    sends = CASES[case](lab)
    with observed(port, pid) as seen, ThreadPoolExecutor(len(sends)) as pool:
        seen.replies += pool.map(_timed, sends)
        time.sleep(0.3)
    return seen


def main() -> None:
    """Send every case and print what was seen."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--only", nargs="*", choices=list(CASES), default=list(CASES))
    options = parser.parse_args()
    port = free_port()
    with (
        tempfile.TemporaryDirectory() as folder,
        running("serve", "--port", str(port), data=Path(folder)) as service,
        Lab(port) as lab,
    ):
        lab.wait_until_up()
        for case in options.only:
            seen = observe(lab, port, service.pid, case)
            told = ", ".join(f"{n} x {status} {code}" for (status, code), n in seen.statuses.items())
            figures = (
                f"{seen.slowest:.1f} s, {seen.memory / 1e6:.0f} MB, health p99 {1e3 * seen.health_p99:.0f} ms"
            )
            print(f"{case}: {told}; {figures}; {', '.join(seen.faults()) or 'good'}", flush=True)


if __name__ == "__main__":
    main()
