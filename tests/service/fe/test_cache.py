"""What is kept of what was worked out before."""

from modallab.fe.cache import KEPT, cached


def test_the_latest_few_are_kept() -> None:
    shared: dict[str, object] = {}
    made: list[int] = []

    def ask(key: int) -> int:
        def make() -> int:
            made.append(key)
            return key

        return cached(shared, "numbers", key, make)

    for key in range(KEPT):
        assert ask(key) == key
    for key in range(KEPT):
        ask(key)
    assert made == list(range(KEPT))  # none twice
    ask(0), ask(KEPT)  # 1 is now what was not asked for longest
    ask(0)
    assert made == list(range(KEPT + 1))
    ask(1)
    assert made[-1] == 1
