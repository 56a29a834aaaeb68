"""What a request means, typed: acts with their roles, and how they hang together.

Every reader produces a :class:`Meaning`, and everything after it uses that. Each role knows the words that it came
from. What was taken back, corrected, forbidden or only spoken about stands in the meaning as such;
:meth:`Meaning.wanted` is what is left to be done."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, cast

from engine.understanding.acts import ACTS, CONDITIONS, ROLES, RoleName
from engine.understanding.notation import Step, roles_of

Reader = Literal["certain", "learned", "large"]


@dataclass(frozen=True, slots=True)
class Role:
    """A part of a request: what it is to its act, and its words. ``end`` is exclusive."""

    name: RoleName
    words: str
    start: int
    end: int
    instead_of: str = ""
    """The words that it corrects."""


@dataclass(frozen=True, slots=True)
class Condition:
    """What something depends on (``CONDITIONS``)."""

    kind: str
    roles: tuple[Role, ...] = ()

    def all(self, name: RoleName) -> tuple[str, ...]:
        """The words of each role of this name."""
        return tuple(role.words for role in self.roles if role.name == name)

    def words(self, name: RoleName) -> str:
        """The words of a role; empty where it is not said."""
        return next(iter(self.all(name)), "")


@dataclass(frozen=True, slots=True)
class Do:
    """An act that is wanted (``ACTS``)."""

    act: str
    roles: tuple[Role, ...] = ()
    together: bool = False
    """It starts with the act before it."""
    until: Condition | None = None
    """It goes on until then."""

    def all(self, name: RoleName) -> tuple[str, ...]:
        """The words of each role of this name."""
        return tuple(role.words for role in self.roles if role.name == name)

    def words(self, name: RoleName) -> str:
        """The words of the first role of this name; empty where there is none."""
        return next(iter(self.all(name)), "")

    def corrected(self, roles: Sequence[Role]) -> Do:
        """The same with these roles instead of those of the same names."""
        before = {role.name: role.words for role in reversed(self.roles)}
        names = {role.name for role in roles}
        kept = (role for role in self.roles if role.name not in names)
        return replace(self, roles=(*kept, *(replace(role, instead_of=before.get(role.name, "")) for role in roles)))


@dataclass(frozen=True, slots=True)
class If:
    """What is to be done where a condition holds, and where it does not."""

    condition: Condition
    then: tuple[Node, ...] = ()
    otherwise: tuple[Node, ...] = ()


@dataclass(frozen=True, slots=True)
class Repeat:
    """What is to be done several times; ``times`` in the speaker's words."""

    times: str
    nodes: tuple[Node, ...] = ()


@dataclass(frozen=True, slots=True)
class Not:
    """An act that is forbidden, or said to be unwanted."""

    act: Do


@dataclass(frozen=True, slots=True)
class About:
    """What is only spoken about: reported, imagined, asked about, past."""

    nodes: tuple[Node, ...] = ()


@dataclass(frozen=True, slots=True)
class Retract:
    """Takes back everything before it."""


@dataclass(frozen=True, slots=True)
class Instead:
    """Corrects the act before it: these roles were meant."""

    roles: tuple[Role, ...] = ()


