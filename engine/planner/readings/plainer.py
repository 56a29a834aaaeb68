"""Ways to put a request that take more words than it needs: "the doorway of the kitchen", "the box that is red".

Each has one meaning in this house and is only put in its words: the name that the map has for the place, the colour in
front of the thing, the way to whoever is to be told something. Nothing is guessed where there is no such name.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from engine.perception.naming import KINDS
from engine.planner.readings.corrections import LONGEST, QUOTES
from engine.planner.readings.presence import COLOURS
from engine.planner.readings.rewording import Rewordings, names
from engine.planner.request import Language
from engine.planner.text.language import load
from engine.skills.vocabulary import Vocabulary

_ONES: Final = ("one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
_TENS: Final = {
    "ten": 10, "fifteen": 15, "twenty": 20, "twenty-five": 25, "thirty": 30, "forty": 40, "fifty": 50, "sixty": 60,
    "seventy": 70, "seventy-five": 75, "eighty": 80, "ninety": 90,
}  # fmt: skip
_THINGS: Final = ("box", "cube", "ball", "cup", "mug", "bottle", "block", *KINDS)


class Plainer:
    """Knows the places of one house."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        rooms = [name for name in vocabulary.rooms() if name.isascii() and len(name) > 1]
        known = {name.casefold() for name in (*vocabulary.places(), *vocabulary.surfaces()) if len(name) > 1}
        furniture = [name for name in known if name.isascii() and name not in rooms]
        doors = [name.removesuffix(" door") for name in known if name.endswith(" door")]
        self._past = Rewordings("en", {}).section("past")
        house = {
            "room": names(rooms),
            "furniture": names(furniture),
            "stop_name": names((*furniture, *rooms)),
            "door": names(doors),
            "thing": names(_THINGS),
            "colour": COLOURS,
            "one": names(_ONES),
            "ten": names(_TENS),
            "past": names(self._past),
        }
        rewordings = Rewordings("en", house)
        self._plainer, self._in_any_case = rewordings.rules("plainer"), rewordings.rules("in_any_case")
        self._metre_and, self._passive = rewordings.pattern("metre_and"), rewordings.pattern("passive")
        self._if_you = rewordings.pattern("if_you")
        self._first_past, self._next_past = rewordings.pattern("first_past"), rewordings.pattern("next_past")
        self._itinerary, self._stop = rewordings.pattern("itinerary"), rewordings.pattern("stop")
        self._joint = rewordings.pattern("joint")
        self._bedside = rewordings.pattern("bedside") if "bedside table" in known else None
        place_zh = names(name for name in (*known, *vocabulary.rooms()) if not name.isascii())
        self._chinese = Rewordings("zh", {"place": place_zh}).rules("plainer")

    def of(self, text: str, language: Language) -> Iterator[str]:
        """``text`` in plainer words; nothing where it has none."""
        if len(text) > LONGEST or QUOTES.search(text):
            return
        if language == "zh":
            yield from (plain for rule in self._chinese if (plain := rule.everywhere(text)) != text)
            return
        if route := self._route(text):
            yield route
        plain = self._actively(self._asked_to(text))
        for rule in self._plainer:
            plain = rule.everywhere(plain)
        plain = self._metre_and.sub(_in_metres, plain)
        if self._bedside is not None:
            plain = self._bedside.sub("bedside table", plain)
        if plain != text:
            yield plain

    def in_any_case(self, text: str) -> Iterator[str]:
        """``text`` where it means something else than its words one by one; nothing elsewhere."""
        if len(text) <= LONGEST and not QUOTES.search(text):
            yield from (plain for rule in self._in_any_case if (plain := rule.everywhere(text)) != text)

    def _route(self, text: str) -> str:
        """The journey that a mere list of places stands for; empty for anything else: one place alone may be an answer
        or half a sentence."""
        parts = [
            self._stop.fullmatch(part.strip()) for part in self._joint.split(self._itinerary.sub("", text.strip(" .!")))
        ]
        if len(parts) < 2 or None in parts:
            return ""
        return ", then ".join(f"go to the {part['name']}" for part in parts if part is not None)

    def _asked_to(self, text: str) -> str:
        """What somebody would be grateful for ("if you went there") as a command."""
        request = self._if_you.sub("", text)
        if request == text or (found := self._first_past.match(request)) is None:
            return text
        request = f"{self._past[found['verb'].casefold()]}{request[found.end() :]}"
        return self._next_past.sub(lambda more: f"{more['joint']}{self._past[more['verb'].casefold()]}", request)

    def _actively(self, text: str) -> str:
        """What is to be done to a thing ("could the box be moved to the desk") as a command."""
        found = self._passive.match(text.strip(" .!?"))
        verb = load("en")["done"].get(found["done"].casefold()) if found is not None else None
        if found is None or not isinstance(verb, str):
            return text
        return f"{verb} {found['what'] or found['thing']}{found['rest'] or ''}"


def _in_metres(found: re.Match[str]) -> str:
    """A measure such as "one metre twenty" in metres."""
    metres, cm = found["metres"].casefold(), found["cm"].casefold()
    whole = _ONES.index(metres) + 1 if metres in _ONES else int(metres)
    return f"{whole + (_TENS[cm] if cm in _TENS else int(cm)) / 100:g} metres"
