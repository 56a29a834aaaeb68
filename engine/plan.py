"""Plans, and the reader of action strings.

An :class:`ActionCall` is an action *as written* (``set_cmdvel(0.5, 0, 0, 2)``, ``navigation(B)``,
``move_forward(50 cm)``): a name and unchecked arguments. A skill registry turns calls into :class:`Action`, whose
name is registered and whose arguments are typed and within limits. A :class:`Plan` holds only the latter.

The grammar, read by the parser below and never by ``eval``::

    calls    = call { ("," | ";" | "&") call }       "&": the next one starts together with the one before it
    call     = name [ "(" [ argument { "," argument } ] ")" ]
    argument = [ name "=" ] ( number [ unit ] | string | word )
    number   = [ "+" | "-" ] digits [ "." digits ] [ exponent ]
    string   = "…" | '…'            with \\" \\' \\\\ \\n escapes
    word     = letters, digits, "_", in any script; several words in a row are one argument
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from engine.errors import PlanError
from engine.events import ActionView, PlanMade, PlanSource, Value

MAX_ACTIONS = 50
"""A longer list is a runaway, not a plan."""
MAX_TEXT = 20_000
"""Longest action list that is read at all, characters."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number with the unit it was written with; ``unit`` is empty for a bare number."""

    value: float
    unit: str = ""


Argument = Quantity | str
"""An argument as written: a number, or text."""


@dataclass(frozen=True, slots=True)
class ActionCall:
    """An action as written, not yet checked against the skills."""

    name: str
    positional: tuple[Argument, ...] = ()
    named: Mapping[str, Argument] = field(default_factory=dict)
    alongside: bool = False  # it is to start together with the one before it


@dataclass(frozen=True, slots=True)
class Action:
    """A registered skill with checked arguments by parameter name, defaults filled in."""

    name: str
    args: Mapping[str, Value]
    alongside: bool = False
    """It starts together with the action before it, as far as what both occupy allows."""

    def __str__(self) -> str:
        return f"{self.name}({', '.join(_show(value) for value in self.args.values())})"


@dataclass(frozen=True, slots=True)
class InWords:
    """An action as people are told of it, in English."""

    step: str
    """What is to be done: "Go to the kitchen"."""
    doing: str
    """What goes on then: "going to the kitchen"."""


def as_written(action: Action) -> InWords:
    """An action for which nobody has words, as programs write it."""
    return InWords(str(action), str(action))


_BETTER_TWICE = ("grasp_failed", "dropped", "target_lost", "path_blocked")
"""Error codes of failures by chance."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What will be done: every action is valid, or there is no plan."""

    goal: str
    actions: tuple[Action, ...]
    response: str
    source: PlanSource
    steps: tuple[str, ...] = ()
    finished: bool = True
    """When its actions have gone well, nothing is left to be thought over."""
    minds_failure: bool = False
    """What comes next depends on how it went, also where it failed."""
    decided: tuple[bool, ...] = ()
    """Whether the conditions of the request that have been looked at held, the first one first."""
    written: str = ""
    """As the model wrote it; empty for plans that no model wrote."""

    def groups(self) -> tuple[tuple[int, ...], ...]:
        """The actions by index, those that start together in one group."""
        groups: list[tuple[int, ...]] = []
        for index, action in enumerate(self.actions):
            if action.alongside and groups:
                groups[-1] += (index,)
            else:
                groups.append((index,))
        return tuple(groups)

    def is_worth_thinking_over(self, failed: str | None) -> bool:
        """Whether the request says what is to be done then, or a model made it that may find another way after this
        failure. A small one is only asked about what may be better the second time: it explains nothing that the
        failure itself does not say."""
        if self.minds_failure:
            return True
        if self.source == "local":
            return failed in _BETTER_TWICE
        return self.source in ("openai", "dify")

    def as_written(self) -> str:
        """In the form in which models write plans."""
        if self.written:
            return self.written
        return json.dumps({"action": [str(action) for action in self.actions]}, ensure_ascii=False)

    def as_event(self) -> PlanMade:
        return PlanMade(
            goal=self.goal,
            steps=self.steps,
            actions=tuple(ActionView(action.name, action.args, action.alongside) for action in self.actions),
            response=self.response,
            source=self.source,
        )


def _show(value: Value) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


class _Token(NamedTuple):
    kind: str
    text: str
    at: int


