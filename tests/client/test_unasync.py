"""The synchronous client is the asynchronous one without `await`."""

import importlib.util
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_synchronous_client_is_what_the_generator_writes() -> None:
    spec = importlib.util.spec_from_file_location("unasync", ROOT / "client" / "unasync.py")
    assert spec is not None
    assert spec.loader is not None
    unasync = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(unasync)
    wanted = unasync.generated()
    assert {path: path.read_text() for path in sorted(unasync.TARGET.glob("*.py"))} == wanted
    assert not any(
        "await" in text or "Async" in text for path, text in wanted.items() if path.stem != "__init__"
    )
