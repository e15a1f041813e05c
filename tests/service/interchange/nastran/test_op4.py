"""OUTPUT4: what pyNastran and pyyeti wrote comes back to the last digit that they wrote."""

from pathlib import Path

import numpy as np
import pytest

from modallab.core.errors import InvalidInputError
from modallab.fe.assembly import assemble
from modallab.interchange.nastran.op4 import read_op4
from tests.service.interchange.nastran import described

HERE = Path(__file__).parent
SYSTEM = assemble(described.line())
N = len(SYSTEM.dofs)
FILES = {path.stem: path.read_bytes() for path in sorted(HERE.glob("*.op4"))}
TEXT, BINARY = FILES["bigmat_text"], FILES["nonbigmat_binary"]


def test_every_form_is_there() -> None:
    assert set(FILES) == {
        f"{form}_{how}" for form in ("dense", "bigmat", "nonbigmat") for how in ("text", "binary")
    }
    assert FILES["bigmat_binary"][:4] == b"\0\0\0\x18", "of the other order of bytes"


@pytest.mark.parametrize("name", FILES)
def test_a_file_holds_the_matrices_that_were_written(name: str) -> None:
    found = read_op4(FILES[name], size=N)
    assert set(found) == {"KXX", "MXX"}
    # text has 16 digits or more, binary all of them
    for matrix, own in ((found["KXX"], SYSTEM.stiffness), (found["MXX"], SYSTEM.mass)):
        np.testing.assert_allclose(matrix.toarray(), own.toarray(), rtol=1e-15)


def written(*, kind: int = 2, form: int = 6, twice: bool = False) -> bytes:
    """Return a diagonal matrix in sixteen columns a number, D for E, as older programs write."""
    head = f"{2:8d}{2:8d}{form:8d}{kind:8d}{'KGG':<8s}1P,5D16.9\n"
    body = f"{1:8d}{1:8d}{1:8d}\n 4.000000000D+00\n{2:8d}{2:8d}{1:8d}\n 9.000000000D-01\n"
    last = f"{3:8d}{1:8d}{1:8d}\n 1.000000000D+00\n"
    return ((head + body + last) * (2 if twice else 1)).encode()


def test_exponents_may_be_written_with_a_d() -> None:
    assert read_op4(written(), size=2)["KGG"].toarray().tolist() == [[4.0, 0.0], [0.0, 0.9]]


WRONG = {
    "nothing": (b"", N, "it holds no matrix"),
    "words": (b"no matrix at all", N, "no OUTPUT4 file"),
    "no text": (b"\xff" * 100, N, "no OUTPUT4 file"),
    "half a text": (TEXT[: len(TEXT) // 4], N, "no OUTPUT4 file"),
    "half a record": (BINARY[: len(BINARY) // 4], N, "no OUTPUT4 file"),
    "a length that is none": (BINARY[:4] + b"\0" + BINARY[5:], N, "no OUTPUT4 file|does not fit"),
    "another size": (TEXT, N + 1, f"KXX does not fit the degrees of freedom|MXX|{N}"),
    "a size that no memory has": (TEXT.replace(b"      14     -14", b"99999999-9999999"), N, "does not fit"),
    "complex": (written(kind=4), 2, "KGG is complex"),
    "a triangle": (written(form=4), 2, "has form 4"),
    "one name for two": (written(twice=True), 2, "there twice"),
    "a row beyond": (
        written().replace(b"       2       2       1\n", b"       2       3       1\n"),
        2,
        "beyond its rows",
    ),
    "an entry twice": (
        written().replace(b"       2       2       1\n", b"       1       1       1\n"),
        2,
        "an entry twice",
    ),
    "no number": (
        written().replace(b" 9.000000000D-01", b"             nan."),
        2,
        "no OUTPUT4 file|not finite",
    ),
    "numbers missing": (
        written().replace(b"       1       1       1\n 4", b"       1       1       3\n 4"),
        2,
        "should",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_no_model_matrix_is_refused(case: str) -> None:
    payload, size, message = WRONG[case]
    with pytest.raises(InvalidInputError, match=message) as caught:
        read_op4(payload, size=size, path="model.op4")
    assert caught.value.context["field"] == "model.op4"


def test_a_matrix_that_does_not_fit_is_told_with_its_size_and_the_one_that_would() -> None:
    with pytest.raises(InvalidInputError, match=r"^model\.op4: matrix KXX does not fit") as caught:
        read_op4(TEXT, size=N + 1, path="model.op4")
    assert caught.value.context["value"] == f"{N} x {N}"
    assert caught.value.context["allowed"] == f"{N + 1} x {N + 1}"
