"""Whether a plan is one of those that are acceptable: not the same words, the same effects.

An acceptable plan is written in the names of skills, with semicolons between steps. The writing knows besides:

- ``step?``: this step may be left out. ``a() & b()``: in any order, or together.
- ``coffee table|sofa``: any of these. ``*``: anything; in a text, any part of it. ``5..45``, ``<0.25``, ``>0.35``: a
  number in this range. A speed counts only where one is written.
- ``put(P)``: on it, in it or on the floor there. ``look(P)``: look at it or through it. ``bring_me(X)``: pick X up,
  come to where the speaker is (``zero``, which may be remembered first), and put it down or not.
- ``looking(A, B, …)``: steps that only go to these places, look there or look for these things, in any order; so does
  the first plan for a condition. Such a plan must not say that it is finished.
"""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import permutations, product
from typing import Final

from tests.eval.effects import Effect, Step, Value, Words, effects

RELATIVE, ABSOLUTE = 0.02, 0.011
"""Numbers this close are the same."""
OF_THINGS: Final = frozenset({"find", "near", "pick"})
OF_PLACES: Final = frozenset({"go", "look", "put", "clean"})
_CALL = re.compile(r"\s*(\w+)\s*\(([^()]*)\)\s*(\?)?\s*")
_RANGE = re.compile(r"(?P<low>-?[\d.]+?)\.\.(?P<high>-?[\d.]+)|<(?P<below>[\d.]+)|>(?P<above>[\d.]+)")
_ME = "get_current_pose()?; pick_object({0}); navigation(zero)"
_LOOKS = frozenset({"go", "look", "find", "near", "remember"})


class Unreadable(ValueError):
    """An acceptable plan is not written as it should be."""


@dataclass(frozen=True, slots=True)
class Acceptable:
    """One way to carry something out, in steps; or, where ``about`` is set, any way to look at that."""

    steps: tuple[Step, ...] = ()
    about: tuple[str, ...] = ()


@lru_cache(maxsize=4096)
def read(text: str) -> tuple[Acceptable, ...]:
    """All plans that one line stands for. Raises :class:`Unreadable`."""
    found: list[list[tuple[Step, ...]]] = []
    for part in text.split(";"):
        block = [_read_step(step, text) for step in part.split("&")]
        if block[0].name == "looking":
            return (Acceptable(about=tuple(str(arg) for arg in block[0].args)),)
        if block[0].name == "bring_me":
            thing = block[0].args[0]
            found.append([_read_all(_ME.format(thing)), _read_all(_ME.format(thing) + "; putdown()")])
        else:
            found.append([tuple(order) for order in permutations(block)])
    return tuple(Acceptable(tuple(step for block in way for step in block)) for way in product(*found))


def _read_all(text: str) -> tuple[Step, ...]:
    return tuple(_read_step(part, text) for part in text.split(";"))


def _read_step(part: str, text: str) -> Step:
    match = _CALL.fullmatch(part)
    if match is None:
        raise Unreadable(f"{part.strip()!r} of {text!r} is no step; write name(arguments)")
    name, inside, optional = match.groups()
    args = tuple(_read_value(arg.strip()) for arg in inside.split(",")) if inside.strip() else ()
    return Step(name, args, needed=not optional)


def _read_value(arg: str) -> Value:
    try:
        return float(arg)
    except ValueError:
        return arg


def accepts(text: str, steps: Sequence[Step], words: Words) -> bool:
    """Whether the steps of a plan do what an acceptable one does, no more and no less."""
    return any(_accepts(way, steps, words) for way in read(text))


def _accepts(way: Acceptable, steps: Sequence[Step], words: Words) -> bool:
    if way.about:
        return only_looks(steps, way.about, words)
    return is_the_same(effects(way.steps, words, explicit=True), effects(steps, words), words)


def is_the_same(wanted: Sequence[Effect], done: Sequence[Effect], words: Words) -> bool:
    """Whether the two are in step, but for what either may leave out."""
    reached = {(0, 0)}
    for i, j in product(range(len(wanted) + 1), range(len(done) + 1)):
        if (i, j) not in reached:
            continue
        if i < len(wanted) and not wanted[i].needed:
            reached.add((i + 1, j))
        if j < len(done) and not done[j].needed:
            reached.add((i, j + 1))
        if i < len(wanted) and j < len(done) and fits(wanted[i], done[j], words):
            reached.add((i + 1, j + 1))
    return (len(wanted), len(done)) in reached