_TOKENS = re.compile(
    r"""\s*(?:
        (?P<number>[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)
      | (?P<string>"(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*')
      | (?P<word>[^\W\d]\w*|°|%)
      | (?P<mark>[(),;=/&])
    )""",
    re.VERBOSE,
)
_ESCAPES = {"n": "\n", "t": "\t"}


def parse_call(text: str) -> ActionCall:
    """Read exactly one action. Raises :class:`PlanError` with the place of the fault."""
    calls = parse_calls(text)
    if len(calls) != 1:
        raise PlanError(f"Expected one action, found {len(calls)} in {text[:80]!r}.")
    return calls[0]


def parse_calls(text: str) -> tuple[ActionCall, ...]:
    """Read a list of actions separated by commas or semicolons, or by ``&`` where they go together.

    Raises :class:`PlanError`.
    """
    if len(text) > MAX_TEXT:
        raise PlanError(f"The action list is {len(text)} characters long; {MAX_TEXT} are read at most.")
    return _Parser(text).calls()


class _Parser:
    """Recursive descent over the tokens of one text."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens = list(self._scan(text))
        self._next = 0

    @staticmethod
    def _scan(text: str) -> list[_Token]:
        tokens, at, end = [], 0, len(text.rstrip())
        while at < end:
            match = _TOKENS.match(text, at)
            if match is None:
                raise PlanError(f"Cannot read {text[at : at + 20].strip()!r} at character {at + 1} of {text[:80]!r}.")
            name = match.lastgroup or ""
            tokens.append(_Token(name, match[name], match.start(name)))
            at = match.end()
        return tokens

    def calls(self) -> tuple[ActionCall, ...]:
        found: list[ActionCall] = []
        alongside = False
        while alongside or self._peek() is not None:
            found.append(replace(self._call(), alongside=alongside))
            if len(found) > MAX_ACTIONS:
                raise PlanError(f"More than {MAX_ACTIONS} actions; a plan is shorter.")
            alongside = self._take("&")
            if not alongside and self._peek() is not None and not (self._take(",") or self._take(";")):
                raise self._fault("',', '&' or the end")
        return tuple(found)

    def _call(self) -> ActionCall:
        name = self._expect("word").text
        positional: list[Argument] = []
        named: dict[str, Argument] = {}
        if not self._take("("):
            return ActionCall(name)
        while not self._take(")"):
            key = self._key()
            value = self._argument()
            if key is None:
                if named:
                    raise PlanError(f"{name}: an argument without a name follows one with a name.")
                positional.append(value)
            elif key in named:
                raise PlanError(f"{name}: the argument {key} is given twice.")
            else:
                named[key] = value
            token = self._peek()
            if not self._take(",") and (token is None or token.text != ")"):
                raise self._fault("',' or ')'")
        return ActionCall(name, tuple(positional), named)

    def _key(self) -> str | None:
        following = self._tokens[self._next : self._next + 2]
        if len(following) == 2 and following[0].kind == "word" and following[1].text == "=":
            self._next += 2
            return following[0].text
        return None

    def _argument(self) -> Argument:
        token = self._peek()
        if token is None or token.kind == "mark":
            raise self._fault("an argument")
        self._next += 1
        if token.kind == "number":
            value = float(token.text)
            if not math.isfinite(value):
                raise PlanError(f"{token.text} is too large a number.")
            return Quantity(value, self._unit())
        if token.kind == "string":
            return re.sub(r"\\(.)", lambda m: _ESCAPES.get(m[1], m[1]), token.text[1:-1])
        words = [token.text]
        while (more := self._peek()) is not None and more.kind in ("word", "number"):
            self._next += 1
            words.append(more.text)
        return " ".join(words)

    def _unit(self) -> str:
        parts = []
        while (token := self._peek()) is not None and (token.kind == "word" or token.text == "/"):
            self._next += 1
            parts.append(token.text)
        return "".join(parts)

    def _peek(self) -> _Token | None:
        return self._tokens[self._next] if self._next < len(self._tokens) else None

    def _take(self, mark: str) -> bool:
        token = self._peek()
        if token is not None and token.kind == "mark" and token.text == mark:
            self._next += 1
            return True
        return False

    def _expect(self, kind: str) -> _Token:
        token = self._peek()
        if token is None or token.kind != kind:
            raise self._fault("the name of an action")
        self._next += 1
        return token

    def _fault(self, wanted: str) -> PlanError:
        token = self._peek()
        where = "the end" if token is None else f"{token.text!r} at character {token.at + 1}"
        return PlanError(f"Expected {wanted} but found {where} of {self._text[:80]!r}.")
