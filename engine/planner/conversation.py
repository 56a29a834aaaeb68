"""What a request means after what was said before: an answer, a correction, a follow-up.

"The red one", "no, to the study", "and now the wardrobe", "twice as far" name roles and no act: they belong to an act
that was said before. All of this is done on meanings: the roles are put into that act, in place of its own.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

from engine.planner import amounts
from engine.planner.entities import Entities, Side
from engine.planner.happened import last_question, open_command
from engine.planner.options import chosen
from engine.planner.request import Happened, NoPlan, PlanRequest, Said
from engine.understanding.acts import ACTS, RoleName
from engine.understanding.meaning import Do, If, Instead, Meaning, Node, Repeat, Role, walk

LONGEST: Final = 8
"""Requests of a task that are looked back on."""
_GOAL: Final[frozenset[RoleName]] = frozenset({"place", "thing", "person"})
_ONE_OF: Final[Mapping[str, frozenset[RoleName]]] = {
    **dict.fromkeys(("go", "face", "look", "meet"), _GOAL),
    **dict.fromkeys(("bring", "guide"), frozenset[RoleName]({"place", "person"})),
    **dict.fromkeys(("forward", "backward", "beep", "wait"), frozenset[RoleName]({"amount", "time", "times"})),
}
"""Roles of an act of which one takes the place of the other: who is told to go to the desk, "and now the lamp"."""
_KIN: Final[Mapping[str, tuple[RoleName, ...]]] = {
    "colour": ("thing",), "person": ("place", "thing"), "place": ("source", "person"), "source": ("place",),
    "amount": ("time", "times"), "time": ("amount",), "times": ("amount",), "state": ("colour", "manner"),
    "thing": ("place",),
}  # fmt: skip
"""What a role may be where an act takes none of its name."""
_TURNED: Final[Mapping[str, Mapping[Side, str]]] = {
    "turn": {"left": "turn_left", "right": "turn_right"},
    "move": {"left": "sideways_left", "right": "sideways_right", "ahead": "forward", "behind": "backward"},
}
_KIND: Final = {
    **dict.fromkeys(("turn", "turn_left", "turn_right"), "turn"),
    **dict.fromkeys(("move", "forward", "backward", "sideways_left", "sideways_right"), "move"),
}
"""The act to each side."""
_MIRRORED: Final = {
    "turn_left": "turn_right", "turn_right": "turn_left", "forward": "backward", "backward": "forward",
    "sideways_left": "sideways_right", "sideways_right": "sideways_left", "arm_up": "arm_down", "arm_down": "arm_up",
    "open_gripper": "close_gripper", "close_gripper": "open_gripper",
}  # fmt: skip
_OTHER_WAY: Final = re.compile(
    r"(?:the )?(?:other|opposite|wrong) (?:way|direction|side)(?: round| around)?|反方?向|另一?边"
)
_FACTORS: Final = (
    (re.compile(r"twice|double|two times as|两倍|加倍|一倍"), 2.0),
    (re.compile(r"three times as|triple|三倍"), 3.0),
    (re.compile(r"half (?:as|that|of)|half$|halve|一半"), 0.5),
    (re.compile(r"\b(?:same|as (?:far|much|long|many))\b|一样|同样"), 1.0),
)
"""How much, told by how much it was before."""
_UNITS: Final = (("m", "metres"), ("deg", "degrees"), ("s", "seconds"))


class Conversation:
    """Completes meanings with what was said before."""

    def __init__(
        self, read: Callable[[str], Meaning | None], accounted: Callable[[Meaning], bool], entities: Entities
    ) -> None:
        """``read`` gives the likeliest meaning of a text, ``accounted`` whether that has missed nothing."""
        self._read = read
        self._accounted = accounted
        self._entities = entities

    def completed(self, request: PlanRequest, text: str) -> Meaning | None:
        """The meaning of ``text`` with the act that it belongs to; None where it says an act itself, or where nothing
        was said that it could belong to."""
        question = last_question(request.happened) if request.happened else None
        if question is not None and not question.leaves_open:
            question = None
        answer = self._read(text)
        if question is not None and (name := chosen(question, text, request.seen)):
            then = answer.nodes[1:] if answer is not None else ()
            answer = Meaning(text, (Do("fragment", (Role("thing", name, 0, len(text)),)), *then))
        elif answer is None or not answer.nodes or not request.happened or not self._accounted(answer):
            return None
        elif answer.nodes == (Do("again"),) and (other := _OTHER_WAY.search(text.casefold())) is not None:
            answer = replace(answer, nodes=(Do("fragment", (Role("manner", other[0], *other.span()),)),))
        said = tuple((entry.text, "") for entry in _kept(request.happened) if isinstance(entry, Said))[-LONGEST:]
        before = self._before(said if question is None else open_command(request.happened), whole=question is not None)
        if question is not None and question.lacks == "where":
            answer = _whither(answer)
        if _roles(answer.nodes[0]) is None:
            return None if before is None else _measured_by(before, answer)
        return None if before is None else self._joined(before, answer, whole=question is not None)

    def _before(self, said: Sequence[tuple[str, str]], *, whole: bool) -> Meaning | None:
        """What these requests come to, each of which may be an answer to the one before it, or to a question with what
        that lacked."""
        before: Meaning | None = None
        for text, lacked in said:
            meaning = self._read(text)
            if meaning is None or not meaning.nodes or not self._accounted(meaning):
                continue
            if lacked == "where":
                meaning = _whither(meaning)
            if _roles(meaning.nodes[0]) is None:
                before = meaning
            elif before is not None:
                before = self._joined(before, meaning, whole=whole) or before
        return before

    def _joined(self, before: Meaning, answer: Meaning, *, whole: bool) -> Meaning | None:
        """The act of ``before`` that takes the roles of ``answer``, with them; ``whole``: with all else of it."""
        roles = _roles(answer.nodes[0]) or ()
        acts = [node for node in walk(before.wanted()) if isinstance(node, Do)]
        for act in reversed(acts):
            changed = self._with(act, roles)
            if changed is None:
                continue
            nodes = _replaced(before.wanted(), act, changed) if whole else (changed,)
            likely = min(before.confidence, answer.confidence)
            return Meaning(before.text, (*nodes, *answer.nodes[1:]), before.reader, likely)
        return None

    def _with(self, act: Do, roles: Sequence[Role]) -> Do | None:
        """The act with these roles in place of its own; None where it cannot take one of them."""
        for role in roles:
            if (turned := self._turned(act, role)) is not None:
                act = turned
                continue
            name = _slot(act, role)
            if name is None:
                return None
            others = _ONE_OF.get(act.act, frozenset())
            gone = others if name in others else frozenset({name})
            old = next((one.words for one in act.roles if one.name in gone), "")
            kept = tuple(one for one in act.roles if one.name not in gone)
            words = (
                f"the {role.words.removeprefix('the ')} one"
                if (role.name, name) == ("colour", "thing")
                else _scaled(role.words, old)
            )
            act = replace(act, roles=(*kept, replace(role, name=name, words=words, instead_of=old)))
        return act

    def _turned(self, act: Do, role: Role) -> Do | None:
        """The same to the side that a role names."""
        if role.name not in ("place", "manner", "thing"):
            return None
        if _OTHER_WAY.fullmatch(role.words.casefold().strip()) and act.act in _MIRRORED:
            return replace(act, act=_MIRRORED[act.act])
        side = self._entities.of(role.words).side
        to = _TURNED[kind].get(side) if side is not None and (kind := _KIND.get(act.act)) is not None else None
        return None if to is None else replace(act, act=to)


def _roles(node: Node) -> tuple[Role, ...] | None:
    """The roles of what names no act; None of any other node."""
    if isinstance(node, Instead) or (isinstance(node, Do) and node.act == "fragment"):
        return node.roles
    return None


def _kept(happened: Sequence[Happened]) -> Sequence[Happened]:
    """What came after the last request that was given up: nothing that is said later completes that."""
    for number in range(len(happened), 0, -1):
        entry = happened[number - 1]
        if isinstance(entry, NoPlan) and entry.is_no_order:
            return happened[number:]
    return happened


def _measured_by(before: Meaning, answer: Meaning) -> Meaning | None:
    """ "The same distance backwards": the motion with the amount that the one before it tells; None for all others."""
    first = answer.nodes[0]
    if not isinstance(first, Do) or first.act not in _KIND:
        return None
    acts = (node for node in walk(before.wanted()) if isinstance(node, Do) and _KIND.get(node.act) == _KIND[first.act])
    old = next((act.words("amount") for act in reversed(list(acts))), "")
    roles = tuple(
        replace(role, words=_scaled(role.words, old)) if role.name == "amount" else role for role in first.roles
    )
    return None if roles == first.roles else replace(answer, nodes=(replace(first, roles=roles), *answer.nodes[1:]))


def _whither(answer: Meaning) -> Meaning:
    """ "Go to the kitchen", said to who has asked where to: the place, where that is all that it says."""
    match answer.nodes:
        case (Do("go", (Role("place") as place,)), *then):
            return replace(answer, nodes=(Do("fragment", (place,)), *then))
        case _:
            return answer


def _slot(act: Do, role: Role) -> RoleName | None:
    """Which role of ``act`` it is."""
    takes = ACTS[act.act].roles
    if role.name in takes:
        return role.name
    return next((name for name in _KIN.get(role.name, ()) if name in takes), None)


def _scaled(words: str, old: str) -> str:
    """An amount that is told by the one before it, "twice as far", as one by itself."""
    factor = next((factor for pattern, factor in _FACTORS if pattern.search(words.casefold())), None)
    if factor is None or not old or any(amounts.quantity(words, unit) is not None for unit, _ in _UNITS):
        return words
    for unit, name in _UNITS:
        if (before := amounts.quantity(old, unit)) is not None:
            return f"{before * factor:g} {name}"
    return words


def _replaced(nodes: Sequence[Do | If | Repeat], old: Do, new: Do) -> tuple[Do | If | Repeat, ...]:
    """The nodes with one act in place of another, wherever it stands."""
    made: list[Do | If | Repeat] = []
    for node in nodes:
        if node is old:
            made.append(new)
        elif isinstance(node, If):
            then, otherwise = (_replaced(_acts(part), old, new) for part in (node.then, node.otherwise))
            made.append(replace(node, then=then, otherwise=otherwise))
        elif isinstance(node, Repeat):
            made.append(replace(node, nodes=_replaced(_acts(node.nodes), old, new)))
        else:
            made.append(node)
    return tuple(made)


def _acts(nodes: Sequence[Node]) -> tuple[Do | If | Repeat, ...]:
    return tuple(node for node in nodes if isinstance(node, Do | If | Repeat))
