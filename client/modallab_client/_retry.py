"""Repetition of requests: only harmless ones, and only a few times."""

from collections.abc import Mapping

from modallab_client.settings import CONNECTION


def pause_after_failure(method: str, attempt: int) -> float | None:
    """Return the seconds to wait after a broken connection, or None to give up.

    A POST may have arrived before the connection broke, so only GET is repeated.
    """
    return (
        CONNECTION.retry_pauses[attempt]
        if method == "GET" and attempt < len(CONNECTION.retry_pauses)
        else None
    )


def pause_after_reply(method: str, attempt: int, status: int, headers: Mapping[str, str]) -> float | None:
    """Return the seconds to wait after a reply that is worth asking again, or None to take it.

    429 or 503 with Retry-After says that nothing was done, so any method may be repeated.
    """
    if attempt >= len(CONNECTION.retry_pauses):
        return None
    if status in (429, 503) and (requested := _seconds(headers.get("retry-after", ""))) is not None:
        return (
            max(requested, CONNECTION.retry_pauses[attempt])
            if requested <= CONNECTION.longest_pause
            else None
        )
    return CONNECTION.retry_pauses[attempt] if method == "GET" and status in (502, 503, 504) else None


def _seconds(text: str) -> float | None:
    try:
        return max(0.0, float(text))
    except ValueError:  # absent, or a date: no clock of another machine is trusted
        return None
