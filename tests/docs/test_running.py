"""The guide for whoever runs the service: its commands run, its settings and metrics are those that exist."""

import re
import shlex
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import httpx
from prometheus_client.parser import text_string_to_metric_families

from modallab.api.settings import ServiceSettings
from tests.pages import run_page
from tests.serving import Lab, free_port, running

TEXT = (Path(__file__).parents[2] / "docs" / "running.md").read_text(encoding="utf-8")
COMMANDS = [shlex.split(line, comments=True) for line in TEXT.split("```")[1].strip().splitlines()]


def test_its_commands_make_the_same_lab_again(tmp_path: Path) -> None:
    serve, backup, restore = COMMANDS
    assert [command[1] for command in COMMANDS] == ["serve", "backup", "restore"]
    first, second = tmp_path / serve[-1], tmp_path / restore[-1]
    first.mkdir()
    with ExitStack() as stack:
        labs = []
        for data in (first, second):
            if data == second:
                for command in (backup, restore):
                    run = [sys.executable, "-m", *command]
                    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, timeout=120)
                    assert done.returncode == 0, done.stderr
                    assert "1 jobs, 3 things, 1 links, 1 truths" in done.stdout
            port = free_port()
            stack.enter_context(running("serve", "--port", str(port), data=data))
            lab = stack.enter_context(Lab(port))
            lab.wait_until_up()
            labs.append(lab)
            if data == first:
                beam = lab.json("POST", "/structures", {"kind": "catalogue", "name": "chapter-5-beam"})["id"]
                rig = lab.json("POST", "/rigs", {"drive": "1:+Y", "responses": ["5:+Y", "9:+Y"]})["id"]
                body = {"structure_id": beam, "rig_id": rig, "route": "expected", "seed": 1}
                job = lab.wait_for(lab.json("POST", "/measurements", body)["id"], state="succeeded")
        test = job["result_id"]
        paths = [f"/structures/{beam}", f"/rigs/{rig}", f"/jobs/{job['id']}", "/structures", "/jobs"]
        paths += [f"/measurements/{test}{part}" for part in ("", "/arrays", "/truth", "/log")]
        for path in paths:
            replies = [lab.request("GET", path) for lab in labs]
            assert replies[0].status_code == replies[1].status_code == 200, path
            assert replies[0].content == replies[1].content, path
        scrape = httpx.get(f"http://127.0.0.1:{port}/metrics").text
    families = {family.name for family in text_string_to_metric_families(scrape)}
    named = {name.removesuffix("_total") for name in re.findall(r"`(modallab_\w+)`", TEXT)}
    assert named == {name for name in families if re.match(r"modallab_(?!.*_created$)", name)}


def test_its_settings_are_all_there_are_with_their_defaults() -> None:
    rows = re.findall(r"^\| (`MODALLAB_\w+`(?:, `MODALLAB_\w+`)*) \| ([^|]*)\|", TEXT, flags=re.MULTILINE)
    stated: dict[str, str] = {}
    for names, defaults in rows:
        found = re.findall(r"`(\S+)`", defaults)
        for number, name in enumerate(re.findall(r"`MODALLAB_(\w+)`", names)):
            stated[name.lower()] = found[number] if found else ""
    assert set(stated) == set(ServiceSettings.model_fields)
    for name, field in ServiceSettings.model_fields.items():
        default = "~/.modallab" if name == "data" else "" if field.default is None else field.default
        assert stated[name] == (f"{default:g}" if isinstance(default, float) else str(default)), name


def test_its_python_restores_a_beam_and_takes_one_to_another_lab(tmp_path: Path) -> None:
    run_page("running.md", tmp_path, moved)
    assert (tmp_path / "project.zip").is_file()


def moved(names: dict[str, Any]) -> None:
    """Check what the page's blocks leave behind."""
    assert names["stored"].counts == {"structure": 1}
    discarded, restored, imported = names["__printed__"].splitlines()
    assert "structure" in discarded
    assert imported.endswith(restored)
