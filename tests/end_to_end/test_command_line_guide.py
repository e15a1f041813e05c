"""What docs/command-line.md tells to type, in a folder without a service."""

import json
import os
import re
import resource
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from modallab_client import ModalLab
from tests.serving import Lab, free_port, running

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "command-line.md").read_text(encoding="utf-8")
FILES = re.findall(r"`(\w+\.json)`:\n\n```json\n(.*?)^```", TEXT, flags=re.DOTALL | re.MULTILINE)
LONGEST = 60.0  # s of processor time, of a command: a busy machine is no fault of it
PICTURE = 10_000  # bytes, of a picture with curves; an empty one has 5,000


def commands(first: str) -> list[str]:
    """Return the commands of the code block that begins with this one, a line each."""
    blocks = re.findall(r"^```bash\n(.*?)^```", TEXT, flags=re.DOTALL | re.MULTILINE)
    (block,) = [text for text in blocks if text.startswith(first)]
    return str(block).replace("\\\n", " ").splitlines()


def run(command: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    """Return what a command did; it runs with this environment's Python first in the path."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", command],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=10 * LONGEST,
    )
    assert done.returncode == 0, done.stderr
    return done


def processor_time() -> float:
    """Return the processor time of the commands that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files of the hammer test, the model and the log book."""
    place = tmp_path_factory.mktemp("hammer")
    (command,) = commands("python -m docs.own_data")
    run(command, place)
    for name, text in FILES:
        (place / name).write_text(text, encoding="utf-8")
    return place


def test_five_commands_lead_from_the_files_of_a_hammer_test_to_a_report(folder: Path) -> None:
    printed = {}
    for command in commands("modallab convert"):
        begin = processor_time()
        name = shlex.split(command)[1]
        printed[name] = run(command, folder).stdout
        assert processor_time() - begin < LONGEST, name
        (picture,) = re.findall(r"\w+\.png", command)
        assert (folder / picture).stat().st_size > PICTURE, name
    assert list(printed) == ["convert", "plot", "extract", "update", "diagnose"]
    assert "1 responses x 11 forces, 1141 lines from 15 to 300 Hz" in printed["convert"]
    assert "4 modes from 26.77 to 247.6 Hz by lscf" in printed["extract"]
    factor = re.search(r"Corrected: stiffness of 6 (0\.\d+)\(", printed["update"])
    assert factor is not None, printed["update"]
    assert abs(float(factor[1]) - 0.7) < 0.005  # five standard errors
    assert "Missing effect: stiffness error at member 6." in printed["diagnose"]
    report = (folder / "report.html").read_text(encoding="utf-8")
    assert "Boom, first test" in report
    assert "Object: Boom of 1.5 m with clamp" in report


def test_a_measurement_needs_no_laboratory(folder: Path) -> None:
    (command,) = commands("modallab measure")
    done = run(command, folder)
    assert done.stdout.startswith("hidden.uff: inertance of 1 response and 11 forces")
    assert "100%" in done.stderr
    assert (folder / "hidden.png").stat().st_size > PICTURE


def test_what_a_lab_keeps_is_listed_restored_read_back_and_removed(tmp_path: Path) -> None:
    printed = commands("modallab trash list")
    assert [shlex.split(command)[1:3] for command in printed] == [
        ["trash", "list"],
        ["trash", "restore"],
        ["body", "structure"],
        ["trash", "remove"],
    ]
    port = free_port()
    with running("serve", "--port", str(port), data=tmp_path), Lab(port) as waiting:
        waiting.wait_until_up()
        with ModalLab(f"http://127.0.0.1:{port}") as lab:
            beam = lab.structures.create(**json.loads(dict(FILES)["boom.json"]))
            listed, restored, described, removed = [
                command.replace(":8000", f":{port}").replace(" ID ", f" {beam.id} ") for command in printed
            ]
            assert run(listed, tmp_path).stdout == ""
            lab.structures.delete(beam)
            (line,) = run(listed, tmp_path).stdout.splitlines()
            assert line.split()[:2] == [beam.id, "structure"]
            run(restored, tmp_path)
            assert lab.structures.get(beam.id).id == beam.id
            run(described, tmp_path)
            again = json.loads((tmp_path / "again.json").read_text(encoding="utf-8"))
            assert again == json.loads(dict(FILES)["boom.json"])
            assert lab.structures.create(**again).n_dofs == beam.n_dofs
            lab.structures.delete(beam)
            run(removed, tmp_path)
            assert lab.trash.list() == ()
        with pytest.raises(AssertionError, match=r"^modallab trash restore: there is no '\w+' in the trash"):
            run(restored, tmp_path)


def test_what_one_has_in_a_lab_goes_through_a_file(tmp_path: Path) -> None:
    port = free_port()
    with running("serve", "--port", str(port), data=tmp_path), Lab(port) as waiting:
        waiting.wait_until_up()
        export, imported = (command.replace(":8000", f":{port}") for command in commands("modallab export"))
        with ModalLab(f"http://127.0.0.1:{port}") as lab:
            beam = lab.structures.create(**json.loads(dict(FILES)["boom.json"]))
            lab.structures.describe(beam, name="boom", labels=["autumn"])
            assert run(export, tmp_path).stdout == "project.zip: 1 structure\n"
            assert run(imported, tmp_path).stdout == "project.zip: 1 structure\n"
            again, _ = lab.structures.list(name="boom", label="autumn")
            assert again.id != beam.id
            assert (
                lab.structures.modes(again).frequencies.tolist()
                == lab.structures.modes(beam).frequencies.tolist()
            )
            assert run(f"{export} --label spring", tmp_path).stdout == "project.zip: nothing\n"
        (tmp_path / "project.zip").write_bytes(b"PK")
        with pytest.raises(AssertionError, match=r"^modallab import: the file is damaged"):
            run(imported, tmp_path)


def test_the_files_of_the_guide_are_named() -> None:
    assert [name for name, _ in FILES] == ["boom.json", "hammer.json"]
