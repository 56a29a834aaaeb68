"""What acts have at hand while they become actions: the words of this house, what was named before, what is held.

A role that no act has used stops the plan: nothing that was said is left out silently.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import Final

from engine.plan import MAX_ACTIONS, ActionCall
from engine.planner import amounts
from engine.planner.entities import Entities, Entity
from engine.planner.phrases.said import Question
from engine.understanding.acts import RoleName
from engine.understanding.meaning import Do, Role

_VAGUE: Final = re.compile(r"\b(?:some|any)?(?:thing|one|stuff)$|\banother$|东西$|一个$|个$")
"""Ends of what names nothing in particular."""
_ANY_OF: Final = re.compile(
    r"(?:an?|any|some|either)\b(?! (?:other|certain))|随便|任意|任何|一[个只瓶杯盒]|[个只](?=.)"
)
_EITHER: Final = re.compile(r"\bor\b|还是|或者")
_OTHER: Final = re.compile(r"\b(?:an)?other\b|\belse\b|另|别的|其他")
"""One that is not the one that was spoken of."""
_INTO: Final = re.compile(r"(?:back |on )?(?:in|inside|into|onto|on|over|up)(?: there| it)?|[进上过]去|里面|上面")
"""To a place that was named before."""
_WHAT_IS_IN: Final = re.compile(r"what(?:ever)?(?:'s| is) in (?:it|there)")
_HAND: Final = re.compile(r"\b(?:hand|gripper|claw)\b")
_STUFF: Final = re.compile(r"(?:the |this |that |your )?(?:stuff|thing|object|item)|[这那]?个?东西")
_ONE_OF_THEM: Final = re.compile(
    r"(?:one|any|any one|either)(?: of (?:them|those|these))?|一[个只块瓶]|其中一[个只块瓶]"
)
_THE: Final = re.compile(r"(?:the|that|this) (?!other|next)|那[个只块瓶]|这[个只块瓶]")
"""What begins a phrase for something that was spoken of before."""
_FLOOR: Final = re.compile(r"(?:on )?the (?:floor|ground)|地上|地面上?|地板上?")
"""The floor of where the robot has gone."""
_PERSONAL: Final = re.compile(r"him|her|he|she|them|[他她]们?")
MOST: Final = MAX_ACTIONS + 1
"""One more than any plan may have: what is said too often is turned down for its length."""


def is_this_room(words: str) -> bool:
    """Whether it names no more than the room in which the robot is."""
    return _THIS_ROOM.fullmatch(" ".join(words.casefold().split())) is not None


_THIS_ROOM: Final = re.compile(
    r"(?:(?:all of )?(?:the|this|that|my|our) )?(?:whole |entire )?(?:room|area)(?: here)?|in here|"
    r"(?:这个?|那个?|整个)?(?:房间|屋子|屋)"
)


_WHOLE: Final = re.compile(r"\b(?:house|home|flat|apartment|place|floor|building|premises)$|家|房子|屋子|各处|到处")


def is_floor(words: str) -> bool:
    """Whether that is the floor of where the robot is, or has just gone."""
    return _FLOOR.fullmatch(words.casefold().strip()) is not None


def is_everywhere(words: str) -> bool:
    """Whether that is all of the house."""
    return _WHOLE.search(words.casefold()) is not None


WHERE_IT_IS: Final = re.compile(
    r"(?:from )?(?:right )?(?:where |the (?:place|spot|position) (?:where )?)you(?:'re| are)"
    r"(?: (?:now|at|standing|sitting|parked))*|"
    r"(?:from )?(?:your|the) (?:current|present) (?:place|spot|position|location)|"
    r"你(?:现在)?(?:站|停)?(?:着)?的(?:地方|位置)"
)
"""Where the robot stands."""


class Open(Exception):
    """Something that is needed was not said; ``question`` says what. ``vague``: it was said, and could be anything."""

    def __init__(self, question: Question, *, vague: bool = False) -> None:
        super().__init__(question)
        self.question: Question = question
        self.vague = vague


class Which(Exception):
    """Words that fit several things; the message asks which one."""


class NowhereKnown(Exception):
    """A place that this house does not have; ``words`` are the speaker's."""

    def __init__(self, words: str) -> None:
        super().__init__(words)
        self.words = words


