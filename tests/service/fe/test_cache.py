"""What is kept of what was worked out before."""

from modallab.fe.cache import cached
from modallab.fe.settings import CACHE


def test_the_latest_few_are_kept() -> None:
    shared: dict[str, object] = {}
    made: list[int] = []

    def ask(key: int) -> int:
        def make() -> int:
            made.append(key)
            return key

        return cached(shared, "numbers", key, make)

    for key in range(CACHE.variants):
        assert ask(key) == key
    for key in range(CACHE.variants):
        ask(key)
    assert made == list(range(CACHE.variants))  # none twice
    ask(0), ask(CACHE.variants)  # 1 is now what was not asked for longest
    ask(0)
    assert made == list(range(CACHE.variants + 1))
    ask(1)
    assert made[-1] == 1
