"""What docs/files.md tells to type."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat

from modallab_client import ModalLab, errors

TEXT = (Path(__file__).parents[2] / "docs" / "files.md").read_text(encoding="utf-8")


def test_a_universal_file_gives_modes_in_two_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    two_lines, rig_of_it, back, known, other_formats = re.findall(
        r"^```python\n(.*?)^```", TEXT, flags=re.DOTALL | re.MULTILINE
    )
    assert len(two_lines.splitlines()) == 2
    monkeypatch.chdir(tmp_path)
    with ModalLab.embedded() as lab:
        names: dict[str, Any] = {"lab": lab, "Path": Path}
        exec(rig_of_it, names)
        beam = lab.structures.catalogue("chapter-5-beam")
        made = lab.measurements.start(beam.id, names["rig"].id, seed=1).result()
        (tmp_path / "frf.uff").write_bytes(lab.measurements.uff(made.id))
        exec(two_lines, names)
        exec(back, names)
        direct = lab.modal_models.start(made.id, method="dobson", n_modes=8).result()
        assert len(direct.modes) == 8
        assert names["modes"].table() == direct.table()
        np.testing.assert_array_equal(names["modes"].shapes, direct.shapes)
        # the header says which thing a file is of
        first, again = ((tmp_path / name).read_bytes() for name in ("frf.uff", "out.uff"))
        assert again[again.index(b"    58b") :] == first[first.index(b"    58b") :]
        names["beam"] = beam
        exec(known, names)
        # columns of 13 leave six digits
        np.testing.assert_allclose(names["same"].shapes, direct.shapes, rtol=1e-5, atol=1e-9)
        assert (tmp_path / "geometry.uff").read_bytes().count(b"\n    82\n") == 1
        freq, frf = made.freq, made.values[:, :, 0]
        savemat(tmp_path / "test.mat", {"f": freq, "frf": frf, "coh": made.coherence})
        columns = np.column_stack([freq, frf[:, 0].real, frf[:, 0].imag])
        for name in ("wing_tip.csv", "tail.csv"):
            np.savetxt(tmp_path / name, columns, delimiter=",", header="Hz,real,imag", comments="")
        exec(other_formats, names)
        cut = (tmp_path / "frf.uff").read_bytes()[:-1000]
        with pytest.raises(errors.InvalidInputError, match="dataset"):
            lab.measurements.upload(cut, names["rig"].id)
