"""What a plan comes to for people and things, whichever skills it is written with, and whether that was wanted.

``carry(coke, counter)`` and ``pick_object(coke); navigation(counter); putdown()`` come to the same two acts. Where an
argument is left open, it is what the plan was last concerned with: the person that was found, the place gone to.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from config.schema import Place
from engine.errors import PlanError
from engine.perception.naming import UnknownObject, wanted
from engine.robot.sim.scene import Scene
from tests.eval.gpsr.goal import Want, What
from tests.eval.gpsr.lexicon import CHINESE

Called = tuple[str, Mapping[str, object]]
"""A call of a skill: its name, and its arguments by name."""

_SKILLS: Final[Mapping[str, tuple[What, ...]]] = {
    "pick_object": ("pick",), "grasp_obj": ("pick",), "carry": ("pick", "put"), "place_object": ("put",),
    "putdown": ("put",), "place_in_bin": ("put",), "hand_over": ("give",), "take_from": ("take",),
    "bring": ("pick", "give"), "navigation": ("go",), "navigate_to_object": ("find",), "locate": ("find",),
    "find_person": ("find",), "meet": ("find",), "person_follow": ("follow",), "guide": ("guide",), "tell": ("tell",),
    "tell_everyone": ("tell",),
    "say": ("tell",), "ask": ("ask",), "ask_person": ("ask",), "ask_user": (),
    "answer_question": ("ask", "tell"), "report_answer": ("tell",), "learn_name": (),
    "count_people": ("look",), "describe_person": ("look",),
    "count": ("look",), "scan_room": ("look",), "seewhat": ("look",), "look": ("look",), "clean_room": ("clean",),
    "clear_rubbish": ("clean",),
    "tidy": ("clean",), "list_things": ("look", "find"), "serve": ("pick", "give"),
}  # fmt: skip
_TELLING: Final = re.compile(r"tell|say|answer|introduce|report|joke")
_LOOKING: Final = re.compile(r"count|describe|compare|look|find|search|which")
_WHO, _THING, _PLACE = ("who", "person"), ("object", "thing"), ("place", "surface", "room", "where", "to")
_ANYBODY: Final = frozenset({"", "it", "him", "her", "them", "he", "she", "they", "他", "她", "它", "他们", "not said"})
_MATTERS: Final = frozenset({"pick", "put", "give", "take", "follow", "guide", "clean"})
"""Acts that change something: one that nobody wanted is a fault."""


@dataclass(frozen=True, slots=True)
class Act:
    """One thing that a plan does; an empty field was left open, and nothing before says what it is."""

    what: What
    who: str = ""
    thing: str = ""
    place: str = ""
    call: str = ""  # all of it, as it was called


def acts_of(calls: Iterable[Called]) -> tuple[Act, ...]:
    """What calls of skills come to, with what they leave open."""
    found: list[Act] = []
    who = thing = place = ""
    for name, args in calls:
        said_who, said_thing, said_place = (_argument(args, names) for names in (_WHO, _THING, _PLACE))
        who = said_who if said_who not in _ANYBODY else who
        thing = said_thing if said_thing not in _ANYBODY else thing
        if name == "place_in_bin":
            said_place = "bin"
        place = said_place if said_place not in _ANYBODY else place
        call = " ".join((name, *map(str, args.values()))).casefold()
        for what in _whats(name):
            concerned = who if what not in ("pick", "put", "go", "clean") else ""
            found.append(Act(what, concerned, thing if what in ("pick", "give") else said_thing, place, call))
    return tuple(found)


def _whats(name: str) -> tuple[What, ...]:
    if name in _SKILLS:
        return _SKILLS[name]
    if _TELLING.search(name):
        return ("tell",)
    return ("look",) if _LOOKING.search(name) else ()


def _argument(args: Mapping[str, object], names: Sequence[str]) -> str:
    return next((str(args[name]).casefold().strip() for name in names if name in args), "")


class Names:
    """What the words of plans stand for in a house."""

    def __init__(self, scene: Scene, places: Mapping[str, Place]) -> None:
        self._scene = scene
        self._places = {symbol.casefold(): place.name for symbol, place in places.items()}
        called = [(name, room.aliases) for name, room in scene.rooms.items()]
        called += [(name, piece.aliases) for name, piece in scene.furniture.items()]
        called += [(name, place.aliases) for name, place in scene.places.items()]
        self._places |= {word.casefold(): name for name, aliases in called for word in (name, *aliases)}

    def place(self, word: str) -> str:
        """The one name of a place, whatever it was called."""
        return self._places.get(word.removeprefix("the "), word)

    def room(self, place: str) -> str:
        """The room that a place is in; empty where there is none."""
        if place in self._scene.rooms:
            return place
        at = self._scene.furniture[place].at if place in self._scene.furniture else None
        at = self._scene.places[place].at if at is None and place in self._scene.places else at
        return next((name for name, room in self._scene.rooms.items() if at and room.contains(*at)), "")

    def things(self, word: str) -> frozenset[str]:
        """Every thing that a word may mean: by name, or by what it looks like."""
        plain = word.removeprefix("the ")
        if plain in self._scene.objects:
            alike = {name for name in self._scene.objects if re.fullmatch(rf"{re.escape(plain)}( \d+)?", name)}
            return frozenset(alike)
        try:
            meant = wanted(plain)
        except (UnknownObject, PlanError):
            return frozenset()
        looks = {
            name: wanted(f"{o.colour} {o.kind}") for name, o in self._scene.objects.items() if o.kind != "tag_block"
        }
        return frozenset(name for name, look in looks.items() if meant.covers(look))


def unwanted(wants: Sequence[Want], acts: Sequence[Act], names: Names) -> tuple[str, ...]:
    """What is wrong with a plan: wants that it does not come to in their order, and acts that nobody wanted."""
    found = []
    rest = list(acts)
    for want in wants:
        index = next((index for index, act in enumerate(rest) if fits(want, act, names)), None)
        if index is None:
            found.append(f"does not {'/'.join(want.what)} {_told(want)}".strip())
        else:
            rest = rest[index + 1 :]
    for act in acts:
        if act.what in _MATTERS and not any(fits(want, act, names) for want in wants):
            found.append(" ".join(filter(None, ("does", act.what, act.who or act.thing, act.place))))
    return tuple(found)


def fits(want: Want, act: Act, names: Names) -> bool:
    """Whether an act is what is wanted, as far as it says."""
    if act.what not in want.what:
        return False
    if want.about and not any(part in act.call for part in want.about):
        return False
    if want.things and act.thing and not names.things(act.thing) & set(want.things):
        return False
    if want.who and act.what not in ("put", "pick", "go") and not _is_one_of(act.who, want.who):
        return False
    if want.places and act.what not in ("give", "tell", "ask", "pick"):
        place = names.place(act.place)
        near = {names.room(wanted_place) for wanted_place in want.places} if act.what in ("find", "look") else set()
        return place == "" or place in want.places or place in near or names.room(place) in want.places
    return True


def _is_one_of(who: str, words: Sequence[str]) -> bool:
    return any(word == who if not word else has(who, word) or has(who, _GROWN.get(word, word)) for word in words)


_GROWN: Final = {"girl": "woman", "boy": "man", "male person": "man", "female person": "woman"}
"""What a robot that tells no ages calls them."""


def has(text: str, word: str) -> bool:
    """Whether a text has a word; a Chinese one anywhere."""
    if not word.isascii():
        return word in text
    return re.search(rf"(?<![a-z]){re.escape(word.casefold())}(?![a-z])", text.casefold()) is not None


def _told(want: Want) -> str:
    names = [
        CHINESE.get(word, word) if not word.isascii() else word for word in (*want.who, *want.things, *want.places)
    ]
    return "|".join(name for name in names if name)
