"""The picture and the table of docs/correlation.md are those of the code."""

import re
from pathlib import Path

import numpy as np
from PIL import Image

from docs.gallery.correlated import ROWS, case, draw, reductions
from docs.gallery.drawing import DPI
from modallab.api.replies import reply_of
from modallab.correlation.compare import Correlation
from modallab.correlation.responses import ResponseCorrelation
from modallab.fe.reduction import REDUCTIONS

DOCS = Path(__file__).parents[2] / "docs"
TEXT = (DOCS / "correlation.md").read_text(encoding="utf-8")


def test_the_table_of_reductions_is_what_comes_out() -> None:
    # two digits are printed; what is printed as 0 is rounding
    assert reductions() in TEXT, "write the table anew"
    assert {kind for kind, _ in ROWS.values()} == set(REDUCTIONS)


def test_the_picture_shows_what_the_page_says() -> None:
    found = case()
    assert found.ecomac is not None
    assert found.responses is not None
    assert str(found.dofs[int(found.ecomac.argmax())]) == "9:+Y"
    np.testing.assert_allclose(found.comac, 1.0, rtol=1e-6)
    assert round(found.responses.frequency_scale or 0.0, 2) == 1.10
    low, high = re.findall(r"MAC of seven modes between (0\.\d+) and (0\.\d+)", TEXT)[0]
    diagonal = np.diag(found.mac)
    assert (f"{diagonal.min():.2f}", f"{diagonal.max():.2f}") == (low, high)
    size = draw().get_size_inches() * DPI
    with Image.open(DOCS / "correlation.png") as image:
        assert image.size == tuple(size.astype(int)), "run `make docs`"


def test_every_criterion_and_every_number_of_a_reduction_is_on_the_page() -> None:
    plain = {"pairs", "frequency_differences", "dofs", "orthogonality", "responses"}
    orthogonality = {"cross", "auto", "frequency_errors"}
    responses = reply_of(ResponseCorrelation).model_fields.keys() - {"outputs", "inputs", "notes"}
    for name in reply_of(Correlation).model_fields.keys() - plain:
        assert f"`{name}`" in TEXT, name
    for part, names in (("orthogonality", orthogonality), ("responses", responses)):
        for name in names:
            assert f"`{part}.{name}`" in TEXT, name
    for kind in REDUCTIONS:
        for name in (kind, *REDUCTIONS[kind].specs()):
            assert f"`{name}`" in TEXT, name
