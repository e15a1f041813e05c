"""The built page in the package is the one of the sources."""

import hashlib
import json
import subprocess
from pathlib import Path
from typing import Any

from tests.page.conftest import SOURCES

STATIC = SOURCES.parent / "modallab" / "api" / "page" / "static"
CONFIGURATION = ("index.html", "package.json", "package-lock.json", "tsconfig.json", "vite.config.ts")


def sources() -> list[str]:
    nested = [
        path.relative_to(SOURCES).as_posix()
        for folder in ("src", "public")
        for path in (SOURCES / folder).rglob("*")
        if path.is_file()
    ]
    return sorted([*nested, *CONFIGURATION])


def test_the_built_page_is_that_of_the_sources() -> None:
    """`make page` builds it anew."""
    digest = hashlib.sha256()
    for name in sources():
        digest.update(f"{name}\0".encode() + (SOURCES / name).read_bytes() + b"\0")
    assert (STATIC / "sources.sha256").read_text().strip() == digest.hexdigest()


def test_the_sources_build_to_the_same_bytes(node: str, tmp_path: Path) -> None:
    build = [node, "node_modules/vite/bin/vite.js", "build", "--logLevel", "warn", "--outDir", str(tmp_path)]
    subprocess.run(build, cwd=SOURCES, check=True, capture_output=True)
    built = {path.relative_to(tmp_path): path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    for name in built:
        assert built[name] == (STATIC / name).read_bytes(), name


def test_types_and_functions_of_the_page(node: str) -> None:
    for command in (
        ["node_modules/typescript/bin/tsc", "--noEmit"],
        ["node_modules/vitest/vitest.mjs", "run"],
    ):
        done = subprocess.run([node, *command], cwd=SOURCES, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr


def test_the_service_takes_every_hidden_effect_of_the_page(address: str) -> None:
    """Kind, place and amount of every switch, on the beam that the page begins with."""
    import httpx

    rows: list[dict[str, Any]] = json.loads((SOURCES / "src" / "effects.json").read_text())
    places = {
        "dof": "9:+Y",
        "members": {"members": [7]},
        "channel": {"channels": ["11:+Y"]},
        "drive": "1:+Y",
        "everywhere": None,
    }
    with httpx.Client(base_url=f"{address}/v1", timeout=60) as lab:
        beam = lab.post("/structures", json={"kind": "catalogue", "name": "chapter-5-beam"}).json()["id"]
        analyser = {"n_lines": 9, "averages": 1}
        rig = {"drive": "1:+Y", "responses": ["1:+Y", "11:+Y"], "analyser": analyser}
        declared = lab.post("/rigs", json=rig).json()["id"]
        for row in rows:
            effect = {"kind": row["kind"], "at": places[row["place"]], "parameters": row["parameters"]}
            request = {"structure_id": beam, "rig_id": declared, "effects": [effect]}
            reply = lab.post("/measurements", json=request)
            assert reply.status_code == 202, reply.text
        lab.delete("/jobs")
