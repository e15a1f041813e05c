"""Hook of mkdocs: adds the pages of the API reference, which docs/openapi.json determines."""

import json
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from docs.reference.operations import pages

OPENAPI = Path(__file__).with_name("openapi.json")


def on_files(files: Files, config: MkDocsConfig, **_: Any) -> Files:
    """Return the files of the site with the pages of the API reference."""
    for name, text in pages(json.loads(OPENAPI.read_text(encoding="utf-8"))).items():
        files.append(File.generated(config, f"api/{name}", content=text))
    return files
