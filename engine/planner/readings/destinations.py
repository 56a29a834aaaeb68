"""Journeys that are not ordered as such: "your next stop is the hall", "we need you where the bed is".

A place is known by its name, by the furniture that stands in it ("the room with the desk"), and by what people do
there ("where we cook"), as far as the house has one room of that name. Any word for moving will do in front of a place
("amble over to the sofa"); words that mean something else there are listed.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from engine.planner.readings.consequences import VERBS
from engine.planner.readings.rewording import Rewordings, names
from engine.skills.vocabulary import Vocabulary

_GO: Final = "go to the {place}"
_CHARGERS: Final = ("charging dock", "charging station", "charger")


class Destinations:
    """Knows the places of one house."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        known = {name.casefold() for name in (*vocabulary.places(), *vocabulary.rooms())}
        places = {name for name in known if len(name) > 1 and name.isascii()}
        furniture = {piece: vocabulary.room_of(piece) for piece in (*vocabulary.surfaces(), *places)}
        self._rooms = {piece: room for piece, room in furniture.items() if room}
        self._charges = next((name for name in _CHARGERS if name in places), "")
        house = {"place_name": names(places), "piece": names(filter(str.isascii, self._rooms)), "verb": VERBS}
        rewordings = Rewordings("en", house)
        self._journeys = rewordings.rules("journeys", frame="<opened>{}( <afterwards>)*", keeps="{first}", say=_GO)
        self._routes = rewordings.rules("routes")
        self._stay, self._round_trip = rewordings.pattern("stay"), rewordings.pattern("round_trip")
        self._room_with, self._charging_place = rewordings.pattern("room_with"), rewordings.pattern("charging_place")
        self._go_the, self._towards = rewordings.pattern("go_the"), rewordings.pattern("towards")
        self._uses = tuple(
            (Rewordings("en", {"use": "|".join(use["does"])}).pattern("use"), there[0])
            for use in rewordings.section("uses")
            if len(there := [place for place in use["where"] if place in places]) == 1
        )

    def journey(self, clause: str) -> str:
        """The clause as an order to go somewhere; empty where it is none."""
        plain = self._by_name(clause)
        journey = next(filter(None, (rule.whole(plain) for rule in self._journeys)), "")
        return journey or (plain if plain != clause else "")

    def stay(self, clause: str) -> str:
        """The journey that a mere place in front of other clauses stands for ("in the hall, beep")."""
        found = self._stay.fullmatch(self._by_name(clause))
        return "" if found is None else f"go to the {found['place']}"

    def routes(self, text: str) -> Iterator[str]:
        """Journeys by way of another place, there and back, or away from one to the next."""
        if found := self._round_trip.fullmatch(text):
            back = ", then come back" if found["round"] or found["back"] else ""
            yield f"{found['first']}go to the {found['place']}{back}{found['rest']}"
        yield from (plain for rule in self._routes if (plain := rule.everywhere(text)) != text)

    def _by_name(self, clause: str) -> str:
        """With the name of the room that is told by its furniture or its use."""
        plain = self._room_with.sub(
            lambda found: f"the {self._rooms[(found['piece'] or found['thing']).casefold()]}", clause
        )
        for use, room in self._uses:
            if (found := use.search(plain)) is not None:
                at = "" if self._towards.search(plain[: found.start()]) else "at "
                plain = f"{plain[: found.start()]}{at}the {room}{plain[found.end() :]}"
        if self._charges:
            plain = self._charging_place.sub(f"the {self._charges}", plain)
        return self._go_the.sub(r"\g<go> to ", plain) if plain != clause else clause
