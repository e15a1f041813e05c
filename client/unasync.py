"""Writes the synchronous client, `modallab_client/_sync`, from the asynchronous one.

Words are replaced, coroutine keywords dropped, and ruff puts imports and line breaks in order. Run it
with `make sync-client`; a test compares what it would write with what is there.
"""

import re
import subprocess
import sys
from pathlib import Path

SOURCE = Path(__file__).parent / "modallab_client" / "_async"
TARGET = SOURCE.with_name("_sync")

# in this order; the words are so chosen that none stands for anything else
REPLACEMENTS = [
    (r"\basync (def|with|for)\b", r"\1"),
    (r"\bawait ", ""),
    (r"\bAwaitable\[(\w+)\]", r"\1"),
    (r"\b__a(enter|exit)__\b", r"__\1__"),
    (r"\baclose\b", "close"),
    (r"\baread\b", "read"),
    (r"\baiter_sse\b", "iter_sse"),
    (r"\baconnect_sse\b", "connect_sse"),
    (r"\basync_(closing|run|sleep)\b", r"\1"),
    (r"\b_async\b", "_sync"),
    (r"\bAsync(\w+)", r"\1"),
]
RUFF = [sys.executable, "-m", "ruff"]
# whether a module that is only now being written exists must not change how its imports are sorted
OURS = ["--config", 'lint.isort.known-first-party=["modallab_client"]']


def without_await(text: str, name: str) -> str:
    """Return a module of the asynchronous client as one of the synchronous client."""
    for pattern, replacement in REPLACEMENTS:
        text = re.sub(pattern, replacement, text)
    as_file = ["--stdin-filename", str(TARGET / name), "-"]
    tidy = ["check", "--quiet", "--fix-only", "--select", "I,F401", *OURS]
    for tool in (tidy, ["format", "--quiet"]):
        text = subprocess.run(
            [*RUFF, *tool, *as_file], input=text, capture_output=True, text=True, check=True
        ).stdout
    return text


def generated() -> dict[Path, str]:
    """Return what belongs into each file of the synchronous client."""
    return {
        TARGET / path.name: without_await(path.read_text(), path.name) for path in sorted(SOURCE.glob("*.py"))
    }


if __name__ == "__main__":
    TARGET.mkdir(exist_ok=True)
    for path, text in generated().items():
        path.write_text(text)