class Unable(Exception):
    """It was understood, and no skill does it. ``what`` is a key of ``UNABLE``."""

    def __init__(self, what: str, words: str = "") -> None:
        super().__init__(what)
        self.what = what
        self.words = words


@dataclass(slots=True)
class Doing:
    """The actions of one request, made one after the other: what is named in one act, "it" is in the next."""

    entities: Entities
    holding: str = ""
    named: str = ""
    """The thing that was named last, as skills know it."""
    place: str = ""
    """The symbol of the place that was named last."""
    instead_of: str = ""
    """The thing that a correction has put another one in the place of, in the speaker's words."""
    said: str = ""
    """The request, for what no role has."""
    who: str = ""
    """The person who was named last, as skills know them."""
    there: str = ""
    """Where that person is said to be: a room or a piece of furniture by its name."""
    sought: str = ""
    """The thing that a condition has looked for, as skills know it; "go to it" goes there."""
    seen: tuple[str, ...] = ()
    """The things of this house that fit what a condition has looked for, and were seen."""
    found: str = ""
    """The person whom a condition has looked for or asked, as skills know them."""
    depends: bool = False
    """Whether it is done because a condition held: "in" and "on it" are then where that was."""
    greeting: str = "Hello."
    """In the speaker's language."""
    located: dict[str, str] = field(default_factory=dict)
    """Things that are said to be somewhere, as skills know them, and what that place is called: of several that are
    called so it is the one there."""
    calls: list[ActionCall] = field(default_factory=list)
    last: tuple[ActionCall, ...] = ()
    """Those of the last act."""

    def entity(self, words: str) -> Entity:
        """What ``words`` name. Raises Which where they fit several."""
        if _EITHER.search(words.casefold()):
            raise Open("what_do")
        found = self.entities.of(words)
        if found.held:
            found = replace(found, which="")
        if self.depends and _INTO.fullmatch(words.casefold().strip()):
            return Entity(words, refers=True)
        if found.which and _ANY_OF.match(words.casefold()):  # any of them will do
            return replace(found, which="", thing=self.entities.near(words))
        if found.which:
            raise Which(found.which)
        return found

    def went(self, act: Do) -> None:
        """From now on "there" is where that act was."""
        places = (self.entities.of(words).place for name in ("source", "place") for words in act.all(name))
        self.place = next((place for place in reversed(list(places)) if place), self.place)

    def where(self, words: str) -> Entity:
        """What words for a place name; "there" is the place that was named last."""
        found = self.entity(words)
        return self.entities.of(self.entities.place_name(self.place)) if found.refers and self.place else found

    def thing(self, words: str) -> str:
        """A thing as skills know it; "it" is what was named last. An unknown one is given on as it was said: whoever
        checks it says what is known."""
        if self.named and (alike := self.entities.like(words, self.named)) is not None:
            self.named = alike
            return alike
        if self.sought and _ONE_OF_THEM.fullmatch(words.casefold().strip()):
            self.named = self.seen[0] if self.seen else self.sought  # "if there are cups on it, bring one"
            return self.named
        if self.sought and not self.who and _PERSONAL.fullmatch(words.casefold().strip()):
            return self.sought  # "if the teddy is there, bring him": nobody else was spoken of
        found = self.entity(words)
        if found.vague:
            raise Open("which_thing")
        if found.held and self.in_hand and (found.refers or self._is_in_hand(found)):
            self.named = self.in_hand
            return self.named
        if self.in_hand and _WHAT_IS_IN.fullmatch(words.casefold()) and _HAND.search(self.said.casefold()):
            self.named = self.in_hand
            return self.named
        if found.thing == "thing" and self.in_hand and _STUFF.fullmatch(words.casefold().strip()):
            self.named = self.in_hand  # "put the stuff in the study", with something in the hand
            return self.named
        if found.refers:
            if not (self.named or self.holding):
                raise Open("which_thing")
            return self.named or self.holding
        if found.person and found.thing is None:
            raise Unable("person", words)
        if found.superlative or (found.thing is None and _VAGUE.search(words.casefold())):
            raise Open("which_thing")
        if not (_THE.match(words.casefold()) and self.named and self.entities.may_be(words, self.named)):
            self.named = self._seen(words) or found.thing or self.entities.near(words)
        return self.named  # "the box" is the blue box, after that was spoken of

    def _is_in_hand(self, thing: Entity) -> bool:
        """Whether what the hand holds may be called so."""
        held = self.in_hand
        return held == thing.thing or self.entities.may_be(thing.words, held)

    def thing_from(self, words: str, source: str) -> str:
        """A thing that is said to be somewhere: of several that are called so it is the one there."""
        found = self.entities.of(words)
        at = self.entities.of(source) if source else found.at
        thing = self.thing(words)
        if at is not None and at.place is not None and not at.refers:
            self.located[thing] = at.surface or at.room or self.entities.place_name(at.place)
        return thing

    def _seen(self, words: str) -> str:
        """The only one of the things that words fit which was seen; nothing where there are several or none."""
        if not self.seen or _OTHER.search(words.casefold()):
            return ""
        meant = [name for name in self.entities.fitting(words) if name in self.seen]
        return meant[0] if len(meant) == 1 else ""

    def spot(self, words: str) -> str:
        """The symbol of a place to drive to. Raises NowhereKnown."""
        found = self.entity(words)
        if self.place and is_floor(words):
            return self.place
        if found.refers and self.place:
            return self.place
        if found.place is not None and found.superlative and _OTHER.search(words.casefold()):
            raise Open("where", vague=True)  # "the other table"
        nowhere = found.place is None and (found.superlative or is_this_room(words))
        if found.vague or found.refers or found.side or nowhere:
            raise Open("where", vague=True)
        if found.place is None:
            if found.person:
                raise Unable("person", words)
            raise NowhereKnown(self.entities.near(words))
        self.place = found.place
        return found.place

    def held(self, thing: str) -> bool:
        """Whether that thing is in the hand, or will be by then."""
        return bool(self.in_hand) and (thing == self.in_hand or self.in_hand.endswith(f" {thing}"))

    @property
    def in_hand(self) -> str:
        """What the gripper holds after the calls so far."""
        held = self.holding
        for made in self.calls:
            if made.name == "pick_object":
                held = str(made.positional[0])
            elif made.name == "take_from":
                held = str(made.positional[1]) if len(made.positional) > 1 else "thing"
            elif made.name in _LETS_GO:
                held = ""
        return held


_LETS_GO: Final = frozenset({
    "place_object", "place_in_bin", "putdown", "open_gripper", "carry", "hand_over", "serve",
})  # fmt: skip
"""Skills after which nothing is held."""


def _says_nothing(role: Role) -> bool:
    """Whether an act is the same without it: how it is done is left to the skill, and once is how often."""
    return role.name == "manner" or (role.name == "times" and amounts.times(role.words) == 1)


class Roles:
    """The roles of an act; each one that is asked for counts as used."""

    def __init__(self, act: Do) -> None:
        self.act = act
        self._used: list[Role] = []

    def words(self, name: RoleName) -> str:
        """The words of the first role of this name; a second one is not used by that."""
        first = next((role for role in self.act.roles if role.name == name), None)
        if first is None:
            return ""
        self._used.append(first)
        return first.words

    def all(self, name: RoleName) -> tuple[str, ...]:
        found = [role for role in self.act.roles if role.name == name]
        self._used += found
        return tuple(role.words for role in found)

    def must_be_used(self) -> None:
        """Raises Unable where a role is left over. How gently something is done may be left to the skill."""
        left = next((role for role in self.act.roles if role not in self._used and not _says_nothing(role)), None)
        if left is not None:
            raise Unable("role", left.words)
