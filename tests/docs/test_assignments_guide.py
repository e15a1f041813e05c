"""The guide of assignments: its lines set one, work on it and list the marks."""

import os
import re
import subprocess
import sys
from pathlib import Path

from modallab.jobs.sealing import SEALING
from modallab_client import ModalLab
from tests.serving import Lab, free_port, running

GUIDE = (Path(__file__).parents[2] / "docs" / "assignments.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", GUIDE, re.DOTALL)


def key_of(data: Path, role: str) -> str:
    """Return a new key of a role, made by the command."""
    command = [sys.executable, "-m", "modallab", "keys", "create", "--role", role, "--name", role]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MODALLAB_")}
    environment["MODALLAB_DATA"] = str(data)
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.strip()


def test_the_lines_of_the_guide_run_as_they_stand(tmp_path: Path) -> None:
    key_of(tmp_path, "admin")
    lecturer, port = key_of(tmp_path, "instructor"), free_port()
    url = f"http://127.0.0.1:{port}"
    with running("serve", "--port", str(port), data=tmp_path):
        with Lab(port) as probe:
            probe.wait_until_up()
        with ModalLab(url, api_key=lecturer) as lab:
            course = lab.classes.create("Dynamics")
            (member,) = lab.classes.add_members(course, ["First Student"])
            assert [key.name for key in lab.keys.list()] == ["First Student", "instructor"]
        names = {"URL": url, "LECTURER": lecturer, "STUDENT": member.key, "CLASS": course.id}
        run = subprocess.run(
            [sys.executable, "-c", "\n".join(BLOCKS)],
            cwd=tmp_path,
            env=os.environ | names,
            capture_output=True,
            text=True,
            check=False,
            timeout=120,
        )
        assert run.returncode == 0, run.stderr
        lines = run.stdout.splitlines()
        assert any(line.startswith("kind 2.0 2.0 extra_mass at 11:+Y: the kind is right.") for line in lines)
        assert lines[-1].split()[:3] == ["First", "Student", "1"]
        with ModalLab(url, api_key=member.key) as lab:
            (assignment,) = lab.assignments.list()
            assert lab.assignments.get(assignment) == assignment
            assert assignment.hidden is None
            assert assignment.rubric.words == 5
            (row,) = lab.assignments.marks(assignment)
            assert row.submission == assignment.submission
        with ModalLab(url, api_key=lecturer) as lab:
            roll = lab.classes.get(course)
            assert roll.shares == (assignment.structure_id,)
            lab.assignments.close(assignment)
            assert lab.assignments.list() == ()


def test_the_guide_states_the_step_of_durations() -> None:
    assert f"steps of {SEALING.step:g} s" in GUIDE
    assert SEALING.spare == 2  # "at least twice"
