"""Meanings in writing: one line with what is meant and what is said.

    go ; put | drive to {1.place: the kitchen} and set {2.thing: it} down

Left of the bar stand acts and structure in the order in which things are to happen, right of it the sentence with its
roles marked; the number is that of the act, counted from the left, conditions and ``instead`` included. ``repeat`` is
number 0. ``~2.place`` at the end of a line: the role has the words that an earlier act has for it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final, NamedTuple

from engine.understanding.acts import ACTS, CONDITIONS, ROLES

STRUCTURE: Final = ("if", "then", "else", "until", "repeat", "end", "together", "retract", "instead", "not", "about")
"""Symbols of a meaning that are neither acts nor conditions nor roles."""
_MARK: Final = re.compile(r"\{(?:(\d+)\.)?([a-z]+): ?([^{}]*)\}")
_SHARED: Final = re.compile(r"\s*~(\d+)\.([a-z]+)")


class NotationError(ValueError):
    """A line that is not in this notation."""


class Step(NamedTuple):
    """One symbol of a meaning; a role has the characters ``start`` to ``end`` of the sentence."""

    symbol: str
    start: int = -1
    end: int = -1


class Example(NamedTuple):
    """A sentence and its meaning."""

    text: str
    steps: tuple[Step, ...]


def read(line: str) -> Example:
    """Read one line. Raises :class:`NotationError`."""
    skeleton, bar, said = line.partition(" | ")
    if not bar:
        raise NotationError(f"no ' | ' in {line!r}")
    shared = _SHARED.findall(said)
    text, marks = _marked(_SHARED.sub("", said).strip())
    symbols = _symbols(skeleton)
    numbers = _numbers(symbols)
    only = max(numbers) if numbers else 1
    roles: dict[int, list[Step]] = {}
    for number, role, start, end in marks:
        roles.setdefault(
            int(number) if number else (0 if role == "times" and "repeat" in symbols else only), []
        ).append(Step(role, start, end))
    for number, role in shared:
        earlier = [
            step for before in sorted(roles) if before < int(number) for step in roles[before] if step.symbol == role
        ]
        if not earlier:
            raise NotationError(f"nothing that ~{number}.{role} could share in {line!r}")
        roles.setdefault(int(number), []).append(earlier[-1])
    steps: list[Step] = []
    for symbol, counted in zip(symbols, numbers, strict=True):
        steps.append(Step(symbol))
        if counted >= 0:
            found = sorted(roles.pop(counted, []), key=lambda step: step.start)
            _check(symbol, found, line)
            steps += found
    if roles:
        raise NotationError(f"roles {roles} belong to no act in {line!r}")
    return Example(text, tuple(steps))


def write(example: Example) -> str:
    """The line of an example."""
    skeleton: list[str] = []
    marks: list[tuple[int, int, str]] = []
    shared: list[str] = []
    number = last = 0
    for step in example.steps:
        if step.start < 0:
            if step.symbol == "repeat":
                number = 0
            elif step.symbol in ACTS or step.symbol in CONDITIONS or step.symbol == "instead":
                last += 1
                number = last
            skeleton.append(step.symbol)
        elif any(start < step.end and step.start < end for start, end, _ in marks):
            shared.append(f" ~{number}.{step.symbol}")
        else:
            marks.append((step.start, step.end, f"{number}.{step.symbol}"))
    said = example.text
    for start, end, name in sorted(marks, reverse=True):
        said = f"{said[:start]}{{{name}: {said[start:end]}}}{said[end:]}"
    return f"{' '.join(skeleton)} | {said}{''.join(shared)}"


def _marked(said: str) -> tuple[str, list[tuple[str, str, int, int]]]:
    text, marks, at = "", [], 0
    for mark in _MARK.finditer(said):
        text += said[at : mark.start()]
        words = mark[3].strip()
        marks.append((mark[1] or "", mark[2], len(text), len(text) + len(words)))
        text += words
        at = mark.end()
    text += said[at:]
    if "{" in text or "}" in text:
        raise NotationError(f"a broken mark in {said!r}")
    return text, marks


def _symbols(skeleton: str) -> list[str]:
    """Structure in symbols: a closing bracket is ``end`` where nothing else says that a part is over."""
    words = re.findall(r"[a-z_]+|[();]", skeleton)
    symbols: list[str] = []
    opened: list[str] = []
    for at, word in enumerate(words):
        if word == "(":
            opened.append(symbols[-1] if symbols else "")
        elif word == ")":
            if not opened:
                raise NotationError(f"a bracket too many in {skeleton!r}")
            kind = opened.pop()
            goes_on = words[at + 1 : at + 2] in (["then"], ["else"])
            if kind in ("then", "else", "repeat", "until") and not goes_on:
                symbols.append("end")
        elif word != ";":
            if word not in ACTS and word not in CONDITIONS and word not in STRUCTURE:
                raise NotationError(f"{word!r} in {skeleton!r} is neither an act nor structure")
            symbols.append(word)
    return symbols


def _numbers(symbols: Sequence[str]) -> list[int]:
    numbers, last = [], 0
    for symbol in symbols:
        if symbol == "repeat":
            numbers.append(0)
        elif symbol in ACTS or symbol in CONDITIONS or symbol == "instead":
            last += 1
            numbers.append(last)
        else:
            numbers.append(-1)
    return numbers


def _check(symbol: str, roles: Sequence[Step], line: str) -> None:
    allowed = ROLES if symbol == "instead" else ("times",) if symbol == "repeat" else roles_of(symbol)
    for step in roles:
        if step.symbol not in allowed:
            raise NotationError(f"{symbol} takes no {step.symbol}: {line!r}")


def roles_of(symbol: str) -> tuple[str, ...]:
    """The roles that may stand behind a symbol."""
    if symbol == "instead":
        return ROLES
    if symbol == "repeat":
        return ("times",)
    act = ACTS.get(symbol) or CONDITIONS.get(symbol)
    return act.roles if act is not None else ()
