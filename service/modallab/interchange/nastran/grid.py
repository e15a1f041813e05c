"""Grid points and supports of bulk data."""

from collections.abc import Iterable, Mapping, Sequence

from modallab.core.dof import DIRECTIONS
from modallab.core.errors import InvalidInputError
from modallab.fe.structure import Support
from modallab.interchange.nastran.deck import Card, Deck
from modallab.interchange.nastran.properties import by_number

Place = tuple[float, float, float]


def components(card: Card, at: int) -> tuple[str, ...]:
    """Return the directions that a field names, `123` or `456`."""
    text = card.text(at)
    if not set(text) <= set("0123456") or "0" in text:
        raise card.wrong(at, "digits 1 to 6")
    return tuple(DIRECTIONS[int(digit) - 1] for digit in dict.fromkeys(text))


def grid_points(cards: Sequence[Card]) -> tuple[dict[int, Place], list[Support]]:
    """Return the positions of grid points, m, and their permanent supports."""
    default_card = next((card for card in cards if card.name == "GRDSET"), None)
    places: dict[int, Place] = {}
    supports: list[Support] = []
    for number, card in by_number([card for card in cards if card.name == "GRID"], "grid points").items():
        for at, system in ((2, "CP"), (6, "CD")):
            source = card if card.text(at) else default_card or card
            if source.text(at) and source.integer(at) != 0:
                raise source.wrong(at, f"0 or blank: other systems of coordinates ({system}) are not read")
        places[number] = (card.real(3, 0.0), card.real(4, 0.0), card.real(5, 0.0))
        source = card if card.text(7) else default_card or card
        if held_here := components(source, 7):
            supports.append(Support(number, held_here))
    return places, supports


def supports(deck: Deck, places: Mapping[int, Place]) -> list[Support]:
    """Return the supports of the selected set of single-point constraints, or of the only one.

    Raises
    ------
    InvalidInputError
        If there are several sets and case control chooses none, or it chooses one that is not there.
    """
    cards = [card for card in deck.cards if card.name in ("SPC", "SPC1")]
    sums = {card.integer(1): card for card in deck.cards if card.name == "SPCADD"}
    sets = sorted({card.integer(1) for card in cards})
    chosen = deck.choices.get("SPC")
    if chosen is None and len(sets) > 1:
        if len(sums) != 1:
            raise InvalidInputError(
                "the file has several sets of constraints, and chooses none",
                field="SPC",
                value=list(sets),
                allowed="SPC = n in its case control, or one set",
            )
        chosen = next(iter(sums))
    set_numbers = set(sets) if chosen is None else {chosen}
    if chosen in sums:
        add = sums[chosen]
        set_numbers = {add.integer(at) for at in range(2, len(add.fields) + 1) if add.text(at)}
    if missing := sorted(set_numbers - set(sets)):
        raise InvalidInputError(
            f"there is no set of constraints {missing[0]}",
            field="SPC",
            value=missing[0],
            allowed=list(sets),
        )
    return [support for card in cards if card.integer(1) in set_numbers for support in _held(card, places)]


def _held(card: Card, places: Mapping[int, Place]) -> Iterable[Support]:
    if card.name == "SPC":
        for at in (2, 5):
            if card.text(at):
                card.must_be(at + 2, (0.0,), "a prescribed motion")
                yield Support(card.integer(at), components(card, at + 1))
        return
    directions = components(card, 2)
    if card.text(4).upper() == "THRU":
        # only existing points of a range, which may be of any length
        first, last = card.integer(3), card.integer(5)
        yield from (Support(number, directions) for number in places if first <= number <= last)
        return
    for at in range(3, len(card.fields) + 1):
        if card.text(at):
            yield Support(card.integer(at), directions)
