"""What the user wants the robot to know: facts in a Markdown file of theirs, ``knowledge.md``.

Each bullet and each paragraph is one fact; headings say what the facts under them are about, and comments are no facts.
A request is told the facts that share words with it, or all of them while they are few. The file is read again when
it has changed; one that cannot be read is an error for people, and then the robot knows what it knew before.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Final

from engine.errors import ExitCode, SaysoError

FILE: Final = "knowledge.md"
"""Name of the file in the user's configuration folder."""
MAX_FILE: Final = 64 * 1024
"""Longest file that is read, bytes: a person's notes, not a library."""
MAX_FACTS: Final = 400
MAX_FACT: Final = 300
"""Longest fact, characters; what is longer is cut at a word."""
FEW: Final = 6
"""A file with no more facts than these is told as a whole."""


class KnowledgeError(SaysoError):
    """The user's knowledge file cannot be used."""

    code = "knowledge"
    exit_code = ExitCode.USAGE


@dataclass(frozen=True, slots=True)
class Fact:
    """One fact and the words that it is found by."""

    text: str
    stems: frozenset[str]


class Knowledge:
    """The facts of one file, always as the file is now."""

    def __init__(self, path: Path | None = None) -> None:
        """``path``: the user's own file, which need not exist; None for one who has none. Reads nothing yet."""
        self._path = path
        self._stamp: tuple[int, int] | None = None
        self._facts: tuple[Fact, ...] = ()
        self._trouble: KnowledgeError | None = None

    @property
    def trouble(self) -> KnowledgeError | None:
        """What is wrong with the file as it was read last, for people."""
        return self._trouble

    def facts(self) -> tuple[str, ...]:
        """Every fact, in the order of the file. Never raises."""
        self._refresh()
        return tuple(fact.text for fact in self._facts)

    def facts_for(self, text: str, limit: int) -> tuple[str, ...]:
        """At most ``limit`` facts that ``text`` may need, the best first; never raises. All facts are candidates
        while the file is small."""
        self._refresh()
        wanted = _stems(text)
        rarity = Counter(stem for fact in self._facts for stem in fact.stems)
        scored = [(sum(1 / rarity[stem] for stem in fact.stems & wanted), -at) for at, fact in enumerate(self._facts)]
        few = len(self._facts) <= FEW
        best = sorted((score for score in scored if score[0] > 0 or few), reverse=True)
        return tuple(self._facts[-at].text for _, at in best[: max(limit, 0)])

    def _refresh(self) -> None:
        if self._path is None:
            return
        try:
            status = self._path.stat()
        except FileNotFoundError:
            self._stamp, self._facts, self._trouble = None, (), None
            return
        except (OSError, ValueError) as error:
            self._trouble = _unreadable(self._path, error)
            return
        stamp = (status.st_mtime_ns, status.st_size)
        if stamp == self._stamp:
            return
        self._stamp = stamp
        try:
            self._facts, self._trouble = read(self._path), None
        except KnowledgeError as error:
            self._trouble = error


def read(path: Path) -> tuple[Fact, ...]:
    """The facts of a file. Raises :class:`KnowledgeError` with what is wrong and what to do."""
    try:
        with path.open("rb") as file:
            content = file.read(MAX_FILE + 1)
    except OSError as error:
        raise _unreadable(path, error) from error
    if len(content) > MAX_FILE:
        raise KnowledgeError(
            f"{path} is longer than {MAX_FILE // 1024} KiB.", hint="Keep the facts that the robot needs, a line each."
        )
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise KnowledgeError(
            f"{path}:{line}: this is not UTF-8 text.", hint="Save the file as UTF-8; every editor can."
        ) from error
    facts = tuple(Fact(fact, _stems(fact)) for fact in parse(text))
    if len(facts) > MAX_FACTS:
        raise KnowledgeError(f"{path} holds {len(facts)} facts; {MAX_FACTS} are read at most.", hint="Remove some.")
    return facts


def packaged() -> str:
    """The commented file that comes with sayso, for users to begin with."""
    return (files("config") / FILE).read_text("utf-8")


def _unreadable(path: Path, error: Exception) -> KnowledgeError:
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return KnowledgeError(
        f"{path} cannot be read: {reason}.", hint="It is your file of facts; see `sayso config path`."
    )


# From Markdown to facts

_COMMENT = re.compile(r"<!--.*?(?:-->|\Z)", re.DOTALL)
_BULLET = re.compile(r"\s*(?:[-*+•]|\d{1,3}[.)、])\s+(?:\[[ xX]\]\s+)?")
_HEADING = re.compile(r"\s{0,3}#{1,6}\s|\s*(?:=+|-{2,}|\*{3,}|_{3,})\s*$|\s*(?:```|~~~)")
_LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
_MARKUP = re.compile(r"[*_`]{1,3}(?=\S)|(?<=\S)[*_`]{1,3}")


def parse(text: str) -> tuple[str, ...]:
    """The bullets and paragraphs of a Markdown text, each as one line of plain text."""
    facts: list[str] = []
    lines: list[str] = []

    def end() -> None:
        if lines:
            facts.append(_plain(" ".join(lines)))
            lines.clear()

    for line in _COMMENT.sub("", text).splitlines():
        bullet = _BULLET.match(line)
        if not line.strip() or _HEADING.match(line):
            end()
        elif bullet is not None:
            end()
            lines.append(line[bullet.end() :].strip())
        else:
            lines.append(line.strip().lstrip(">").strip())
    end()
    return tuple(dict.fromkeys(fact for fact in facts if fact))


def _plain(fact: str) -> str:
    fact = _MARKUP.sub("", _LINK.sub(r"\1", fact))
    fact = " ".join("".join(c if c.isprintable() else " " for c in fact).split())
    return fact if len(fact) <= MAX_FACT else f"{fact[:MAX_FACT].rpartition(' ')[0] or fact[:MAX_FACT]}…"


# Finding

_HAN = re.compile(r"[\u3400-\u9fff\uf900-\ufaff]+")
_LATIN = re.compile(r"[^\W_\u3400-\u9fff\uf900-\ufaff]+(?:'[a-z]+)?")
_COMMON: Final = (
    "a an the i i'm me my we our you your he she it its they them his her is are am was were be been do does did have "
    "has had to of in on at by for from with and or but not no if then when this that these those there here what "
    "which who where how can could will would please should may might so as up down go get want need some any all "
    "bring turn put take give move left right robot"
)
_STOPWORDS: Final = frozenset(_COMMON.split())
"""Words that say nothing about which fact is needed."""
_ENDINGS: Final = ("ingly", "edly", "ings", "ing", "ies", "ied", "ers", "ed", "es", "er", "ly", "y", "s", "e")


def _stems(text: str) -> frozenset[str]:
    """English words without endings, and Chinese characters by twos."""
    plain = text.casefold().replace("’", "'")
    words = (word.partition("'")[0] if word.endswith("'s") else word for word in _LATIN.findall(plain))
    return frozenset({_stem(word) for word in words if word not in _STOPWORDS} | set(_pairs(_HAN.findall(plain))))


@lru_cache(maxsize=4096)
def _stem(word: str) -> str:
    for ending in _ENDINGS:
        if word.endswith(ending) and len(word) - len(ending) >= 3:
            stem = word.removesuffix(ending)
            return stem[:-1] if stem[-1:] == stem[-2:-1] and len(stem) > 3 else stem
    return word


def _pairs(runs: Iterable[str]) -> Iterable[str]:
    for run in runs:
        yield from (run[at : at + 2] for at in range(len(run) - 1)) if len(run) > 1 else run
