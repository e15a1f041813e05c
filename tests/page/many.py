"""How fast the page draws 500 FRFs of 3,201 lines: ten seconds of zooming and moving, at 1280 x 800.

    python -m tests.page.many [--frfs 500] [--lines 3201]

The FRFs are of ten modes with random shapes, one of them with a line that stands high above all. Prints the
time to the first plot, the 95th percentile of the time between two frames and from an input to what it draws,
and how many rows of pixels the line stands out; exits with 1 if a figure is over its limit or the line is not
drawn.
"""

import argparse
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from tests.serving import Lab, free_port, running

ROOT = Path(__file__).parents[2]
HIGHEST = 800.0  # Hz
FRAME_LIMIT, ANSWER_LIMIT = 33.0, 100.0  # ms
LEAST_ROWS, MOST_BESIDE = 30, 5  # of pixels, of about 100 in the upper third of the plot


def frfs(n_frfs: int, n_lines: int, spike: int) -> bytes:
    """Return inertances as npz; the line `spike` of one of them is ten times the highest of all."""
    rng = np.random.default_rng(5)
    freq = np.linspace(0.0, HIGHEST, n_lines)
    natural = np.linspace(0.07, 0.93, 10) * HIGHEST
    constants = rng.standard_normal((10, n_frfs))
    modes = -(freq[:, None] ** 2) / (natural**2 * (1 + 0.01j) - freq[:, None] ** 2)
    values = modes @ constants
    values[spike, n_frfs // 2] = 10 * np.abs(values).max()
    outputs = np.array([f"{n + 1}:+Z" for n in range(n_frfs)])
    file = io.BytesIO()
    np.savez(file, freq=freq, values=values[:, :, None], outputs=outputs, inputs=np.array(["1:+Z"]))
    return file.getvalue()


def figures(n_frfs: int, n_lines: int) -> dict[str, float]:
    """Return what the browser says, ms and rows of pixels."""
    node, chromium = shutil.which("node"), shutil.which("chromium") or shutil.which("chromium-browser")
    assert node is not None, "node is not installed"
    assert chromium is not None, "chromium is not installed"
    port, spike = free_port(), round(0.385 * (n_lines - 1))
    with (
        tempfile.TemporaryDirectory() as data,
        running("serve", "--port", str(port), data=Path(data)),
        Lab(port) as lab,
    ):
        lab.wait_until_up()
        file = {"file": ("many.npz", frfs(n_frfs, n_lines, spike))}
        made = lab.request("POST", "/measurements/import", files=file)
        assert made.is_success, made.text
        command = [
            node,
            "e2e/many.mjs",
            f"http://127.0.0.1:{port}",
            made.json()["id"],
            str(spike / (n_lines - 1)),
        ]
        done = subprocess.run(
            command,
            cwd=ROOT / "service" / "page",
            env=os.environ | {"CHROMIUM": chromium},
            capture_output=True,
            text=True,
        )
    assert done.returncode == 0, done.stderr
    found: dict[str, float] = json.loads(done.stdout)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--frfs", type=int, default=500)
    parser.add_argument("--lines", type=int, default=3201)
    arguments = parser.parse_args()
    load = os.getloadavg()[0]
    found = figures(arguments.frfs, arguments.lines)
    print(f"load before: {load:.1f} on {os.cpu_count()} cores")
    print(json.dumps(found))
    good = found["frameP95"] <= FRAME_LIMIT and found["answerP95"] <= ANSWER_LIMIT
    sys.exit(0 if good and found["spike"] >= LEAST_ROWS and found["beside"] <= MOST_BESIDE else 1)


if __name__ == "__main__":
    main()
