"""Results in a file: what is read is what was written."""

from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modallab_client import load, save
from modallab_client._read import read_as
from modallab_client.estimates import Estimates
from modallab_client.methods.modal_models import modal_model_of
from modallab_client.methods.updates import update_of
from modallab_client.models import Frf, ModeShapes
from modallab_client.results import Diagnosis, ModalModel
from modallab_client.time_records import TimeRecords
from tests.client.fake import DIAGNOSIS, UPDATE, completed
from tests.client.test_drawing import MODEL, SHAPES, measurement

LINES = np.array([1.0, np.nan, 3.0])
RESULTS = {
    "measurement": replace(measurement(), n_records=3),
    "modal model": modal_model_of(MODEL, SHAPES),
    "update": update_of(UPDATE),
    "diagnosis": read_as(Diagnosis, completed(Diagnosis, DIAGNOSIS), curves=None),
    "FRFs": Frf(LINES, np.full((3, 1, 1), 1 - 2j), ("2:+Y",), ("1:+Y",), "mobility", ("a note",)),
    "shapes": ModeShapes(LINES, np.ones((1, 3), complex), ("1:+Y",)),
    "estimates": Estimates(
        *(np.array([1, 3]), LINES, np.ones((2, 3, 1, 1), complex), np.ones((2, 3, 1))),
        *(("2:+Y",), ("1:+Y",), "inertance"),
    ),
    "records": TimeRecords(np.ones((2, 4, 1, 1)), np.zeros((2, 4, 1, 1)), 8.0, (("1:+Y",),), (("2:+Y",),)),
}


def assert_equal(read: Any, written: Any) -> None:
    assert type(read) is type(written)
    if is_dataclass(written):
        for field in fields(written):
            assert_equal(getattr(read, field.name), getattr(written, field.name))
    elif isinstance(written, np.ndarray):
        np.testing.assert_array_equal(read, written, strict=True)
        assert not read.flags.writeable
    elif isinstance(written, dict):
        assert list(read) == list(written)
        for key, item in written.items():
            assert_equal(read[key], item)
    elif isinstance(written, tuple):
        assert len(read) == len(written)
        for one, other in zip(read, written, strict=True):
            assert_equal(one, other)
    else:
        assert read == written or (np.isnan(read) and np.isnan(written))


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_is_read_as_it_was_written(tmp_path: Path, name: str) -> None:
    path = save(RESULTS[name], tmp_path / "result.npz")
    assert_equal(load(path), RESULTS[name])


def test_what_is_no_result_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="a result of the client can be saved, not dict"):
        save({"a": 1}, tmp_path / "result.npz")


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04 broken"])
def test_another_file_is_no_result(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "other.npz").write_bytes(content)
    with pytest.raises(ValueError, match=r"other\.npz has no result of this client"):
        load(tmp_path / "other.npz")


def test_an_archive_of_other_arrays_is_no_result(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", freq=LINES)
    with pytest.raises(ValueError, match=r"other\.npz has no result of this client"):
        load(tmp_path / "other.npz")


def test_modes_are_a_table_of_pandas() -> None:
    model = RESULTS["modal model"]
    assert isinstance(model, ModalModel)
    table = model.to_pandas()
    assert table.index.tolist() == [1]
    assert table.frequency[1] == model.modes[0].frequency
    assert table.loss_factor[1] == model.modes[0].loss_factor
    assert table.frequency_error[1] == model.modes[0].standard_errors["frequency"]


def test_frfs_are_labelled_arrays_of_xarray() -> None:
    test = measurement()
    data = test.to_xarray()
    assert data.frf.dims == ("freq", "output", "input")
    found = data.frf.sel(output="3:+Y", input="1:+Y")
    np.testing.assert_array_equal(found, test.values[:, 1, 0])
    assert data.frf.attrs["units"] == "m/(s² N)"
    assert data.coherence.dims == ("freq", "output")