def fits(wanted: Effect, done: Effect, words: Words) -> bool:
    """Whether an effect is the one that is wanted."""
    if (wanted.what, done.what) == ("say", "tell") and len(done.args) > 1:
        return _is_value(wanted.args[0], done.args[1])
    if (wanted.what, done.what) == ("say", "tell_everyone"):
        return _is_value(wanted.args[0], done.args[0])
    if wanted.what != done.what:
        return False
    if wanted.pace is not None and not _is_value(wanted.pace, done.pace):
        return False
    if wanted.what == "put" and not _put_so(wanted, done, words):
        return False
    if wanted.what in OF_THINGS:
        return is_thing(str(wanted.args[0]), str(done.args[0]), words)
    if wanted.what == "patrol":
        return wanted.args in (("*",), done.args)
    given = done.args[: len(wanted.args)]
    return len(given) == len(wanted.args) and all(map(_is_value, wanted.args, given))


def _put_so(wanted: Effect, done: Effect, words: Words) -> bool:
    where = str(done.args[0])
    return "any" in (wanted.how, done.how) or wanted.how == done.how or not words.is_surface(where)


def is_thing(wanted: str, done: str, words: Words) -> bool:
    """Whether both words mean the same things here: ``cup`` and ``white cup`` do where there is one cup."""
    if wanted == "*":
        return True
    return any(words.things(part) == words.things(done) for part in wanted.split("|"))


def _is_value(wanted: Value, done: Value | None) -> bool:
    if done is None:
        return wanted == "*"
    if not isinstance(wanted, str):
        try:
            return abs(float(done) - wanted) <= max(ABSOLUTE, RELATIVE * abs(wanted))
        except ValueError:
            return False
    if isinstance(done, str):
        said = _plain(done)
        return any(fnmatch.fnmatchcase(said, _plain(part)) for part in wanted.split("|"))
    return wanted == "*" or _in_range(wanted, done)


def _in_range(wanted: str, value: float) -> bool:
    match = _RANGE.fullmatch(wanted)
    if match is None:
        return False
    if match["below"]:
        return value < float(match["below"])
    if match["above"]:
        return value > float(match["above"])
    return float(match["low"]) - ABSOLUTE <= value <= float(match["high"]) + ABSOLUTE


def _plain(text: str) -> str:
    return " ".join(re.sub(r"[^\w\s*]", " ", text.casefold()).split())


def only_looks(steps: Sequence[Step], about: Iterable[str], words: Words) -> bool:
    """Whether the steps only go to, look at and look for what they may, and leave what follows open."""
    if not steps or any(step.name in ("finishtask", "finish_dialogue") for step in steps):
        return False
    named = tuple(about)
    places = {words.place(name) for name in named}
    places |= {room for place in places if (room := words.room(place))} | {""}
    things = frozenset().union(*(words.things(name) for name in named))
    found = effects(steps, words)
    if not all(effect.what in _LOOKS for effect in found) or all(effect.what == "remember" for effect in found):
        return False
    for effect in found:
        if effect.what in OF_THINGS and not words.things(str(effect.args[0])) <= things:
            return False
        if effect.what in OF_PLACES and effect.args[0] not in places:
            return False
    return True


Slot = tuple[str, Value]
"""Sort and value of an argument."""


def slots_right(texts: Iterable[str], steps: Sequence[Step], words: Words) -> bool:
    """Whether the arguments are those of an acceptable plan, in whichever order and for whichever skills."""
    mine = tuple(_slots(effects(steps, words)))
    return any(_same_slots(way, mine, steps, words) for text in texts for way in read(text))


def _same_slots(way: Acceptable, mine: Sequence[Slot], steps: Sequence[Step], words: Words) -> bool:
    if way.about:
        return only_looks(steps, way.about, words)
    left = list(mine)
    wanted = effects(way.steps, words, explicit=True)
    for needed in (True, False):
        for sort, value in _slots(wanted, needed=needed):
            found = next((slot for slot in left if slot[0] == sort and _is_slot(sort, value, slot[1], words)), None)
            if found is not None:
                left.remove(found)
            elif needed:
                return False
    return not left


def _slots(found: Iterable[Effect], *, needed: bool = True) -> Iterator[Slot]:
    for effect in found:
        if effect.needed != needed:
            continue
        sort = "thing" if effect.what in OF_THINGS else "place" if effect.what in OF_PLACES else "value"
        for value in effect.args:
            if value not in ("", "zero", "*"):
                yield sort, value


def _is_slot(sort: str, wanted: Value, done: Value, words: Words) -> bool:
    return is_thing(str(wanted), str(done), words) if sort == "thing" else _is_value(wanted, done)
