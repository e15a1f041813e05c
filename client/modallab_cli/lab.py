"""The lab that a command works in, and how it tells of errors, warnings and progress."""

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from modallab.core.errors import ModalLabError, sentence
from modallab_cli.arguments import read_object
from modallab_client import ModalLab
from modallab_client._plausibility import warned
from modallab_client.errors import ClientError, InvalidInputError, MissingExtraError, PlausibilityWarning
from modallab_client.results import Measurement, ModalModel, Structure

KEY = "MODALLAB_KEY"


@contextmanager
def lab_of(server: str | None) -> Iterator[ModalLab]:
    """Yield the lab at an address, or one that starts and ends with the command."""
    lab = ModalLab.embedded() if server is None else ModalLab(server, api_key=os.environ.get(KEY))
    with lab:
        yield lab


@contextmanager
def one_sentence_per_error(command: str) -> Iterator[None]:
    """End the command with 2 and one sentence where files, options or the lab are at fault."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", PlausibilityWarning)
        warnings.showwarning = _show_warning
        try:
            yield
        except MissingExtraError as error:
            raise fault(command, _without_numerics(error)) from None
        except ModalLabError as error:
            raise fault(command, sentence(error)) from None
        except (ClientError, OSError) as error:
            raise fault(command, str(error)) from None


def fault(command: str, words: str) -> click.exceptions.Exit:
    """Return the end of a command that failed, after one sentence on stderr."""
    click.echo(f"modallab {command}: {words}", err=True)
    return click.exceptions.Exit(2)


def _without_numerics(error: MissingExtraError) -> str:
    if "modallab[service]" not in str(error):
        return str(error)
    return "the numerics are not installed: pip install 'modallab[service]', or name a lab with --server URL"


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    click.echo(f"warning: {message}", err=True)


class ProgressLine:
    """Says how far the work is: on one line of a terminal, else on a line of its own every tenth."""

    def __init__(self) -> None:
        self._tenth = -1

    def __call__(self, fraction: float, message: str) -> None:
        """Write how far the work is."""
        line = f"{fraction:4.0%}  {message}"
        if sys.stderr.isatty():
            sys.stderr.write(f"\r\033[K{line}")
        elif int(10 * fraction) > self._tenth:
            self._tenth = int(10 * fraction)
            sys.stderr.write(f"{line}\n")
        sys.stderr.flush()

    def __enter__(self) -> "ProgressLine":
        return self

    def __exit__(self, *exception: object) -> None:
        if sys.stderr.isatty():
            sys.stderr.write("\r\033[K")


def structure_of(lab: ModalLab, model: Path, mesh: Path | None) -> Structure:
    """Return the model of a file: JSON, or what an import takes."""
    with of_file(model):
        if model.suffix.lower() == ".json":
            return lab.structures.create(**read_object(model))
        described = {} if mesh is None else {"mesh": mesh.read_text(encoding="utf-8")}
        files = {"file": (model.name, model.read_bytes())}
        reply = lab.request("POST", "/v1/structures/import", files=files, data=described)
        return warned(lab.structures.get(reply["id"]))


def rig_id_of(lab: ModalLab, rig: Path | None) -> str | None:
    """Return the id of the log book in a file; None without a file."""
    if rig is None:
        return None
    with of_file(rig):
        reply = lab.request("POST", "/v1/rigs", json=read_object(rig))
        return warned(lab.rigs.get(reply["id"])).id


def measurement_of(lab: ModalLab, measured: Path, rig: Path | None, averages: float | None) -> Measurement:
    """Return the measured FRFs of a file."""
    rig_id = rig_id_of(lab, rig)
    with of_file(measured):
        return lab.measurements.upload(measured, rig_id, averages=averages)


def modes_of(lab: ModalLab, modes: Path) -> ModalModel:
    """Return the modes of a file: JSON, a body of `POST /v1/modal-models/import`, or a universal file."""
    with of_file(modes):
        if modes.suffix.lower() == ".json":
            reply = lab.request("POST", "/v1/modal-models/import", json=read_object(modes))
            return lab.modal_models.get(reply["id"])
        return lab.modal_models.upload(modes)


@contextmanager
def of_file(path: Path) -> Iterator[None]:
    """Name the file in the errors of what is read from it."""
    try:
        yield
    except InvalidInputError as error:
        words = str(error)
        raise InvalidInputError(words if words.startswith(path.name) else f"{path.name}: {words}") from None
