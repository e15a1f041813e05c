"""The lecturer's guide: its lines give every student a key that works."""

import csv
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from modallab_client import ModalLab
from tests.serving import free_port

GUIDE = Path(__file__).parents[2] / "docs" / "keys.md"
LINES = re.search(r"```bash\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)
# The guide's reader sees the service say that it is up.
WAIT = "until curl -sf http://127.0.0.1:$MODALLAB_PORT/v1/health > /dev/null; do sleep 0.2; done\n"


@pytest.mark.skipif(
    shutil.which("curl") is None or shutil.which("bash") is None, reason="needs curl and bash"
)
def test_ten_lines_make_a_class(tmp_path: Path) -> None:
    assert LINES is not None
    lines = LINES[1].splitlines()
    assert len(lines) == 10
    port = free_port()
    (tmp_path / "students.csv").write_text("name\nFirst Student\nSecond Student\n", encoding="utf-8")
    script = LINES[1].replace(":8000", f":{port}").replace("&  ", f"&\nservice=$!\n{WAIT}")
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MODALLAB_")}
    environment |= {"HOME": str(tmp_path), "MODALLAB_PORT": str(port)}
    environment["PATH"] = f"{Path(sys.executable).parent}:{environment['PATH']}"
    shell = subprocess.Popen(
        ["bash", "-ec", f"trap 'kill $service' EXIT\n{script}\necho\necho ready\nread answer"],
        cwd=tmp_path,
        env=environment,
        text=True,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    assert shell.stdout is not None
    said = list(iter(shell.stdout.readline, "ready\n"))
    try:
        assert "Second Student" in "".join(said)
        rows = list(csv.DictReader((tmp_path / "keys.csv").read_text(encoding="utf-8").splitlines()))
        assert [row["name"] for row in rows] == ["First Student", "Second Student"]
        for row in rows:
            with ModalLab(f"http://127.0.0.1:{port}", api_key=row["key"]) as lab:
                assert lab.request("GET", "/v1/sessions")["id"] == row["id"]
                lab.structures.catalogue("bay")
                assert len(lab.request("GET", "/v1/structures")["items"]) == 1
    finally:
        shell.communicate("\n", timeout=30)  # closes the pipes, too
