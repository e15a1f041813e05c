"""The command `modallab openapi`."""

import json
from pathlib import Path

import click

from modallab_cli import arguments
from modallab_cli.arguments import WRITTEN, check_output
from modallab_cli.lab import lab_of, one_sentence_per_error


@click.command()
@click.option("--out", type=WRITTEN, help="File to write; left out: stdout.")
@arguments.server
def openapi(out: Path | None, server: str | None) -> None:
    """Write the OpenAPI document of the service: every path, request, reply and error."""
    with one_sentence_per_error("openapi"):
        check_output(out, (), "--out")
        with lab_of(server) as lab:
            document = json.dumps(lab.request("GET", "/openapi.json"), indent=1, ensure_ascii=False)
        if out is None:
            click.echo(document)
        else:
            out.write_text(f"{document}\n", encoding="utf-8")
