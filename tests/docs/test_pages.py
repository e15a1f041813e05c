"""How pages are run: blocks share their names, and what a check finds wrong is told."""

from pathlib import Path
from typing import Any

import pytest

from tests.pages import outcomes, run_page

PAGE = """# Page

```python
value = 1
print(value)
```

```python
value += 1
```
"""


def right(names: dict[str, Any]) -> None:
    assert (names["value"], names["__printed__"]) == (2, "1\n")
    assert Path.cwd().name == "folder"


def wrong(names: dict[str, Any]) -> None:
    assert names["value"] == 1


def test_blocks_share_names_and_a_check_that_fails_is_told(tmp_path: Path) -> None:
    page, folder = tmp_path / "page.md", tmp_path / "folder"
    page.write_text(PAGE, encoding="utf-8")
    folder.mkdir()
    found = outcomes(str(page), folder, [right, wrong])
    assert not found["right"]
    assert "AssertionError" in found["wrong"]
    page.write_text(PAGE.replace("value = 1", "value = lab"), encoding="utf-8")
    with pytest.raises(NameError, match="lab"):
        run_page(str(page), folder, right)
