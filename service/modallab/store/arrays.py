"""Array files: written whole or not at all, each named after its owner and its content."""

import hashlib
import os
import tempfile
from pathlib import Path
from typing import Protocol

from modallab.store.base import MissingFileError, StoredDataError


class ArrayFiles(Protocol):
    """Storage of array files: a folder beside the service, an object store when scaled."""

    def put(self, id: str, payload: bytes) -> str:
        """Keep a thing's array file and return its SHA-256."""
        ...

    def get(self, id: str, digest: str) -> bytes:
        """Return an array file; `MissingFileError` if it is gone, `StoredDataError` if it is damaged."""
        ...

    def remove(self, id: str, digest: str) -> None:
        """Forget an array file; nothing happens if it is gone."""
        ...

    def size(self, id: str, digest: str) -> int:
        """Return the bytes of an array file; 0 if it is gone."""
        ...


class FolderArrays:
    """Array files in a folder.

    A file appears under its name only when its bytes have reached the disk, so that a process
    killed at any moment leaves whole files and nameless temporary ones. The name holds the
    owner's id: no two things share a file, and removing one never takes another's arrays.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def _path(self, id: str, digest: str) -> Path:
        return self._folder / id[:2] / f"{id}.{digest[:16]}.npz"

    def put(self, id: str, payload: bytes) -> str:
        """Keep a thing's array file and return its SHA-256."""
        digest = hashlib.sha256(payload).hexdigest()
        path = self._path(id, digest)
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".part")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(payload)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        except BaseException:
            os.unlink(temporary)
            raise
        _sync_folder(path.parent)
        return digest

    def get(self, id: str, digest: str) -> bytes:
        """Return an array file; `MissingFileError` if it is gone, `StoredDataError` if it is damaged."""
        try:
            payload = self._path(id, digest).read_bytes()
        except FileNotFoundError:
            raise MissingFileError("the array file is gone", id=id) from None
        if hashlib.sha256(payload).hexdigest() != digest:
            raise StoredDataError("the array file is damaged", id=id)
        return payload

    def remove(self, id: str, digest: str) -> None:
        """Forget an array file; nothing happens if it is gone."""
        self._path(id, digest).unlink(missing_ok=True)

    def size(self, id: str, digest: str) -> int:
        """Return the bytes of an array file; 0 if it is gone."""
        try:
            return self._path(id, digest).stat().st_size
        except FileNotFoundError:
            return 0


def _sync_folder(folder: Path) -> None:
    if os.name == "nt":  # a folder cannot be opened there; the rename is durable by itself
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
