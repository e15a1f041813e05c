"""Separate program that reads a model from the file in a folder, and writes it to standard output."""

import sys
from pathlib import Path
from typing import Any

from modallab.interchange.model_reading import read_model
from modallab.interchange.reader_process import Parts, answer
from modallab.jobs.model_files import ModelRequest
from modallab.store.codec import CODECS
from modallab.store.plain import from_plain


def _model(folder: Path, request: dict[str, Any]) -> Parts:
    model = from_plain(ModelRequest, request["model"], {})
    with (folder / "0").open("rb") as file:
        structure = read_model(
            file,
            largest=request["largest"],
            damping=model.damping,
            name=model.name,
            description=model.description,
        )
    body, arrays = CODECS["structure"].take_apart(structure)
    return {"structure": body}, dict(arrays)


if __name__ == "__main__":
    answer(sys.argv[1], _model)
