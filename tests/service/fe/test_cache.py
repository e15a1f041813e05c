"""Cached results of a system: order of use, capacity, values that are None or False."""

from modallab.fe.cache import Cache, CacheSlot

SLOT: CacheSlot[int] = CacheSlot("numbers", 16)


def test_the_least_recently_used_result_is_dropped() -> None:
    cache = Cache()
    made: list[int] = []

    def ask(key: int) -> int:
        def make() -> int:
            made.append(key)
            return key

        return cache.compute(SLOT, key, make)

    for key in range(SLOT.capacity):
        assert ask(key) == key
    for key in range(SLOT.capacity):
        ask(key)
    assert made == list(range(SLOT.capacity))  # none twice
    ask(0), ask(SLOT.capacity)  # 1 is now the least recently used
    ask(0)
    assert made == list(range(SLOT.capacity + 1))
    ask(1)
    assert made[-1] == 1


def test_a_result_that_is_put_is_found_and_slots_are_apart() -> None:
    cache, flag = Cache(), CacheSlot[bool]("flag")
    assert cache.get(SLOT) is None
    cache.put(SLOT, 3)
    cache.put(flag, False)
    assert cache.get(SLOT) == 3
    assert cache.compute(flag, None, lambda: True) is False
    assert list(cache.entries(flag)) == [None]
    cache.put(SLOT, 4)
    assert cache.get(SLOT) == 4


def test_a_capacity_of_the_call_replaces_that_of_the_slot() -> None:
    cache = Cache()
    for key in range(3):
        cache.put(SLOT, key, key, capacity=2)
    assert list(cache.entries(SLOT)) == [1, 2]
