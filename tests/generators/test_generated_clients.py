"""Clients that others generate from the OpenAPI document: complete, without a warning, and working."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.serving import Lab, free_port, running

HERE = Path(__file__).parent
DOCUMENT = HERE.parents[1] / "docs" / "openapi.json"
GENERATOR = "openapi-python-client==0.29.1"


@pytest.fixture(scope="module")
def document() -> Any:
    """The OpenAPI document that is checked in; `tests/service/api` holds it equal to the service's."""
    return json.loads(DOCUMENT.read_text(encoding="utf-8"))


def operation_count(document: Any) -> int:
    """Return the number of operations."""
    return sum(len(methods) for methods in document["paths"].values())


def run(*command: Any, folder: Path) -> "subprocess.CompletedProcess[str]":
    """Return a command that has ended, its output as text."""
    return subprocess.run(
        [str(part) for part in command], cwd=folder, capture_output=True, text=True, check=False, timeout=300
    )


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of an environment with the generator, whose packages are older than the service's."""
    folder = tmp_path_factory.mktemp("environment")
    interpreter = folder / "venv" / "bin" / "python"
    if uv := shutil.which("uv"):
        made = run(uv, "venv", "--quiet", "--python", sys.executable, folder / "venv", folder=folder)
        made = run(uv, "pip", "install", "--quiet", "--python", interpreter, GENERATOR, folder=folder)
    else:
        made = run(sys.executable, "-m", "venv", folder / "venv", folder=folder)
        made = run(interpreter, "-m", "pip", "install", "--quiet", GENERATOR, folder=folder)
    if made.returncode != 0:
        pytest.skip(f"{GENERATOR} cannot be installed here: {made.stderr[-500:]}")
    return interpreter


@pytest.fixture(scope="module")
def generated(python: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Folder of the generated Python package, and what the generator said."""
    folder = tmp_path_factory.mktemp("client")
    (folder / "config.yml").write_text("package_name_override: lab_client\npost_hooks: []\n")
    made = run(
        python.with_name("openapi-python-client"),
        *("generate", "--path", DOCUMENT, "--config", "config.yml"),
        *("--meta", "none", "--output-path", folder / "lab_client"),
        folder=folder,
    )
    assert made.returncode == 0, made.stdout + made.stderr
    return folder, made.stdout + made.stderr


def test_the_python_client_is_generated_whole_and_without_a_warning(
    document: Any, generated: tuple[Path, str]
) -> None:
    folder, words = generated
    assert "warning" not in words.lower(), words
    package = folder / "lab_client"
    operations = [path for path in package.glob("api/*/*.py") if path.name != "__init__.py"]
    assert len(operations) == operation_count(document)
    exported = (package / "models" / "__init__.py").read_text()
    schemas = {
        name
        for name, schema in document["components"]["schemas"].items()
        if "properties" in schema or "enum" in schema
    }
    assert {name for name in schemas if not re.search(rf"\b{name}\b", exported)} == set()


def test_the_python_client_measures_and_extracts(
    python: Path, generated: tuple[Path, str], tmp_path: Path
) -> None:
    port = free_port()
    with running("serve", "--port", str(port), data=tmp_path), Lab(port) as lab:
        lab.wait_until_up()
        script = run(python, HERE / "script.py", generated[0], f"http://127.0.0.1:{port}", folder=tmp_path)
    assert script.returncode == 0, script.stderr
    assert script.stdout.split() == ["5", "not_found"]


def test_the_typescript_client_is_generated_whole_and_compiles(document: Any, tmp_path: Path) -> None:
    npm, npx = shutil.which("npm"), shutil.which("npx")
    if npm is None or npx is None:
        pytest.skip("npm is not installed: the TypeScript client is not generated")
    shutil.copy(HERE / "package.json", tmp_path)
    made = run(npm, "install", "--no-audit", "--no-fund", "--silent", folder=tmp_path)
    if made.returncode != 0:
        pytest.skip(f"npm cannot install the generator here: {made.stderr[-500:]}")
    made = run(npx, "openapi-typescript", DOCUMENT, "-o", "api.ts", folder=tmp_path)
    words = made.stdout + made.stderr.replace("npm warn", "")
    assert made.returncode == 0, words
    assert "warn" not in words.lower(), words
    text = (tmp_path / "api.ts").read_text()
    operations = text[text.index("export interface operations {") :]
    assert len(re.findall(r"^    \w+: \{$", operations, re.MULTILINE)) == operation_count(document)
    schemas = text[text.index("    schemas: {") : text.index("    responses: never;")]
    listed = set(re.findall(r"^        (\w+):", schemas, re.MULTILINE))
    assert listed == set(document["components"]["schemas"])
    compiled = run(npx, "tsc", "--strict", "--noEmit", "api.ts", folder=tmp_path)
    assert compiled.returncode == 0, compiled.stdout
