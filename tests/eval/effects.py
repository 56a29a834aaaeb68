"""What a plan comes to: the same few effects, whichever skills it is written with.

``carry(cup, kitchen)`` and ``navigation(stool); locate(cup); pick_object(cup); navigation(kitchen); putdown()`` come to
the same: the cup is picked up and put down in the kitchen. Steps that the following ones include (going to where
something is put, looking for what is picked up) are marked, so that they may be there or not.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, NamedTuple, Protocol

Value = str | float
How = Literal["on", "floor", "any"]
"""How a thing is put at a place: on (or in) it, on the floor there, or either."""
ZERO: Final = "zero"
FLOOR: Final = "floor"
BIN: Final = "bin"
STILL: Final = frozenset({"say", "beep", "wait", "light", "arm_up", "arm_down", "arm_nod", "arm_shake", "arm_applaud"})
"""Effects that leave the robot where it is."""
WITH: Final = frozenset({
    "tell", "ask_person", "person_follow", "guide", "hand_over", "take_from", "describe_person", "answer_question",
    "with", "arm_shake", "say",
})  # fmt: skip
"""Effects for which the robot goes to somebody first."""
MERGED: Final = frozenset({"turn", "drive", "slide", "wait"})
"""Two of these in a row, the same way, are one."""


class Step(NamedTuple):
    """One call: the name of a skill, and its arguments in the order of its parameters, as far as they are given."""

    name: str
    args: tuple[Value, ...] = ()
    needed: bool = True


@dataclass(frozen=True, slots=True)
class Effect:
    """One thing that happens. Lengths in m, angles in deg, both positive to the front and the left."""

    what: str
    args: tuple[Value, ...] = ()
    pace: Value | None = None  # m/s or rad/s, where a speed is asked for
    how: How = "any"
    needed: bool = True


class Words(Protocol):
    """What the words of a world stand for."""

    def place(self, word: str) -> str:
        """The one name of a place, whatever it was called."""
        ...

    def room(self, place: str) -> str:
        """The room that a place is in; empty where nobody knows."""
        ...

    def things(self, word: str) -> frozenset[str]:
        """All things that a word fits."""
        ...

    def homes(self, thing: str) -> frozenset[str]:
        """Places where a thing is from the start."""
        ...

    def is_surface(self, place: str) -> bool:
        """Whether being put on it differs from being put on the floor beside it."""
        ...


def effects(steps: Iterable[Step], words: Words, *, explicit: bool = False) -> tuple[Effect, ...]:
    """What the steps come to. ``explicit``: every step is there for a reason, but for the way to where something
    happens next; so are the steps of acceptable plans."""
    found: list[Effect] = []
    at = ""
    held: frozenset[str] = frozenset()
    for step in steps:
        for effect in _of(step, words):
            if effect.what == "pick":
                if step.name == "carry" and held & _meant(effect, words):
                    continue  # carrying picks up only what is not in the hand yet
                held = _meant(effect, words)
            elif effect.what in ("put", "open_gripper"):
                held = frozenset()
            if effect.what == "go":
                at = str(effect.args[0])
            elif effect.what in ("near", "pick", "find"):
                at = ""
            elif effect.what in ("look", "put") and effect.args[0] in ("", FLOOR):
                effect = replace(effect, args=(at,))
            elif effect.what in ("look", "put"):
                at = str(effect.args[0])
            found.append(effect)
    return _marked(_merged(found), words, explicit)


def _of(step: Step, words: Words) -> tuple[Effect, ...]:
    found = _plain(step, words)
    return found if step.needed else tuple(replace(effect, needed=False) for effect in found)


def _plain(step: Step, words: Words) -> tuple[Effect, ...]:
    name, args = step.name, step.args
    first: Value = args[0] if args else ""
    match name:
        case "finishtask":
            return ()
        case "move_forward" | "move_sideways":
            return (Effect("drive" if name == "move_forward" else "slide", (first,), _second(args)),)
        case "move_left":
            return (Effect("turn", (first,), _second(args)),)
        case "move_right":
            return (Effect("turn", (_negative(first),), _second(args)),)
        case "set_cmdvel":
            return (
                _velocity_within(args) if any(".." in str(value) for value in args) else _velocity(*map(float, args)),
            )
        case "navigation":
            return (Effect("go", (_places(first, words),)),)
        case "get_current_pose":
            return (Effect("remember"),)
        case "seewhat" | "scan_room" | "look":
            return (Effect("look", (_places(first, words) if first else "",)),)
        case "locate":
            return (Effect("find", (first,)),)
        case "navigate_to_object":
            return (Effect("near", (first,)),)
        case "pick_object":
            return (Effect("pick", (first,)),)
        case "putdown":
            return (Effect("put", (FLOOR,), how="floor"),)
        case "place_in_bin":
            return (Effect("put", (words.place(BIN),), how="on"),)
        case "place_object" | "put":
            where = _places(first, words)
            how: How = "any" if name == "put" else "floor" if where == FLOOR else "on"
            return (Effect("put", (where,), how=how),)
        case "carry":
            source = (Effect("go", (_places(args[2], words),), needed=False),) if len(args) > 2 and args[2] else ()
            return (*source, Effect("pick", (first,)), Effect("put", (_places(args[1], words),), how="floor"))
        case "tidy":
            return (Effect("tidy", (first, _places(args[1], words))),)
        case "clean_room":
            return (Effect("clean", (_places(first, words) if first else "",)),)
        case "clear_rubbish":  # of this room first
            return (Effect("clean", ("",)),)
        case "patrol":
            stations = str(first).replace("+", ",").split(",")
            return (Effect("patrol", (",".join(words.place(place.strip()) for place in stations if place),)),)
        case "guide" | "person_follow" if len(args) > 1 and args[1]:
            return (Effect(name, (first, _places(args[1], words))),)
        case "find_person" | "meet":
            return (*_there(args, 1, words), Effect("with", (first or "person",)))
        case "tell_everyone" | "count_people" as several:
            place = 2 if several == "tell_everyone" else 1
            return (*_there(args, place, words), Effect(several, args[:place]))
        case "beep":
            return (Effect("beep", () if first in ("", 0.2) else (first,)),)
    return (Effect(name, args),)


def _there(args: Sequence[Value], at: int, words: Words) -> tuple[Effect, ...]:
    """The way to where people are, where an argument says that."""
    return (Effect("go", (_places(args[at], words),), needed=False),) if len(args) > at and args[at] else ()


def _places(word: Value, words: Words) -> str:
    """One place, or several that will do, joined by ``|``."""
    return "|".join(part if part == "*" else words.place(part.strip()) for part in str(word).split("|"))


def _second(args: Sequence[Value]) -> Value | None:
    return args[1] if len(args) > 1 else None


def _negative(value: Value) -> Value:
    if not isinstance(value, str):
        return -value
    low, dots, high = value.partition("..")
    return f"-{high}..-{low}" if dots else value


def _velocity_within(args: Sequence[Value]) -> Effect:
    """The same of a velocity or time that is a range: a way between the least and the most, at any speed."""
    ends = [[float(end) for end in str(value).split("..")] for value in args]
    least, most = _velocity(*(end[0] for end in ends)), _velocity(*(end[-1] for end in ends))
    return Effect(most.what, tuple(f"{low}..{high}" for low, high in zip(least.args, most.args, strict=True)))


def _velocity(x: float, y: float, turn: float, duration: float) -> Effect:
    """The way that a velocity leads in its time; the velocity itself where it is more than one motion."""
    moving = [(what, speed) for what, speed in (("drive", x), ("slide", y), ("turn", turn)) if speed]
    if not moving:
        return Effect("wait", (duration,))
    if len(moving) > 1:
        return Effect("velocity", (x, y, turn, duration))
    (what, speed) = moving[0]
    way = speed * duration
    return Effect(what, (math.degrees(way) if what == "turn" else way,), abs(speed))


def _merged(found: Sequence[Effect]) -> list[Effect]:
    """Without repetitions of the same way to go, and with motions of the same kind and way in one."""
    merged: list[Effect] = []
    for effect in found:
        last = merged[-1] if merged else None
        if last is not None and last.what == effect.what and last.needed == effect.needed:
            if effect.what == "go" and effect.args == last.args:
                continue
            if effect.what in MERGED and last.pace == effect.pace:
                one, two = last.args[0], effect.args[0]
                if not isinstance(one, str) and not isinstance(two, str) and one * two > 0:
                    merged[-1] = replace(last, args=(one + two,))
                    continue
        merged.append(effect)
    return merged


def _marked(found: Sequence[Effect], words: Words, explicit: bool) -> tuple[Effect, ...]:
    """With ``needed`` false for what following effects include."""
    return tuple(
        replace(effect, needed=False) if effect.needed and _included(found, i, words, explicit) else effect
        for i, effect in enumerate(found)
    )


def _included(found: Sequence[Effect], index: int, words: Words, explicit: bool) -> bool:
    effect = found[index]
    rest = found[index + 1 :]
    following = next((later for later in rest if later.what not in STILL), None)
    match effect.what:
        case "remember":
            return not explicit and not any(later.what in ("go", "put") and ZERO in later.args for later in rest)
        case "stop":
            return not explicit and index > 0 and not rest
        case _ if following is None:
            return False
        case "go":
            return _on_the_way(str(effect.args[0]), following, words)
        case "find" | "near":
            return following.what in ("find", "near", "pick") and bool(_meant(effect, words) & _meant(following, words))
        case "with":
            return following.what in WITH
        case "look":
            return not explicit and following.what in ("find", "near", "pick")
        case "open_gripper":
            return not explicit and following.what == "pick"
    return False


def _on_the_way(place: str, following: Effect, words: Words) -> bool:
    """Whether whoever does what follows goes to the place anyway."""
    if following.what == "with":
        return True
    if following.what in ("find", "near", "pick"):
        homes = frozenset().union(*(words.homes(thing) for thing in _meant(following, words)))
        return bool(homes) and place in homes
    if following.what in ("go", "look", "put", "clean") and following.args and following.needed:
        then = str(following.args[0])
        return then == place or words.room(then) == place
    return False


def _meant(effect: Effect, words: Words) -> frozenset[str]:
    return frozenset().union(*(words.things(part) for part in str(effect.args[0]).split("|")))


def steps_of(actions: Iterable[tuple[str, Mapping[str, Value]]]) -> tuple[Step, ...]:
    """Steps of actions with named arguments, in the order of their parameters."""
    return tuple(Step(name, tuple(args.values())) for name, args in actions)
