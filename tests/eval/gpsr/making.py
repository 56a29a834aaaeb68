"""What the kinds of commands are made with: the words of one derivation, and people and things that it needs."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, TypedDict, Unpack

from engine.robot.company import Gesture, Posture
from tests.eval.gpsr.draw import Drawn
from tests.eval.gpsr.goal import OPERATOR, Goal, Guest, Item, Needs, Side
from tests.eval.gpsr.lexicon import Gender, Language, Lexicon, said

GESTURES: Final[Mapping[str, Gesture]] = {
    "waving": "waving",
    "raising their left arm": "raising the left arm",
    "raising their right arm": "raising the right arm",
    "pointing to the left": "pointing to the left",
    "pointing to the right": "pointing to the right",
}
"""What the grammar's files call the gestures of a scene."""
_GENDERS: Final[tuple[Gender, ...]] = ("female", "male")
GENDERS: Final[Mapping[str, tuple[Gender, bool]]] = {
    "man": ("male", False), "woman": ("female", False), "boy": ("male", True), "girl": ("female", True),
    "men": ("male", False), "women": ("female", False), "boys": ("male", True), "girls": ("female", True),
    "male person": ("male", False), "female person": ("female", False),
    "male": ("male", False), "female": ("female", False),
}  # fmt: skip
"""What words for people mean: their gender, and whether they are children."""
GESTURE_WORDS: Final[Mapping[str, tuple[str, ...]]] = {
    "waving": ("waving", "挥手"), "raising their left arm": ("left arm", "left hand", "左手", "左臂"),
    "raising their right arm": ("right arm", "right hand", "右手", "右臂"),
    "pointing to the left": ("pointing to the left", "pointing left", "左"),
    "pointing to the right": ("pointing to the right", "pointing right", "右"),
    "sitting": ("sitting", "seated", "坐"), "standing": ("standing", "站"), "lying down": ("lying", "躺"),
}  # fmt: skip


class Traits(TypedDict, total=False):
    """What else there is to say of a guest: the fields of :class:`Guest` of the same names."""

    posture: Posture
    gesture: Gesture | None
    known: bool
    is_child: bool
    strays: bool
    leads_to: str
    replies: Mapping[str, str]


class Undrawable(Exception):
    """This combination of words makes no sense in a house; draw another."""


@dataclass(frozen=True, slots=True)
class Order:
    """What a kind of command makes of a derivation."""

    chinese: str
    goal: Goal
    needs: Needs


@dataclass(frozen=True, slots=True)
class Receiver:
    """To whom something is brought or said."""

    key: str
    who: tuple[str, ...]  # words for them
    place: str  # where they are
    chinese: str


@dataclass
class Making:
    """One command in the making. People and things that it needs are added as they are spoken of."""

    drawn: Drawn
    lexicon: Lexicon
    language: Language
    chance: random.Random
    guests: list[Guest] = field(default_factory=list)
    items: list[Item] = field(default_factory=list)
    clear: set[str] = field(default_factory=set)
    blocked: str = ""
    _names: set[str] = field(default_factory=set)

    def order(self, chinese: str, goal: Goal) -> Order:
        needs = Needs(tuple(self.guests), tuple(self.items), frozenset(self.clear), self.blocked)
        return Order(chinese, goal, needs)

    # words

    def here(self, word: str) -> str:
        """A word of the world in the language of the command."""
        return said(word, self.language)

    def thing(self) -> str:
        """The thing that the command speaks of first, in English."""
        return self.drawn.word("object") or self.drawn.fill("object")

    def place(self, kind: str, number: int | None = None) -> str:
        return self.drawn.fill(kind, number)

    # things

    def item(self, name: str, at: str, *, scale: float = 1.0, beside: tuple[Side, str] | None = None) -> str:
        """Put a thing into the house; its key. A second one of the same name gets a number."""
        alike = sum(item.name == name for item in self.items)
        key = self.here(name) if not alike else f"{self.here(name)} {alike + 1}"
        kind = next((ware.category for ware in self.lexicon.wares if ware.name == name), "")
        self.items.append(Item(name, key, at, scale, beside, self.here(kind) if kind else ""))
        return key

    def home(self, name: str, *but: str) -> str:
        """The placement where a thing belongs, or another one, if that is excluded."""
        kept = next(ware.kept for ware in self.lexicon.wares if ware.name == name)
        return kept if kept not in but else self.placement(*but)

    def placement(self, *but: str) -> str:
        """Any placement but these."""
        return self.chance.choice(
            [one.name for one in self.lexicon.locations if one.is_placement and one.name not in but]
        )

    def spot(self, room: str) -> str:
        """A placement in a room, or the room itself for its floor."""
        inside = [one.name for one in self.lexicon.locations if one.is_placement and one.room == room]
        return self.chance.choice([*inside, room])

    def others(self, *but: str, count: int) -> list[str]:
        """So many things, different ones and none of these."""
        free = [ware.name for ware in self.lexicon.wares if not ware.special and ware.name not in but]
        return self.chance.sample(free, count)

    # people

    def guest(self, at: str, called: str | None = None, gender: Gender | None = None, **more: Unpack[Traits]) -> str:
        """Put somebody into the house; their key."""
        chosen = gender if gender is not None else self.chance.choice(_GENDERS)
        if called is None:
            taken = self._names | {filled.value for filled in self.drawn.tree.fills() if filled.slot.kind == "name"}
            called = self.chance.choice([n for n, g in self.lexicon.names if g == chosen and n not in taken])
        self._names.add(called)
        self.guests.append(Guest(at, called, chosen, **more))
        return f"person {len(self.guests)}"

    def named(self, number: int | None, at: str, **more: Unpack[Traits]) -> str:
        """The person whose name the command says."""
        name = self.drawn.filled("name", number)
        return self.guest(at, name.value, name.gender, **more)

    def gesturing(self, word: str, room: str, **more: Unpack[Traits]) -> Receiver:
        """Somebody with a gesture in a room; somebody else is there too, without one."""
        more["gesture"] = GESTURES[word]
        key = self.guest(room, **more)
        if self.chance.random() < 0.5:
            self.guest(room)
        self.clear.add(room)
        chinese = f"{said(room, 'zh')}里{said(word, 'zh')}的人"
        return Receiver(key, GESTURE_WORDS[word], room, chinese)

    def receiver(self) -> Receiver:
        """Who gets what is brought: whoever asked, somebody by name at a place, or somebody described in a room."""
        if self.drawn.has("delivat") or self.drawn.has("delivto"):
            beacon, name = self.place("beacon"), self.drawn.fill("name")
            return Receiver(self.named(None, beacon), (name,), beacon, f"{said(beacon, 'zh')}旁的{name}")
        if self.drawn.has("whowhere"):
            return self.gesturing(self.drawn.fill("gesture"), self.place("room"))
        return Receiver(OPERATOR, ("me", "operator", "我", ""), "", "我")


Kind = Callable[[Making], Order]
"""What the commands of one production mean."""
