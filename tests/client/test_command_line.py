"""What the command line refuses before any work, and how it reads flags."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, TypedDict

import click
import pytest
from click.testing import CliRunner, Result

from modallab_cli.app import app
from modallab_cli.keywords import keywords_of, with_keywords
from modallab_cli.lab import structure_of
from modallab_client import ModalLab
from modallab_client.errors import InvalidInputError
from modallab_client.options import ExtractionOptions, MeasurementOptions, UpdateOptions


@pytest.fixture(autouse=True)
def no_lab(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no command come as far as to start a lab."""
    monkeypatch.setattr(ModalLab, "embedded", lambda: pytest.fail("the work began"))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory with a model, a log book and FRFs."""
    for name in ("model.json", "rig.json", "test.uff"):
        (tmp_path / name).write_text("{}", encoding="utf-8")
    (tmp_path / "folder.png").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(line: str) -> Result:
    return CliRunner().invoke(app, line.split())


MEASURE = "measure --model model.json --rig rig.json"
DIAGNOSE = "diagnose --model model.json --measured test.uff --rig rig.json"


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("line", "words"),
    [
        (f"{MEASURE} --out test.doc", "--out test.doc: the ending is none of .uff"),
        (f"{MEASURE} --out away/test.uff", "--out away/test.uff: there is no folder"),
        (f"{MEASURE} --out a.uff --plot a.gif", "--plot a.gif: the ending is none of .png, .svg, .pdf"),
        ("extract test.uff --out modes.csv", "the ending is none of .uff, .unv, .json"),
        ("extract test.uff --plot folder.png", "--plot folder.png is a folder"),
        ("update --model model.json --modes test.uff --out a.uff", "the ending is none of .json"),
        ("update --model model.json", "either --modes or --measured"),
        ("update --model model.json --modes test.uff --macros [1,", "--macros: not JSON: [1,"),
        (f"{DIAGNOSE} --report away/report.html", "--report away/report.html: there is no folder"),
        (f"{DIAGNOSE} --report report.pdf", "the ending is none of .html"),
        ("convert test.uff away/test.npz", "there is no folder"),
        ("convert test.uff a.npz --map nose", "--map nose: not of the form name=value"),
        ("convert test.uff a.npz --scale big", "--scale big: a number is needed"),
        ("plot test.uff a.txt", "the picture a.txt: the ending is none of .png"),
        ("openapi --out away/openapi.json", "there is no folder"),
        ("export project.tar --server http://localhost:1", "the ending is none of .zip"),
        ("body rig r1 --out rig.yaml --server http://localhost:1", "the ending is none of .json"),
    ],
)
def test_what_cannot_be_written_or_read_is_refused_before_the_work(line: str, words: str) -> None:
    done = run(line)
    assert done.exit_code == 2, done.output
    (said,) = done.stderr.splitlines()
    assert said.startswith(f"modallab {line.split()[0]}: ")
    assert words in said
    assert done.stdout == ""


@pytest.mark.usefixtures("folder")
def test_a_picture_without_matplotlib_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    done = run("plot test.uff a.png")
    assert done.exit_code == 2
    assert done.stderr == "modallab plot: a picture needs matplotlib: pip install 'modallab[plot]'\n"


@pytest.mark.usefixtures("folder")
def test_a_band_that_is_none_is_a_wrong_flag() -> None:
    done = run("extract test.uff --band 20-30")
    assert done.exit_code == 2
    assert "'20-30' is not lower:upper" in done.stderr


def test_a_model_that_is_no_json_object_is_named(folder: Path) -> None:
    nowhere = ModalLab("http://localhost:1")
    for text, words in (("[1]", "a JSON object is needed"), ("{", "not JSON")):
        (folder / "model.json").write_text(text, encoding="utf-8")
        with pytest.raises(InvalidInputError, match=rf"^model\.json: {words}"):
            structure_of(nowhere, folder / "model.json", None)


@pytest.mark.parametrize(
    ("command", "keywords"),
    [("measure", MeasurementOptions), ("extract", ExtractionOptions), ("update", UpdateOptions)],
)
def test_the_options_of_the_request_are_flags_with_their_meaning(command: str, keywords: Any) -> None:
    flags = {parameter.name: parameter for parameter in app.commands[command].params}
    for name, hint in keywords.__annotations__.items():
        flag = flags[name]
        assert isinstance(flag, click.Option)
        assert flag.help is not None
        assert flag.help.startswith(hint.__metadata__[0])


class Keywords(TypedDict, total=False):
    """Keywords of every type."""

    count: Annotated[int | None, "a number"]
    level: Annotated[float, "a level"]
    exact: Annotated[bool, "yes or no"]
    names: Annotated[Sequence[str] | str, "names"]
    parts: Annotated[Sequence[dict[str, Any]], "objects"]


def test_flags_become_keywords_of_their_types() -> None:
    given: dict[str, Any] = {}

    @click.command()
    @with_keywords(Keywords, without=("parts",))
    def command(**flags: Any) -> None:
        given.update(keywords_of(Keywords, flags))

    line = "--count 3 --level 0.5 --no-exact --name a --names b"
    assert CliRunner().invoke(command, line.split()).exit_code == 0
    assert given == {"count": 3, "level": 0.5, "exact": False, "names": ("a", "b")}
    given.clear()
    assert CliRunner().invoke(command, []).exit_code == 0
    assert given == {}, "what is left out is the service's to choose"


def test_flags_that_are_json_are_read_or_refused_by_name() -> None:
    assert keywords_of(MeasurementOptions, {"effects": ('{"kind": "drift"}',)}) == {
        "effects": [{"kind": "drift"}]
    }
    assert keywords_of(UpdateOptions, {"completion": "guyan"}) == {"completion": "guyan"}
    assert keywords_of(UpdateOptions, {"completion": '{"kind": "irs"}'}) == {"completion": {"kind": "irs"}}
    with pytest.raises(InvalidInputError, match="--effects: not JSON"):
        keywords_of(MeasurementOptions, {"effects": ("drift",)})
