"""A backup is a lab of one moment, made while others write, and becomes the same lab again."""

import io
import json
import tarfile
import threading
from pathlib import Path

import numpy as np
import pytest
import sqlalchemy as sa

from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import assemble
from modallab.fe.catalogued import STRUCTURES
from modallab.fe.synthetic_modes import exact_modes
from modallab.store.arrays import FolderArrays
from modallab.store.backup import back_up, restore
from modallab.store.base import StoredDataError
from modallab.store.migrate import migrate, revision_of
from modallab.store.place import StorePlace, engine_of, open_store
from modallab.store.tables import JOBS, LINKS, METADATA, THINGS
from tests.databases import database

BEAM = STRUCTURES["chapter-5-beam"]()
MODES = exact_modes(assemble(BEAM), 3)


def fill(place: StorePlace) -> tuple[str, str]:
    """Store a structure and modes made from it, and return their ids."""
    store = open_store(place)
    with store.together() as batch:
        beam = batch.structures.add(BEAM, owner="me")
        modes = batch.modal_models.add(MODES, owner="me", inputs={"structure_id": beam}, seed=3)
    return beam, modes


def content(place: StorePlace) -> dict[str, list[str]]:
    """Return all rows of a lab by table, as text."""
    with engine_of(place).connect() as connection:
        return {
            table.name: sorted(json.dumps(row._asdict()) for row in connection.execute(sa.select(table)))
            for table in METADATA.sorted_tables
        }


def backup_of(place: StorePlace, folder: Path) -> Path:
    path = folder / "lab.backup"
    with path.open("wb") as file:
        back_up(place, file)
    return path


@pytest.fixture
def empty(tmp_path: Path) -> StorePlace:
    """A place with nothing in it, not even tables."""
    folder = tmp_path / "empty"
    folder.mkdir()
    return StorePlace(f"sqlite:///{folder / 'modallab.sqlite'}", "unused", folder / "arrays")


def test_a_restored_lab_is_the_same(place: StorePlace, empty: StorePlace, tmp_path: Path) -> None:
    beam, modes = fill(place)
    restore(empty, backup_of(place, tmp_path))
    assert content(empty) == content(place)
    assert open_store(empty).modal_models.npz(modes) == open_store(place).modal_models.npz(modes)
    np.testing.assert_array_equal(open_store(empty).structures.get(beam).dofs, BEAM.dofs)


def test_a_backup_under_load_is_of_one_moment(place: StorePlace, empty: StorePlace, tmp_path: Path) -> None:
    ended, kept = threading.Event(), [fill(place) for _ in range(5)]

    def work() -> None:
        store = open_store(place)
        while not ended.is_set():
            pairs = [fill(place) for _ in range(3)]
            kept.append(pairs.pop())
            for beam, modes in pairs:
                store.modal_models.remove(modes)
                store.structures.remove(beam)

    workers = [threading.Thread(target=work) for _ in range(1)]
    for worker in workers:
        worker.start()
    try:
        paths = []
        for number in range(2):
            (tmp_path / str(number)).mkdir()
            paths.append(backup_of(place, tmp_path / str(number)))
    finally:
        ended.set()
        for worker in workers:
            worker.join()
    restore(empty, paths[-1])
    there, here = open_store(empty), open_store(place)
    with engine_of(empty).connect() as connection:
        found = connection.execute(sa.select(THINGS.c.id, THINGS.c.kind)).all()
        links = connection.execute(sa.select(LINKS)).all()
    ids = {row.id: row.kind for row in found}
    assert {id for pair in kept[:5] for id in pair} <= set(ids)
    models = [id for id, kind in ids.items() if kind == "modal_model"]
    assert {link.source for link in links} == set(models)  # each with what it was made from
    assert len(ids) - len(models) >= len(models)
    for id in models:
        assert there.modal_models.get(id).dofs == MODES.dofs
        if here.modal_models.holds(id):
            assert there.modal_models.npz(id) == here.modal_models.npz(id)
            assert there.modal_models.entry(id) == here.modal_models.entry(id)


