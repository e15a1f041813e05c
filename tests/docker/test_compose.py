"""The compose files: what they start exists, what they set is a setting, and every container is limited."""

import re
from typing import Any

import click
import pytest
import yaml

from modallab.api.settings import ServiceSettings
from modallab_cli.app import app
from tests.docker.image import DOCKERFILE, ROOT, instructions

FILES = ("compose.yaml", "compose.scaled.yaml")
NOT_OURS = {"PYTHON_CPU_COUNT", "POSTGRES_USER", "POSTGRES_DB", "POSTGRES_PASSWORD"}
UNITS = {"m": 1e6, "g": 1e9}
# docs/running.md: of the service, and the most of a process that answers a heavy request
SERVICE, HEAVY = 160e6, 900e6


def composed(name: str) -> dict[str, Any]:
    """Return a compose file, its variables set."""
    text = (ROOT / "docker" / name).read_text()
    document: dict[str, Any] = yaml.safe_load(re.sub(r"\$\{\w+:\?[^}]*\}", "secret", text))
    return document


def services(name: str) -> dict[str, Any]:
    found: dict[str, Any] = composed(name)["services"]
    return found


def size(text: str) -> float:
    return float(text[:-1]) * UNITS[text[-1]]


OF_FILES = [(name, service) for name in FILES for service in services(name)]
OURS = [(name, service) for name, service in OF_FILES if service != "database"]


@pytest.mark.parametrize(("name", "service"), OURS)
def test_commands_and_variables_are_the_programs_own(name: str, service: str) -> None:
    about = services(name)[service]
    default = next(words for name, words in instructions(DOCKERFILE.read_text()) if name == "CMD")
    program, *words = about.get("command", yaml.safe_load(default))
    assert program == "modallab"
    with click.Context(app) as context:
        _, command, arguments = app.resolve_command(context, words)
        assert command is not None
        command.make_context(command.name, arguments)  # refuses what it has not
    values = {
        key.removeprefix("MODALLAB_").lower(): value
        for key, value in about["environment"].items()
        if key not in NOT_OURS
    }
    assert set(values) <= set(ServiceSettings.model_fields)
    ServiceSettings(**values)


@pytest.mark.parametrize(("name", "service"), OF_FILES)
def test_every_container_is_limited(name: str, service: str) -> None:
    limits = services(name)[service]["deploy"]["resources"]["limits"]
    assert float(limits["cpus"]) <= 4
    assert size(limits["memory"]) <= 6e9
    assert limits["pids"] <= 500


@pytest.mark.parametrize(("name", "service"), OURS)
def test_a_container_has_room_for_its_processes_and_files(name: str, service: str) -> None:
    about = services(name)[service]
    assert about["read_only"]
    (tmpfs,) = about["tmpfs"]
    files = size(tmpfs.partition("size=")[2])
    memory = size(about["deploy"]["resources"]["limits"]["memory"])
    n_heavy = int(about["environment"].get("PYTHON_CPU_COUNT", 1)) - 1  # as the service counts them
    assert memory >= SERVICE + n_heavy * HEAVY + files


def test_a_scaled_service_waits_for_its_tables_and_shares_its_folder() -> None:
    document = composed("compose.scaled.yaml")
    of = document["services"]
    assert of["init"]["depends_on"] == {"database": {"condition": "service_healthy"}}
    for name in ("api", "worker"):
        assert of[name]["depends_on"] == {"init": {"condition": "service_completed_successfully"}}
        assert of[name]["deploy"]["replicas"] >= 2
        assert of[name]["volumes"] == ["data:/data"]
    assert set(document["volumes"]) == {"database", "data"}


def test_the_base_image_is_named_by_its_digest() -> None:
    (base,) = [words for name, words in instructions(DOCKERFILE.read_text()) if name == "ARG"]
    assert re.fullmatch(r"BASE=docker\.io/library/python:3\.13-slim-trixie@sha256:[0-9a-f]{64}", base)
    froms = [words for name, words in instructions(DOCKERFILE.read_text()) if name == "FROM"]
    assert {words.partition(" ")[0] for words in froms} == {"${BASE}"}