Node = Do | If | Repeat | Not | About | Retract | Instead


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a request means, who read it, and how sure the reader is (0 to 1)."""

    text: str
    nodes: tuple[Node, ...]
    reader: Reader = "learned"
    confidence: float = 1.0
    doubt: float = 0.0
    """How likely the reader held it that more of this is no order than what it has written, 0 to 1."""
    directed: float = 1.0
    """How likely it is that this is said to the robot at all, and not talk or words in no order, 0 to 1."""

    def wanted(self) -> tuple[Do | If | Repeat, ...]:
        """What is to be done in the end: nothing that was taken back, forbidden or only spoken about."""
        return _wanted(self.nodes)

    def has(self, kind: type[Node]) -> bool:
        """Whether a node of this kind stands anywhere in it."""
        return any(isinstance(node, kind) for node in walk(self.nodes))

    def describe(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "reader": self.reader,
            "confidence": round(self.confidence, 3),
            "doubt": round(self.doubt, 3),
            "directed": round(self.directed, 3),
            "nodes": [_described(node) for node in self.nodes],
        }


def walk(nodes: Sequence[Node]) -> Iterator[Node]:
    """All nodes, those within others too."""
    for node in nodes:
        yield node
        match node:
            case If():
                yield from walk(node.then)
                yield from walk(node.otherwise)
            case Repeat() | About():
                yield from walk(node.nodes)
            case Not():
                yield node.act


def meaning_of(
    text: str, steps: Sequence[Step], reader: Reader = "learned", confidence: float = 1.0, doubt: float = 0.0
) -> Meaning:
    """The meaning that is written as ``steps``. Raises ValueError where they are none."""
    nodes, rest = _sequence(text, list(steps), ())
    if rest:
        raise ValueError(f"{rest[0].symbol} stands where nothing was open")
    return Meaning(text, nodes, reader, confidence, doubt)


def _sequence(text: str, steps: list[Step], closing: tuple[str, ...]) -> tuple[tuple[Node, ...], list[Step]]:
    nodes: list[Node] = []
    together = False
    while steps and steps[0].symbol not in closing:
        symbol = steps.pop(0).symbol
        match symbol:
            case "together":
                together = True
            case "retract":
                nodes.append(Retract())
            case "instead":
                nodes.append(Instead(_roles(text, steps, "instead")))
            case "not":
                inner = steps.pop(0).symbol if steps else ""
                if inner not in ACTS:
                    raise ValueError("nothing is forbidden")
                nodes.append(Not(Do(inner, _roles(text, steps, inner))))
            case "about":
                inside, steps = _sequence(text, steps, closing)
                nodes.append(About(inside))
            case "if":
                node, steps = _condition(text, steps)
                nodes.append(node)
            case "repeat":
                times = _roles(text, steps, "repeat")
                inside, steps = _closed(text, steps)
                nodes.append(Repeat(times[0].words if times else "", inside))
            case "until":
                until = _one_condition(text, steps)
                _end(steps)
                if not nodes or not isinstance(last := nodes[-1], Do):
                    raise ValueError("until stands behind no act")
                nodes[-1] = replace(last, until=until)
            case _ if symbol in ACTS:
                nodes.append(Do(symbol, _roles(text, steps, symbol), together=together))
                together = False
            case _:
                raise ValueError(f"{symbol} stands where an act was expected")
    return tuple(nodes), steps


def _closed(text: str, steps: list[Step]) -> tuple[tuple[Node, ...], list[Step]]:
    inside, steps = _sequence(text, steps, ("end",))
    _end(steps)
    return inside, steps


def _end(steps: list[Step]) -> None:
    if not steps or steps.pop(0).symbol != "end":
        raise ValueError("something is not closed")


def _condition(text: str, steps: list[Step]) -> tuple[If, list[Step]]:
    condition = _one_condition(text, steps)
    if not steps or steps.pop(0).symbol != "then":
        raise ValueError("a condition has nothing that depends on it")
    then, steps = _sequence(text, steps, ("else", "end"))
    otherwise: tuple[Node, ...] = ()
    if steps and steps[0].symbol == "else":
        steps.pop(0)
        otherwise, steps = _sequence(text, steps, ("end",))
    _end(steps)
    return If(condition, then, otherwise), steps


def _one_condition(text: str, steps: list[Step]) -> Condition:
    kind = steps.pop(0).symbol if steps else ""
    if kind not in CONDITIONS:
        raise ValueError("a condition is missing")
    return Condition(kind, _roles(text, steps, kind))


def _roles(text: str, steps: list[Step], symbol: str) -> tuple[Role, ...]:
    roles: list[Role] = []
    while steps and steps[0].symbol in ROLES:
        step = steps.pop(0)
        if step.symbol not in roles_of(symbol):
            raise ValueError(f"{symbol} takes no {step.symbol}")
        roles.append(Role(cast(RoleName, step.symbol), text[step.start : step.end], step.start, step.end))
    return tuple(roles)


def _wanted(nodes: Sequence[Node]) -> tuple[Do | If | Repeat, ...]:
    left: list[Do | If | Repeat] = []
    for node in nodes:
        match node:
            case Retract():
                left.clear()
            case Instead():
                if not left or not _correct(left, node.roles):
                    left.append(Do("fragment", node.roles))
            case If():
                left.append(replace(node, then=_wanted(node.then), otherwise=_wanted(node.otherwise)))
            case Repeat():
                left.append(replace(node, nodes=_wanted(node.nodes)))
            case Do():
                left.append(node)
            case Not() | About():
                pass
    return tuple(left)


def _correct(left: list[Do | If | Repeat], roles: Sequence[Role]) -> bool:
    """Put the roles into the last act that can take them; whether there was one."""
    for index in range(len(left) - 1, -1, -1):
        node = left[index]
        if isinstance(node, Do) and all(role.name in ACTS[node.act].roles for role in roles):
            left[index] = node.corrected(roles)
            return True
    return False


def _described(node: Node) -> dict[str, Any]:
    match node:
        case Do():
            told: dict[str, Any] = {"do": node.act, "roles": [_role(role) for role in node.roles]}
            if node.together:
                told["together"] = True
            if node.until is not None:
                told["until"] = _told(node.until)
            return told
        case If():
            return {
                "if": _told(node.condition),
                "then": [_described(inner) for inner in node.then],
                "else": [_described(inner) for inner in node.otherwise],
            }
        case Repeat():
            return {"repeat": node.times, "nodes": [_described(inner) for inner in node.nodes]}
        case Not():
            return {"not": _described(node.act)}
        case About():
            return {"about": [_described(inner) for inner in node.nodes]}
        case Retract():
            return {"retract": True}
        case Instead():
            return {"instead": [_role(role) for role in node.roles]}


def _told(condition: Condition) -> dict[str, Any]:
    return {"is": condition.kind, "roles": [_role(role) for role in condition.roles]}


def _role(role: Role) -> dict[str, Any]:
    return {"role": role.name, "words": role.words, "span": [role.start, role.end]}
