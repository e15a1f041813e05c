"""The commands `modallab backup` and `modallab restore`."""

import os
from contextlib import suppress
from pathlib import Path

import click

from modallab_cli.arguments import READ, WRITTEN
from modallab_cli.settings import settings_of

_data = click.option("--data", type=WRITTEN, help="Folder for arrays and the embedded database.")


@click.command()
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@_data
def backup(file: Path, data: Path | None) -> None:
    """Write everything that a lab keeps to one file, as of one moment; the service may go on."""
    from modallab.store.backup import back_up
    from modallab_cli.starting import told_in_a_sentence

    part = file.with_name(f"{file.name}.part")
    try:
        with told_in_a_sentence():
            with part.open("wb") as out:
                counts = back_up(settings_of(data=data).store_place, out)
                out.flush()
                os.fsync(out.fileno())
            os.replace(part, file)
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)
    click.echo(f"{file}: {_words(counts)}, {file.stat().st_size / 1e6:.1f} MB")


@click.command()
@click.argument("file", type=READ)
@_data
def restore(file: Path, data: Path | None) -> None:
    """Make an empty place into the lab of a backup; jobs that had not ended are done anew."""
    from modallab.store import backup as backups
    from modallab_cli.starting import lock_of, told_in_a_sentence

    settings = settings_of(data=data)
    lock = lock_of(settings.data) if settings.embedded else None
    with told_in_a_sentence():
        counts = backups.restore(settings.store_place, file)
        settings.job_place.prepare()
    click.echo(f"{settings.data}: {_words(counts)}")
    del lock


def _words(counts: dict[str, int]) -> str:
    return ", ".join(f"{n} {name}" for name, n in counts.items() if n) or "nothing"
