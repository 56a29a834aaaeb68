"""Telling people what a plan does: one sentence for each step, and one short answer for all of it.

The words come from the phrase file, the facts from the actions themselves, so that what is announced is what is done.
What skills know by its English name is told by the one it has in the language of the answer, where there is one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

from config.schema import Place
from engine.han import is_chinese
from engine.plan import ActionCall, Quantity
from engine.planner.text.words import digits
from engine.skills.places import ZERO_SYMBOL
from engine.skills.vocabulary import Vocabulary

MAX_TOLD = 4
"""More things than these are not listened to in one answer."""


class Answers:
    """The answers of one language."""

    def __init__(self, sections: Mapping[str, Any], places: Mapping[str, Place], vocabulary: Vocabulary) -> None:
        self._words: Mapping[str, Any] = sections["answers"]
        self._chinese = sections["language"] == "zh"
        self._vocabulary = vocabulary
        self._places = {symbol: self._name((place.name, *place.aliases)) for symbol, place in places.items()}
        name = next(iter(self._places.values()), "")
        self.understood: str = self._words["understood" if name else "understood_anywhere"].format(place=name)
        """A sentence with examples of what can be said."""
        self._example_place = name

    @property
    def places(self) -> tuple[str, ...]:
        """Names of the places on the map."""
        return tuple(self._places.values())

    def phrase(self, key: str) -> str:
        """A fixed sentence."""
        return str(self._words[key])

    def question(self, key: str) -> str:
        """The question for what is missing in a command."""
        return str(self._words["questions"][key]).format(place=self._example_place)

    def steps(self, calls: Iterable[ActionCall]) -> tuple[str, ...]:
        """One sentence for each action."""
        full_stop = self._words["sentence"].format(told="")
        return tuple(
            self._words["together_step"].format(step=self._tell(call, 0).removesuffix(full_stop))
            if call.alongside
            else self._tell(call, 0)
            for call in calls
        )

    def response(self, calls: Sequence[ActionCall]) -> str:
        """What the robot is about to do, in one sentence; empty where the actions speak for themselves."""
        told = [(call, text) for call in calls if (text := self._tell(call, 1))]
        parts: list[tuple[str, str]] = []  # what joins it to the one before, and the part
        for text, group in groupby(told, key=lambda one: one[1]):
            same = list(group)
            times = self._words["times"].format(count=len(same)) if len(same) > 1 else ""
            parts.append((self._words["together" if same[0][0].alongside else "then"], text + times))
        more = ""
        if len(parts) > MAX_TOLD:
            more = self._words["more"].format(count=len(parts) - MAX_TOLD + 1)
            parts = parts[: MAX_TOLD - 1]
        sentence = "".join(joint + part for joint, part in parts)[len(parts[0][0]) :] + more if parts else ""
        return str(self._words["sentence"]).format(told=f"{sentence[0].upper()}{sentence[1:]}") if sentence else ""

    def _tell(self, call: ActionCall, form: int) -> str:
        name, fields = self._fields(call)
        pattern: str = self._words["skills"][name][form]
        return pattern.format_map(fields)

    def _fields(self, call: ActionCall) -> tuple[str, dict[str, str]]:
        """Under which name the call is told, and the words for its arguments."""
        match call.name, call.positional:
            case "move_forward" | "move_sideways", (Quantity(distance), *speed):
                ways = ("forward", "back") if call.name == "move_forward" else ("left", "right")
                way = self._words["ways"][ways[distance < 0]]
                return call.name, {"distance": self._amount(abs(distance), "m"), "way": way, "at": self._at(speed)}
            case "move_left" | "move_right", (Quantity(angle), *speed):
                return call.name, {"angle": self._amount(angle, "deg"), "at": self._at(speed)}
            case "set_cmdvel", (Quantity(x), Quantity(y), Quantity(turn), Quantity(duration)):
                lasting = self._amount(duration, "s")
                if turn:
                    way = self._words["ways"]["left" if turn > 0 else "right"]
                    return "spin_for", {"way": way, "speed": self._amount(abs(turn), "rad/s"), "duration": lasting}
                axis = ("left" if y > 0 else "right") if y else ("forward" if x >= 0 else "back")
                speed_said = self._amount(abs(x + y), "m/s")  # one of the two is zero
                return "drive_for", {"way": self._words["ways"][axis], "speed": speed_said, "duration": lasting}
            case "navigation", (str(place),):
                return call.name, {"place": self._place(place)}
            case "patrol", (str(places),):
                *others, last = [self._place(symbol) for symbol in places.split(",")]
                listed = self._words["and"].join([self._words["comma"].join(others), last] if others else [last])
                return "patrol_places", {"places": listed}
            case "wait", (Quantity(duration),):
                return call.name, {"duration": self._amount(duration, "s")}
            case "light", ("off",):
                return "light_off", {}
            case _ if (told := self._errand(call)) is not None:
                return told
            case _, (str(word),):
                return call.name, {"word": word if call.name == "say" else self._word(word)}
        return call.name, {}

    def _errand(self, call: ActionCall) -> tuple[str, dict[str, str]] | None:
        """The same for what is done with things."""
        words: Mapping[str, str] = self._words["things"]
        match call.name, call.positional:
            case "carry", (str(thing), str(place), *source):
                fields = {"thing": self._thing(thing), "place": self._place(place)}
                if source:
                    return "carry_from", {**fields, "surface": self._surface(str(source[0]))}
                return "carry", fields
            case "tidy", (str(colour), "bin"):
                return "tidy_bin", {"word": self._word(colour)}
            case "tidy", (str(colour), str(surface)):
                return "tidy", {"word": self._word(colour), "surface": self._surface(surface)}
            case "place_object", (str(surface),):
                return call.name, {"surface": self._surface(surface)}
            case "pick_object" | "locate" | "navigate_to_object", (str(thing),):
                return call.name, {"thing": self._thing(thing)}
            case "scan_room" | "clean_room", room:
                return call.name, {"room": self._called(str(room[0])) if room else words["room"]}
            case "follow_line" | "follow_line_clear", colour:
                line = words["coloured_line"].format(word=self._word(str(colour[0]))) if colour else words["line"]
                return call.name, {"line": line}
            case "apriltag_follow" | "apriltag_sort", (Quantity(number),):
                return call.name, {"tag": words["tag"].format(number=digits(number))}
            case "apriltag_follow", ():
                return call.name, {"tag": words["any_tag"]}
            case "apriltag_remove_higher", (Quantity(height),):
                return call.name, {"higher": words["higher"].format(height=self._amount(height, "m"))}
            case "color_remove_higher", (str(colour), Quantity(height)):
                higher = words["higher"].format(height=self._amount(height, "m"))
                return call.name, {"word": self._word(colour), "higher": higher}
            case "servo1_move", (Quantity(angle),):
                return call.name, {"angle": self._amount(angle, "deg")}
        return None

    def _thing(self, thing: str) -> str:
        """With its article; what has a number has a name."""
        words: Mapping[str, str] = self._words["things"]
        if thing[-1:].isdigit():
            return words["numbered"].format(thing=thing, number=thing.rpartition(" ")[2])
        translated = (self._word(word) for word in thing.split())
        return words["thing"].format(thing=("" if self._chinese else " ").join(translated))

    def _surface(self, name: str) -> str:
        """A piece of furniture with its article."""
        called = self._called(name)
        return called if called[-1:].isdigit() else str(self._words["things"]["thing"].format(thing=called))

    def _word(self, word: str) -> str:
        """A colour or a kind."""
        return str(self._words["words"].get(word, word))

    def _called(self, name: str) -> str:
        """What a piece of furniture or a room is called."""
        if not self._chinese or name in self._words["words"]:
            return self._word(name)
        return self._name(self._vocabulary.words_for(name))

    def _name(self, names: Sequence[str]) -> str:
        """The one of several names that is in the language of the answers; else the first."""
        return next((name for name in names if is_chinese(name)), names[0]) if self._chinese else names[0]

    def _at(self, speed: Sequence[object]) -> str:
        match speed:
            case [Quantity(value, unit)]:
                return str(self._words["at"].format(speed=self._amount(value, unit)))
        return ""

    def _amount(self, value: float, unit: str) -> str:
        if unit == "m" and value < 1 and (value * 100).is_integer():
            value, unit = value * 100, "cm"
        one, many = self._words["units"][unit]
        told = round(value, 2) or value  # nobody listens to a tenth of a millimetre
        return str(self._words["amount"]).format(number=digits(told), unit=one if value == 1 else many)

    def _place(self, symbol: str) -> str:
        if symbol not in self._places:  # in some worlds, where the speaker is
            remembered = self._vocabulary.resolvers()["place"](ZERO_SYMBOL) == ZERO_SYMBOL
            return str(self._words["zero" if remembered else "person"])
        name = self._places[symbol]
        pattern = self._words["place_symbol" if len(name) == 1 and name.isascii() else "place"]
        return str(pattern.format(name=name.removeprefix("the ")))
