"""The commands `modallab backup` and `modallab restore`."""

import os
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer

_Data = Annotated[Path | None, typer.Option(help="Folder for arrays and the embedded database.")]


def backup(
    file: Annotated[Path, typer.Argument(dir_okay=False, help="File to write; one that exists is replaced.")],
    data: _Data = None,
) -> None:
    """Write everything that a lab keeps to one file, as of one moment; the service may go on."""
    from modallab.api.starting import told_in_a_sentence
    from modallab.store.backup import back_up

    part = file.with_name(f"{file.name}.part")
    try:
        with told_in_a_sentence():
            with part.open("wb") as out:
                counts = back_up(_settings(data).store_place, out)
                out.flush()
                os.fsync(out.fileno())
            os.replace(part, file)
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)
    typer.echo(f"{file}: {_words(counts)}, {file.stat().st_size / 1e6:.1f} MB")


def restore(
    file: Annotated[Path, typer.Argument(exists=True, dir_okay=False, help="File of `modallab backup`.")],
    data: _Data = None,
) -> None:
    """Make an empty place into the lab of a backup; jobs that had not ended are done anew."""
    from modallab.api.starting import lock_of, told_in_a_sentence
    from modallab.store import backup as backups

    settings = _settings(data)
    lock = lock_of(settings.data) if settings.embedded else None
    with told_in_a_sentence():
        counts = backups.restore(settings.store_place, file)
        settings.job_place.prepare()
    typer.echo(f"{settings.data}: {_words(counts)}")
    del lock


def _settings(data: Path | None) -> Any:
    from modallab.api.settings import ServiceSettings

    return ServiceSettings() if data is None else ServiceSettings(data=data)


def _words(counts: dict[str, int]) -> str:
    return ", ".join(f"{n} {name}" for name, n in counts.items()) or "nothing"
