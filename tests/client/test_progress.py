"""Progress on the screen: short numbers, a bar where tqdm is installed, else a line a tenth."""

import sys
import types
from typing import Any

import pytest

from modallab_client import ModalLab
from modallab_client._progress import progress_bar
from tests.client.fake import FakeService, events


def start(service: FakeService) -> None:
    steps = [{"state": "running", "fraction": fraction, "message": "m"} for fraction in (1 / 3, 0.35, 2 / 3)]
    service.on("POST /v1/modal-models", {"id": "j1", "state": "queued"})
    service.on(
        "GET /v1/jobs/j1/events", events(*steps, {"state": "failed", "fraction": 1.0, "message": "no"})
    )


def test_fractions_are_short(lab: ModalLab, service: FakeService) -> None:
    start(service)
    told: list[float] = []
    with pytest.raises(Exception, match="no"):
        lab.modal_models.start("m1").result(on_progress=lambda fraction, _: told.append(fraction))
    assert told == [0.333, 0.35, 0.667, 1.0]


def test_without_tqdm_a_tenth_has_a_line(
    lab: ModalLab, service: FakeService, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    start(service)
    with pytest.raises(Exception, match="no"):
        lab.modal_models.start("m1").result(progress=True)
    assert capsys.readouterr().err.splitlines() == [" 33%  m", " 67%  m", "100%  no"]


def test_a_bar_is_closed_with_the_job(monkeypatch: pytest.MonkeyPatch) -> None:
    class Bar:
        n = 0
        closed = False

        def __init__(self, **_: Any) -> None:
            bars.append(self)

        def set_postfix_str(self, text: str, refresh: bool) -> None:
            self.text = text

        def refresh(self) -> None: ...

        def close(self) -> None:
            self.closed = True

    bars: list[Bar] = []
    module: Any = types.ModuleType("tqdm.auto")
    module.tqdm = Bar
    monkeypatch.setitem(sys.modules, "tqdm", types.ModuleType("tqdm"))
    monkeypatch.setitem(sys.modules, "tqdm.auto", module)
    with progress_bar(wanted=True) as watch:
        assert watch is not None
        watch(0.5, "halfway")
    assert (bars[0].n, bars[0].text, bars[0].closed) == (50, "halfway", True)
