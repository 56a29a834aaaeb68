"""What people say once for several acts: the unit of amounts, the name of a person, the message to several people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

from engine.planner import amounts
from engine.planner.doing.conditions import NAMED_BEFORE
from engine.understanding.acts import RoleName
from engine.understanding.meaning import Do, Node, Role

_MEASURED: Final[tuple[tuple[RoleName, str, frozenset[str]], ...]] = (
    ("amount", "m", frozenset({"forward", "backward", "sideways_left", "sideways_right"})),
    ("time", "s", frozenset({"wait"})),
)
"""Roles of which a bare number says too little, what they measure, and the acts that have them in one unit."""
_LIKE: Final = 5.0
"""So many times the amount before is not meant in its unit: "one metre ahead, 40 back"."""
_WITH_PEOPLE: Final = frozenset({"tell", "greet", "ask", "find", "meet"})
"""Acts that are done with one person after the other."""


def in_full(nodes: Sequence[Node]) -> tuple[Node, ...]:
    """The nodes with each act as if it had been said by itself."""
    return tuple(one for node in _named(_measured(nodes)) for one in _with_each_person(node))


def _measured(nodes: Sequence[Node]) -> list[Node]:
    """With the unit of the amount before: "0.4 metres to the left, 0.6 forward", "wait five seconds, …, five more"."""
    before = dict[RoleName, str]()

    def measured(act: Do, role: Role) -> Role:
        measures = next((what for name, what, acts in _MEASURED if role.name == name and act.act in acts), "")
        if not measures:
            return role
        if amounts.unit_in(role.words):
            before[role.name] = role.words
        elif (number := amounts.number(role.words)) is not None and role.name in before:
            words = f"{number:g} {amounts.unit_in(before[role.name])}"
            last, this = amounts.quantity(before[role.name], measures), amounts.quantity(words, measures)
            if last is not None and this is not None and this <= _LIKE * last:
                return replace(role, words=words)
        return role

    return [
        replace(node, roles=tuple(measured(node, role) for role in node.roles)) if isinstance(node, Do) else node
        for node in nodes
    ]


def _named(nodes: Sequence[Node]) -> list[Node]:
    """With the name that only the second act says: "let Ben know, once you have found him, that I am late"."""
    made = list(nodes)
    for at, (first, second) in enumerate(pairwise(nodes)):
        earlier = any(isinstance(node, Do) and node.words("person") for node in nodes[:at])
        if not isinstance(first, Do) or not isinstance(second, Do) or earlier:
            continue
        pronoun = next((role for role in first.roles if role.name == "person"), None)
        name = next((role for role in second.roles if role.name == "person"), None)
        if (
            pronoun is None
            or name is None
            or not NAMED_BEFORE.fullmatch(pronoun.words.casefold())
            or name.start > pronoun.start
        ):
            continue
        roles = (replace(role, words=name.words) if role is pronoun else role for role in first.roles)
        made[at] = replace(first, roles=tuple(roles))
    return made


def _with_each_person(node: Node) -> tuple[Node, ...]:
    """One act for each of several people: "tell Ben and Mia to wash their hands"."""
    if not isinstance(node, Do) or node.act not in _WITH_PEOPLE or len(node.all("person")) < 2:
        return (node,)
    people = [role for role in node.roles if role.name == "person"]
    return tuple(
        replace(node, roles=tuple(role for role in node.roles if role.name != "person" or role is person))
        for person in people
    )
