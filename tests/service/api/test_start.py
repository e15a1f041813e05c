"""Start of the service: what no request has asked for yet is not imported."""

import subprocess
import sys

# libraries of single file formats, and parts of scipy that take longest
LATER = "h5py meshio pyuff matplotlib scipy.io scipy.signal scipy.stats"


def test_the_service_starts_without_the_libraries_of_single_requests() -> None:
    script = "import sys, modallab.api.app; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert not set(LATER.split()) & set(run.stdout.split())
