"""The grammar of commands in its own notation: rules, choices, and placeholders that something of the world fills.

A file has one production a line, ``$rule = words | $other (a | b) {placeholder 1 meta: what the referee sees to}``.
Productions of one rule in several lines, or several files, are alternatives. Lines that begin with ``;`` or ``#`` are
comments. A placeholder with ``?`` is named less exactly than it is; ``{void}`` says nothing.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

_TOKEN = re.compile(r"\$\w+|[{}()|]|[^\s{}()|$]+")
_SLOT = re.compile(r"(?P<kind>[a-z]+)(?P<vague>\?)?(?:\s+(?P<number>\d+))?(?:\s+(?P<form>pos))?$")


class GrammarError(ValueError):
    """A line that is not of the notation, or a rule that is nowhere."""


@dataclass(frozen=True, slots=True)
class Text:
    """Words as they stand."""

    words: str

    def __str__(self) -> str:
        return self.words


@dataclass(frozen=True, slots=True)
class Rule:
    """Stands for any production of a rule."""

    name: str

    def __str__(self) -> str:
        return f"${self.name}"


@dataclass(frozen=True, slots=True)
class Slot:
    """A placeholder. Equal numbers mean the same thing within a command, different ones different things."""

    kind: str  # object, placement, name, void…
    number: int | None = None
    vague: bool = False
    possessive: bool = False
    meta: Sequence | None = None

    def __str__(self) -> str:
        number = "" if self.number is None else f" {self.number}"
        return f"{{{self.kind}{'?' if self.vague else ''}{number}{' pos' if self.possessive else ''}}}"


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several sequences, in parentheses."""

    options: tuple[Sequence, ...]

    def __str__(self) -> str:
        return f"({' | '.join(map(str, self.options))})"


@dataclass(frozen=True, slots=True)
class Sequence:
    """Parts one after the other. Its text is that of the file, without metas."""

    parts: tuple[Text | Rule | Slot | Choice, ...]

    def __str__(self) -> str:
        return " ".join(map(str, self.parts))


Grammar = Mapping[str, tuple[Sequence, ...]]
"""The productions of each rule."""


def read_grammar(files: Iterable[Path]) -> Grammar:
    """The rules of all files together. Raises :class:`GrammarError` with file and line."""
    rules: dict[str, tuple[Sequence, ...]] = {}
    for file in files:
        for number, line in enumerate(file.read_text("utf-8-sig").splitlines(), 1):
            try:
                found = production(line)
            except GrammarError as error:
                raise GrammarError(f"{file.name}:{number}: {error}") from None
            if found is not None:
                name, options = found
                rules[name] = (*rules.get(name, ()), *options)
    return rules


def production(line: str) -> tuple[str, tuple[Sequence, ...]] | None:
    """The rule of a line and its alternatives; None for a line that is none."""
    plain = line.strip()
    if not plain or plain[0] in ";#":
        return None
    name, is_rule, body = plain.partition("=")
    if not is_rule or not re.fullmatch(r"\$\w+", name.strip()):
        raise GrammarError(f"{plain!r} is no production")
    reader = _Reader(_TOKEN.findall(body.partition("#")[0]))
    options = reader.options()
    if reader.next is not None:
        raise GrammarError(f"there is a {reader.next!r} too many")
    return name.strip()[1:], options


def missing(grammar: Grammar) -> frozenset[str]:
    """Rules that are spoken of and not defined."""
    found: set[str] = set()

    def look(sequence: Sequence) -> None:
        for part in sequence.parts:
            match part:
                case Rule(name) if name not in grammar:
                    found.add(name)
                case Choice(options):
                    for option in options:
                        look(option)

    for options in grammar.values():
        for option in options:
            look(option)
    return frozenset(found)


class _Reader:
    """Reads the tokens of one production from left to right."""

    def __init__(self, tokens: list[str]) -> None:
        self._tokens, self._at = tokens, 0

    @property
    def next(self) -> str | None:
        return self._tokens[self._at] if self._at < len(self._tokens) else None

    def options(self) -> tuple[Sequence, ...]:
        """Sequences with ``|`` between them, up to what ends them."""
        found = [self._sequence(("|", ")"))]
        while self.next == "|":
            self._at += 1
            found.append(self._sequence(("|", ")")))
        return tuple(found)

    def _sequence(self, ends: tuple[str, ...]) -> Sequence:
        parts: list[Text | Rule | Slot | Choice] = []
        while (token := self.next) is not None and token not in ends:
            self._at += 1
            match token:
                case "{":
                    parts.append(self._slot())
                case "(" if ends == ("}",):
                    parts.append(Text(token))  # a meta is prose
                case "(":
                    parts.append(Choice(self.options()))
                    if self.next != ")":
                        raise GrammarError("a ) is missing")
                    self._at += 1
                case "}":
                    raise GrammarError("a } is there without its {")
                case _ if token.startswith("$"):
                    parts.append(Rule(token[1:]))
                case _:
                    parts.append(Text(token))
        return Sequence(tuple(parts))

    def _slot(self) -> Slot:
        head: list[str] = []
        while (token := self.next) not in (None, "}", "meta:"):
            head.append(str(token))
            self._at += 1
        meta = None
        if self.next == "meta:":
            self._at += 1
            meta = self._sequence(("}",))
        if self.next != "}":
            raise GrammarError("a } is missing")
        self._at += 1
        found = _SLOT.match(" ".join(head))
        if found is None:
            raise GrammarError(f"{{{' '.join(head)}}} is no placeholder")
        number = int(found["number"]) if found["number"] else None
        return Slot(found["kind"], number, found["vague"] is not None, found["form"] is not None, meta)
