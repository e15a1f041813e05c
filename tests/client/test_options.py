"""The client's keywords are the service's options."""

import subprocess
import sys
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "client" / "generate_options.py"


def test_the_keywords_are_those_that_the_options_of_the_methods_give() -> None:
    code = "import generate_options as g; print(g.TARGET.read_text() == g.generated())"
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=SCRIPT.parent, capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "True", "run `make sync-client`"
