"""When to ask again: only what is harmless to repeat, and only a few times."""

from collections.abc import Mapping

PAUSES = (0.2, 0.4, 0.8, 1.6)  # s; a service that restarts is back within about three seconds
LONGEST_PAUSE = 30.0  # s; a service that asks for more is told to the caller as busy


def pause_after_failure(method: str, attempt: int) -> float | None:
    """Return the seconds to wait after a broken connection, or None to give up.

    A POST may have arrived before the connection broke, so only GET is repeated.
    """
    return PAUSES[attempt] if method == "GET" and attempt < len(PAUSES) else None


def pause_after_reply(method: str, attempt: int, status: int, headers: Mapping[str, str]) -> float | None:
    """Return the seconds to wait after a reply that is worth asking again, or None to take it.

    503 with Retry-After says that nothing was done, so any method may be repeated.
    """
    if attempt >= len(PAUSES):
        return None
    if status == 503 and (wanted := _seconds(headers.get("retry-after", ""))) is not None:
        return max(wanted, PAUSES[attempt]) if wanted <= LONGEST_PAUSE else None
    return PAUSES[attempt] if method == "GET" and status in (502, 503, 504) else None


def _seconds(text: str) -> float | None:
    try:
        return max(0.0, float(text))
    except ValueError:  # absent, or a date: no clock of another machine is trusted
        return None
