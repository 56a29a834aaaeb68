"""What one person wears: what was asked for stays, what was seen is learnt by majority."""

from __future__ import annotations

import pytest

from engine.perception.people import Looks, PersonSeen
from engine.perception.sighting import Colour, Figure, Sighting
from engine.skills.outfit import Glimpses, Outfit

FIRST = PersonSeen(1, None, "grey", "blue", "standing", None, (1.0, 0.0, 0.9), 0.05, 1.7, 0.0)


def sighting(shirt: Colour | None, trousers: Colour | None = None) -> Sighting:
    figure = Figure("standing", None, shirt, trousers)
    return Sighting("person", shirt or "grey", (0, 0, 9, 9), (1.0, 0.0, 0.9), 0.05, (0.4, 1.7), 1.0, 0.0, figure=figure)


def test_a_first_look_that_erred_is_outvoted() -> None:
    outfit = Outfit(FIRST)
    for _ in range(6):
        outfit.learn(sighting("red"))
    assert outfit.shirt == "red"
    assert outfit.trousers == "blue"


def test_a_single_wrong_look_changes_nothing() -> None:
    outfit = Outfit(FIRST)
    outfit.learn(sighting("red"))
    assert outfit.shirt == "grey"


def test_a_colour_that_was_asked_for_is_never_outvoted() -> None:
    outfit = Outfit(FIRST, Looks(shirt="green"))
    for _ in range(60):
        outfit.learn(sighting("orange"))
    assert outfit.shirt == "green"
    assert not outfit.fits(Looks("orange", "blue"))


def test_somebody_fits_by_what_shows_of_them() -> None:
    outfit = Outfit(FIRST)
    assert outfit.fits(Looks("grey", None))
    assert outfit.fits(Looks(None, "blue"))
    assert not outfit.fits(Looks("grey", "black"))
    assert not outfit.fits(Looks(None, None)), "nothing shows of them"


def test_somebody_is_excluded_by_a_colour_that_shows() -> None:
    outfit = Outfit(FIRST)
    assert outfit.excludes(Looks("red", None))
    assert outfit.excludes(Looks("grey", "black"))
    assert not outfit.excludes(Looks(None, "blue"))
    assert not outfit.excludes(Looks())


@pytest.mark.parametrize(
    ("fits", "told"),
    [
        ([True, True, True], False),
        ([True, True, True, True], True),
        ([True, True, False, False, False, True, True, True, True], False),
        ([False, *[True] * 4], True),
    ],
)
def test_who_is_looked_for_is_told_by_most_pictures_of_them(fits: list[bool], told: bool) -> None:
    glimpses = Glimpses()
    for number, one in enumerate(fits):
        glimpses.add((4.0 + 0.05 * number, 1.0), fits=one)
        glimpses.add((1.0, 1.0), fits=not one)
    assert glimpses.tell((4.2, 1.0)) == told