def test_what_is_removed_while_it_is_copied_is_left_out(
    place: StorePlace, empty: StorePlace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (_, modes), (_, kept) = fill(place), fill(place)
    get, removed = FolderArrays.get, list[str]()

    def removed_meanwhile(self: FolderArrays, id: str, digest: str) -> bytes:
        if id == modes and not removed:
            removed.append(id)
            open_store(place).modal_models.remove(id)
        return get(self, id, digest)

    monkeypatch.setattr(FolderArrays, "get", removed_meanwhile)
    restore(empty, backup_of(place, tmp_path))
    assert removed == [modes]
    assert not open_store(empty).modal_models.holds(modes)
    assert open_store(empty).modal_models.npz(kept) == open_store(place).modal_models.npz(kept)


def test_only_an_empty_place_is_restored_into(place: StorePlace, tmp_path: Path) -> None:
    fill(place)
    before, path = content(place), backup_of(place, tmp_path)
    with pytest.raises(InvalidInputError, match="empty place"):
        restore(place, path)
    assert content(place) == before


def test_a_cut_or_changed_backup_is_refused(place: StorePlace, empty: StorePlace, tmp_path: Path) -> None:
    fill(place)
    path = backup_of(place, tmp_path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InvalidInputError, match="no whole backup"):
        restore(empty, path)
    with tarfile.open(fileobj=io.BytesIO(whole)) as archive:
        at = next(member.offset_data for member in archive if member.name.startswith("arrays/"))
    path.write_bytes(whole[:at] + b"XXXX" + whole[at + 4 :])
    with pytest.raises(StoredDataError, match="damaged"):
        restore(empty, path)
    assert [file for file in empty.folder.rglob("*") if file.is_file()] == []
    path.write_bytes(whole)
    restore(empty, path)  # what failed left the place empty
    assert content(empty) == content(place)


def test_a_damaged_lab_makes_no_backup(place: StorePlace, tmp_path: Path) -> None:
    fill(place)
    (file,) = (path for path in place.folder.rglob("*") if path.is_file())
    file.write_bytes(b"damaged")
    with pytest.raises(StoredDataError, match="damaged"):
        backup_of(place, tmp_path)


def test_a_lab_moves_from_one_database_to_the_other(
    place: StorePlace, empty: StorePlace, tmp_path: Path
) -> None:
    fill(place)
    path = backup_of(place, tmp_path)
    with database("postgresql", tmp_path) as (url, schema):
        other = StorePlace(url, schema, tmp_path / "other")
        restore(other, path)
        assert content(other) == content(place)
        back = tmp_path / "back"
        back.mkdir()
        restore(empty, backup_of(other, back))
        engine_of(other).dispose()
    assert content(empty) == content(place)


def test_a_backup_of_an_earlier_schema_is_brought_up_to_date(
    place: StorePlace, empty: StorePlace, tmp_path: Path
) -> None:
    path = backup_of(place, tmp_path)
    with engine_of(place).begin() as connection:
        newest = connection.execute(sa.text("SELECT version_num FROM alembic_version")).scalar_one()
    rows = [
        [
            "jobs",
            {"id": "a", "owner": "me", "task": "t", "arguments": {}, "created": "2026", "state": "failed"},
        ]
    ]
    rows[0][1] |= {"fraction": 0.0, "message": "", "result_id": "b"}  # type: ignore[operator]
    with tarfile.open(path, "w") as archive:
        for name, text in (
            ("rows.jsonl", "\n".join(map(json.dumps, rows))),
            ("manifest.json", json.dumps({"format": 1, "revision": "0001", "version": "0", "rows": {}})),
        ):
            header = tarfile.TarInfo(name)
            header.size = len(text)
            archive.addfile(header, io.BytesIO(text.encode()))
    restore(empty, path)
    assert revision_of(engine_of(empty)) == newest
    with engine_of(empty).connect() as connection:
        assert connection.execute(sa.select(JOBS.c.id, JOBS.c.request_key)).all() == [("a", None)]


def test_a_database_of_a_later_version_is_refused(place: StorePlace) -> None:
    with engine_of(place).begin() as connection:
        connection.execute(sa.text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(StoredDataError, match="later version"):
        migrate(engine_of(place), schema=place.schema)
