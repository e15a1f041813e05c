"""A lab that talks to a stand-in."""

from collections.abc import Iterator
from dataclasses import replace

import httpx
import pytest

from modallab_client import ModalLab, _retry
from modallab_client.settings import CONNECTION
from tests.client.fake import FakeService


@pytest.fixture
def service(monkeypatch: pytest.MonkeyPatch) -> FakeService:
    """A stand-in, and a client that does not wait between attempts."""
    monkeypatch.setattr(_retry, "CONNECTION", replace(CONNECTION, retry_pauses=(0.0, 0.0, 0.0, 0.0)))
    return FakeService()


@pytest.fixture
def lab(service: FakeService) -> Iterator[ModalLab]:
    """A client of the stand-in."""
    with httpx.Client(transport=httpx.MockTransport(service)) as http:
        yield ModalLab("http://lab:8000/", api_key="secret", http=http)
