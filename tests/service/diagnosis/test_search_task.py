"""When a search begins anew with other FRFs held out."""

from unittest.mock import Mock

import pytest

from modallab.diagnosis import search_task
from modallab.diagnosis.optimisation.tolerances import Tolerances
from modallab.diagnosis.search_result import SearchResult
from modallab.diagnosis.search_task import SearchTask


@pytest.mark.parametrize("explains", [True, False])
def test_what_explains_with_other_frfs_held_out_is_not_searched_for_anew(
    explains: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    others = Mock(fit_without_effects=lambda *_: SearchResult(Mock(), Mock(), ()))
    tests = Mock(sparing_outliers_of=lambda _: others)
    found, path = Mock(unexplained_parts={"frf"}), Mock()
    searched = []

    def search(task: SearchTask, *_: object) -> tuple[Mock, None]:
        searched.append(task.tests)
        return found, None

    monkeypatch.setattr(SearchTask, "_search", search)
    monkeypatch.setattr(search_task, "refitted_path", lambda *_: path if explains else None)
    result, _ = SearchTask(tests, None, 3).run(Tolerances(), None, Mock())
    assert searched == ([tests] if explains else [tests, others])
    assert (result.path is path) == explains
