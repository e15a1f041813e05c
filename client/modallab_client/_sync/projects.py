"""Projects: what one has stored on a service as one file, and into another service."""

from pathlib import Path

from modallab_client import _wire
from modallab_client._generated.models import ImportedProject
from modallab_client._sync.transport import Transport


class Projects:
    """Files of stored things, with their names, labels, comments and what was made from what."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    def download(self, path: str | Path, *, label: str | None = None) -> Path:
        """Write what one has stored to a file, and return its path.

        Parameters
        ----------
        path
            Of the zip file.
        label
            Of the things; what they were made from is written, too. None: everything.
        """
        content = self._transport.request("GET", "/v1/projects/export", params=_wire.body(label=label))
        file = Path(path)
        file.write_bytes(content)
        return file

    def upload(self, path: str | Path) -> ImportedProject:
        """Store the things of a file, which belong to oneself, and return their new ids by those in the file.

        Raises
        ------
        InvalidInputError
            If it is no such file, is damaged, or holds what has no meaning; nothing is stored then.
        """
        files = {"file": ("project.zip", Path(path).read_bytes())}
        reply = self._transport.request("POST", "/v1/projects/import", files=files)
        return _wire.reply(ImportedProject, reply)
