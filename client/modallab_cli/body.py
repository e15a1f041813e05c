"""The command `modallab body`: descriptions that are read back from a lab."""

import json
from pathlib import Path

import click

from modallab_cli import arguments
from modallab_cli.arguments import WRITTEN, check_output
from modallab_cli.lab import lab_of, one_sentence_per_error


@click.command()
@click.argument("kind", type=click.Choice(["structure", "rig"]))
@click.argument("id")
@click.option("--out", type=WRITTEN, help="File to write: .json; left out: stdout.")
@arguments.lab
def body(kind: str, id: str, out: Path | None, server: str) -> None:
    """Write the JSON that described a structure or a rig in a lab, as --model and --rig take it."""
    with one_sentence_per_error("body"):
        check_output(out, (".json",), "--out")
        with lab_of(server) as lab:
            described = (lab.structures if kind == "structure" else lab.rigs).body(id)
        text = json.dumps(described, indent=1, ensure_ascii=False)
        if out is None:
            click.echo(text)
        else:
            out.write_text(f"{text}\n", encoding="utf-8")
