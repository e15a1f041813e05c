"""The validation report: all published tables are in it, with numbers that this code gives."""

import re
import tomllib
from pathlib import Path

import pytest

from docs.validation.__main__ import TARGET, comparisons, report
from docs.validation.comparison import Comparison, quantity

PUBLISHED = Path(__file__).parents[1] / "published"
TABLES = comparisons()
NUMBER = re.compile(r"[-+]?\d+\.\d+")


def test_it_holds_the_numbers_that_this_code_gives() -> None:
    written, now = TARGET.read_text(encoding="utf-8"), report(TABLES)
    assert NUMBER.sub("#", written) == NUMBER.sub("#", now), "run `make validation`"
    for before, after in zip(NUMBER.findall(written), NUMBER.findall(now), strict=True):
        # one of the last digit: another BLAS rounds otherwise
        last = 10.0 ** -len(after.split(".")[1])
        assert float(before) == pytest.approx(float(after), abs=1.01 * last), "run `make validation`"


def test_it_has_every_published_table() -> None:
    printed = set()
    for path in PUBLISHED.glob("*_1992.toml"):
        for name in tomllib.loads(path.read_text(encoding="utf-8")):
            if name.startswith("table_"):
                printed.add("Table " + name.removeprefix("table_").replace("_", "."))
    assert printed <= {one.number for one in TABLES}
    assert {"Table B.3", "Table D.1", "Section 5.7", "Section 5.7.3"} <= {one.number for one in TABLES}


def test_a_deviation_beyond_the_printed_digit_needs_a_reason() -> None:
    with pytest.raises(ValueError, match="reason ''"):
        Comparison("Table 1", "", (quantity("f, Hz", 10.0, 10.06, 1),))
    table = Comparison("Table 1", "", (quantity("f, Hz", 10.0, 10.06, 1, "a slip"),))
    assert "| f, Hz | 10.0 | 10.06 | **+0.06** | a slip |" in table.markdown()
    assert (table.n_numbers, table.n_beyond) == (1, 1)


def test_and_none_is_given_where_there_is_no_deviation() -> None:
    with pytest.raises(ValueError, match="a slip"):
        Comparison("Table 1", "", (quantity("f, Hz", 10.0, 10.04, 1, "a slip"),))


def test_a_reason_stands_in_the_row_of_the_item_that_deviates() -> None:
    items = [str(number) for number in range(20)]
    found = [10.0] * 19 + [10.06]
    table = Comparison("Table 1", "", (quantity("f", [10.0] * 20, found, 1, "a slip"),), "DoF", items)
    rows = table.markdown().splitlines()
    assert [row for row in rows if "a slip" in row] == ["| 19 | 10.0 | 10.06 | **+0.06** | a slip |"]
