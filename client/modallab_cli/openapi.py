"""The command `modallab openapi`."""

import json
from pathlib import Path
from typing import Annotated

import typer

from modallab_cli.arguments import Server, check_output
from modallab_cli.lab import lab_of, one_sentence_per_error


def openapi(
    out: Annotated[Path | None, typer.Option(help="File to write; left out: stdout.")] = None,
    server: Server = None,
) -> None:
    """Write the OpenAPI document of the service: every path, request, reply and error."""
    with one_sentence_per_error("openapi"):
        check_output(out, (), "--out")
        with lab_of(server) as lab:
            document = json.dumps(lab.request("GET", "/openapi.json"), indent=1, ensure_ascii=False)
        if out is None:
            typer.echo(document)
        else:
            out.write_text(f"{document}\n", encoding="utf-8")
