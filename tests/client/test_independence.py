"""The client alone: no package of the service, and no matplotlib, is needed to use it."""

import subprocess
import sys

BLOCKED = "modallab fastapi starlette pydantic scipy sqlalchemy dbos alembic uvicorn matplotlib"
SCRIPT = """
import sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in sys.argv[1:]:
            raise ImportError(f"{name} is not for the client")

sys.meta_path.insert(0, Refuse())
from modallab_client import ModalLab, results
with ModalLab("http://localhost:1"):
    pass
try:
    results.Measurement.plot(None)
except ImportError as error:
    print(type(error).__name__, error)
assert not set(sys.argv[1:]) & set(sys.modules)
"""


def test_the_client_imports_and_names_the_extra_for_plots() -> None:
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT, *BLOCKED.split()], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith("MissingExtraError")
    assert "pip install 'modallab[plot]'" in run.stdout
