"""A lab that talks to a stand-in."""

from collections.abc import Iterator

import httpx
import pytest

from modallab_client import ModalLab, _retry
from tests.client.fake import FakeService


@pytest.fixture
def service(monkeypatch: pytest.MonkeyPatch) -> FakeService:
    """A stand-in, and a client that does not wait between attempts."""
    monkeypatch.setattr(_retry, "PAUSES", (0.0, 0.0, 0.0, 0.0))
    return FakeService()


@pytest.fixture
def lab(service: FakeService) -> Iterator[ModalLab]:
    """A client of the stand-in."""
    with httpx.Client(transport=httpx.MockTransport(service)) as http:
        yield ModalLab("http://lab:8000/", api_key="secret", http=http)
