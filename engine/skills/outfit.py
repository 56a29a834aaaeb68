"""What one person wears who is followed or guided, and whether somebody seen can be that person.

Colours that were asked for ("the person in blue") are certain. Others are learnt by majority, from sightings of a
person who stands apart from everybody else: beside other people a sighting may be of them.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from typing import Final

from engine.perception.people import Looks, PersonSeen, most_voted
from engine.perception.sighting import Colour, Sighting

_FIRST: Final = 5
"""Sightings that the first look counts for."""
_MOST: Final = 60
"""Sightings of one colour that count."""
_ENOUGH, _SURELY, _ASIDE = 4, 0.75, 0.6
"""Pictures that tell who is there, the part of them that must fit, and m between two of the same person."""


def clothes_of(sighting: Sighting) -> Looks:
    """The colours of shirt and trousers, as far as they show."""
    figure = sighting.figure
    return Looks(sighting.colour) if figure is None else Looks(figure.shirt, figure.trousers)


class Outfit:
    """The clothes of one person."""

    def __init__(self, person: PersonSeen, asked: Looks | None = None) -> None:
        """``person``: as they were seen first. ``asked``: the colours that were asked for."""
        self._asked = asked or Looks()
        self._shirts: Counter[Colour] = Counter({person.shirt: _FIRST} if person.shirt else {})
        self._trousers: Counter[Colour] = Counter({person.trousers: _FIRST} if person.trousers else {})

    @property
    def shirt(self) -> Colour | None:
        """Its colour; None where no sighting has shown it."""
        return self._asked.shirt or most_voted(self._shirts)

    @property
    def trousers(self) -> Colour | None:
        """Their colour; None where no sighting has shown them."""
        return self._asked.trousers or most_voted(self._trousers)

    def learn(self, sighting: Sighting) -> None:
        """This was the person, and nobody else was near."""
        seen = clothes_of(sighting)
        for votes, colour in ((self._shirts, seen.shirt), (self._trousers, seen.trousers)):
            if colour is not None and votes[colour] < _MOST:
                votes[colour] += 1

    def fits(self, seen: Looks) -> bool:
        """Whether nothing that shows is another colour, and something shows; anybody fits who has shown nothing yet."""
        pairs = self._shown(seen)
        return all(a == b for a, b in pairs) and (bool(pairs) or self.shirt is None)

    def fits_surely(self, seen: Looks) -> bool:
        """The same, and the shirt shows: trousers of one colour are worn by many."""
        return self.fits(seen) and (self.shirt is None or seen.shirt is not None)

    def excludes(self, seen: Looks) -> bool:
        """Whether something shows that is another colour."""
        return any(a != b for a, b in self._shown(seen))

    def _shown(self, seen: Looks) -> list[tuple[Colour, Colour]]:
        """What shows and is known, with the colour that it should have."""
        pairs = ((seen.shirt, self.shirt), (seen.trousers, self.trousers))
        return [(a, b) for a, b in pairs if a is not None and b is not None]

    def worn_since(self, t: float, people: Iterable[PersonSeen]) -> list[PersonSeen]:
        """Those of ``people`` who surely fit and were seen after ``t`` (robot time, s)."""
        return [p for p in people if p.seen_at > t and self.fits_surely(Looks(p.shirt, p.trousers))]


class Glimpses:
    """Who fitted in the pictures of a search, and where. One picture may show a colour wrong; most do not."""

    def __init__(self) -> None:
        self._all: list[tuple[tuple[float, float], bool]] = []

    def add(self, spot: tuple[float, float], *, fits: bool) -> None:
        """A picture has shown somebody there, map frame, m."""
        self._all.append((spot, fits))

    def tell(self, spot: tuple[float, float]) -> bool:
        """Whether it is clear by now that whoever is there fits."""
        there = [fits for where, fits in self._all if math.dist(where, spot) < _ASIDE]
        return len(there) >= _ENOUGH and sum(there) >= _SURELY * len(there)
