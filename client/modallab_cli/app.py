"""The `modallab` command and its parts."""

from importlib.metadata import version
from importlib.util import find_spec

import click

from modallab_cli import service
from modallab_cli.backup import backup, restore
from modallab_cli.body import body
from modallab_cli.convert import convert
from modallab_cli.diagnose import diagnose
from modallab_cli.extract import extract
from modallab_cli.keys import keys
from modallab_cli.lab import fault
from modallab_cli.measure import measure
from modallab_cli.openapi import openapi
from modallab_cli.plot import plot
from modallab_cli.project import export_project, import_project
from modallab_cli.trash import trash
from modallab_cli.update import update

ABOUT = """A virtual modal-testing lab: measure, extract, update and diagnose on files, or serve it over HTTP.

Measure, extract, update, diagnose, convert, plot and openapi need no running service: they work on this
computer, or with --server URL in a lab elsewhere. Trash, body, export and import read and
change what such a lab keeps.
"""
NEEDS_SERVICE = "the service is not installed: pip install 'modallab[service]'"


class InOrder(click.Group):
    """Lists the commands in the order of a test, not of the alphabet."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands as they were added."""
        return list(self.commands)


@click.group(cls=InOrder, help=ABOUT, context_settings={"max_content_width": 100})
@click.version_option(version("modallab"), message="modallab %(version)s")
def app() -> None:
    """Take the options that stand before a command."""


def _missing(command: click.Command) -> click.Command:
    """Return a command that names the extra to install, in place of one that is not installed."""
    name = str(command.name)

    def missing() -> None:
        raise fault(name, NEEDS_SERVICE)

    settings = {"allow_extra_args": True, "ignore_unknown_options": True}
    return click.Command(name, callback=missing, help=command.help, context_settings=settings)


for file_command in (measure, convert, extract, update, diagnose, plot, openapi):
    app.add_command(file_command)
for lab_command in (trash, body, export_project, import_project):
    app.add_command(lab_command)
for service_command in (service.serve, service.worker, service.init, service.demo, keys, backup, restore):
    app.add_command(service_command if find_spec("fastapi") else _missing(service_command))
