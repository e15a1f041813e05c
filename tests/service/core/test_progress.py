from modallab.core.progress import Pulse


def test_a_beat_says_again_what_was_said_last() -> None:
    told: list[tuple[float, str]] = []
    pulse = Pulse(lambda fraction, message: told.append((fraction, message)))
    pulse.beat()  # nothing was said yet
    pulse(0.2, "half way to something")
    pulse.beat()
    assert told == [(0.2, "half way to something")] * 2
