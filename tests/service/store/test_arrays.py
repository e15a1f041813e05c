"""Array files are whole or not there."""

import os
from pathlib import Path

import pytest

from modallab.store.arrays import FolderArrays
from modallab.store.base import MissingFileError, StoredDataError


def test_a_file_comes_back_until_it_is_removed(tmp_path: Path) -> None:
    files = FolderArrays(tmp_path)
    digest = files.put("abc", b"payload")
    assert files.get("abc", digest) == b"payload"
    files.remove("abc", digest)
    files.remove("abc", digest)
    with pytest.raises(MissingFileError):
        files.get("abc", digest)


def test_two_things_of_the_same_content_share_no_file(tmp_path: Path) -> None:
    files = FolderArrays(tmp_path)
    digest = files.put("abc", b"payload")
    files.put("abd", b"payload")
    files.remove("abc", digest)
    assert files.get("abd", digest) == b"payload"


def test_a_write_that_fails_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_handle: int) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="no space"):
        FolderArrays(tmp_path).put("abc", b"payload")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_a_file_that_has_changed_is_not_returned(tmp_path: Path) -> None:
    files = FolderArrays(tmp_path)
    digest = files.put("abc", b"payload")
    (file,) = (path for path in tmp_path.rglob("*") if path.is_file())
    file.write_bytes(b"pbyload")
    with pytest.raises(StoredDataError, match="damaged"):
        files.get("abc", digest)
