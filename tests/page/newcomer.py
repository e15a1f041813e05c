"""A newcomer's first minutes, timed: clone, `make demo`, `make serve`, then the page up to a diagnosis.

    python -m tests.page.newcomer [--pictures FOLDER]

The clone is a new folder with an environment of its own, which pip fills; the browser is driven by node and
the packages of `service/page` in this clone. Prints the seconds of each step, and exits with 1 if one fails
or all together take more than ten minutes.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.serving import Lab, free_port

ROOT = Path(__file__).parents[2]
MOST = 600.0  # s, of the whole way with the set-up
STEPS = ("open", "measure", "extract", "diagnose")


def seconds(command: list[str], folder: Path, environment: dict[str, str]) -> float:
    """Return the time that a command takes, s; `CalledProcessError` if it fails."""
    begin = time.monotonic()
    subprocess.run(command, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - begin


@contextmanager
def serving(clone: Path, environment: dict[str, str]) -> Iterator[None]:
    """Run `make serve`, and end it with all that it has started."""
    service = subprocess.Popen(
        ["make", "serve"],
        cwd=clone,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        yield
    finally:
        os.killpg(service.pid, signal.SIGTERM)
        service.wait()


def walked(address: str, pictures: str) -> dict[str, Any]:
    """Return what the browser says of each step on the page."""
    node, chromium = shutil.which("node"), shutil.which("chromium") or shutil.which("chromium-browser")
    assert node is not None, "node is not installed"
    assert chromium is not None, "chromium is not installed"
    done = subprocess.run(
        [node, "e2e/newcomer.mjs", address, pictures],
        cwd=ROOT / "service" / "page",
        env=os.environ | {"CHROMIUM": chromium},
        capture_output=True,
        text=True,
    )
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert lines, done.stderr
    return {line["name"]: line for line in lines}


def first_minutes(folder: Path, pictures: str = "") -> Iterator[tuple[str, float, str]]:
    """Yield each step, the seconds that it took, and its fault or what it found."""
    port, clone = free_port(), folder / "modallab"
    clean = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    environment = clean | {"MODALLAB_PORT": str(port), "MODALLAB_DATA": str(folder / "data")}
    yield "clone", seconds(["git", "clone", "--quiet", str(ROOT), str(clone)], folder, environment), ""
    yield "make demo", seconds(["make", "demo"], clone, environment), "with the set-up"
    with serving(clone, environment), Lab(port) as lab:
        yield "make serve", lab.wait_until_up(), ""
        steps = walked(f"http://127.0.0.1:{port}", pictures)
    for name in STEPS:
        step = steps.get(name, {"fault": "not reached"})
        found = step.get("verdict") or (f"{step['modes']} modes" if "modes" in step else "")
        yield name, step.get("seconds", float("nan")), f"FAULT: {step['fault']}" if "fault" in step else found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--pictures", default="", help="folder for a picture of a step that fails")
    arguments = parser.parse_args()
    begin, total, faults, load = time.monotonic(), 0.0, 0, os.getloadavg()[0]
    with tempfile.TemporaryDirectory(prefix="newcomer-") as folder:
        for name, took, words in first_minutes(Path(folder), arguments.pictures):
            print(f"{name:12} {took:7.1f} s  {words}", flush=True)
            total = time.monotonic() - begin  # with what lies between the steps, as the start of the browser
            faults += words.startswith("FAULT")
    print(f"load before: {load:.1f} on {os.cpu_count()} cores")
    print(f"{'together':12} {total:7.1f} s  {faults} errors; at most {MOST:g} s")
    sys.exit(1 if faults or not total <= MOST else 0)


if __name__ == "__main__":
    main()
