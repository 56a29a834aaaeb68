"""The symbols that the learned reader writes a meaning in, and which of them may follow which.

The grammar is an automaton: :class:`Grammar` is fed one symbol after the other, and says at each point which ones may
come next. What the reader writes is therefore always a meaning, whatever its weights are.
"""

from __future__ import annotations

from copy import copy
from typing import Final

from engine.understanding.acts import ACTS, CONDITIONS, ROLES
from engine.understanding.notation import STRUCTURE, roles_of

BEGIN: Final = "<begin>"
DONE: Final = "<done>"
SYMBOLS: Final[tuple[str, ...]] = (BEGIN, DONE, *STRUCTURE, *ROLES, *CONDITIONS, *ACTS)
IDS: Final = {symbol: index for index, symbol in enumerate(SYMBOLS)}
MAX_STEPS: Final = 64
ROLE_NAMES: Final = frozenset[str](ROLES)
_SEVERAL: Final = frozenset({"thing", "place", "person"})
"""Roles that an act may have more than one of."""
_BEFORE_ACT: Final = ("not", "about")
_FIRST: Final = (*ACTS, "if", "repeat", "instead", *_BEFORE_ACT)


class Grammar:
    """Where the writing of a meaning has got to."""

    def __init__(self) -> None:
        self._open: list[str] = []
        self._roles: tuple[str, ...] = ()
        self._last = BEGIN
        self._act = False
        """Whether the last thing that was written is an act that is wanted, with or without its roles."""

    def copy(self) -> Grammar:
        """Another one that has got to the same point."""
        other = copy(self)
        other._open = self._open.copy()
        return other

    def allowed(self) -> list[str]:
        """The symbols that may come next."""
        last = self._last
        if last == "if" or last == "until":
            return list(CONDITIONS)
        if last == "not":
            return list(ACTS)
        if last == "about":
            return [*ACTS, "if", "repeat", *(["end"] if self._open else [DONE])]
        if last == "then":
            return [*_FIRST, "else"]  # nothing is to be done where it holds: "unless"
        if last in ("else", "repeat"):
            return [*self._roles, *_FIRST]
        if last == "together":
            return list(ACTS)
        follow: list[str] = list(self._roles)
        if self._open[-1:] == ["if"]:  # in its condition
            return [*follow, "then"]
        if last == BEGIN:
            return [*_FIRST, "retract"]  # what was said before this request
        follow += [*_FIRST, "together", "retract"]
        if self._open[-1:] == ["until"]:  # its condition is one
            return [*self._roles, "end"]
        if self._act:
            follow.append("until")
        if self._open:
            follow.append("end")
            if self._open[-1] == "then":
                follow.append("else")
        else:
            follow.append(DONE)
        return follow

    def feed(self, symbol: str) -> None:
        """Take the next symbol, which must be an allowed one."""
        if symbol in ROLE_NAMES:
            self._last = "role"
            if symbol not in _SEVERAL:
                self._roles = tuple(role for role in self._roles if role != symbol)
            return
        self._act = symbol in ACTS and self._last != "not"
        if symbol in ("if", "until", "repeat"):
            self._open.append(symbol)
        elif symbol in ("then", "else"):
            self._open[-1] = symbol
        elif symbol == "end":
            self._open.pop()
        self._roles = roles_of(symbol)
        self._last = symbol
