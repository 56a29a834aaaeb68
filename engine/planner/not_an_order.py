"""Words because of which a request, or a part of it, is no order: nothing may move on them.

People take back what they have just said ("forget it", "actually no"), forbid ("don't go there"), and speak of orders
without giving one: they report ("she said go left"), suppose ("if I say turn"), quote, ask why, and tell of the past.
Readers of a request skip words; these they may not skip. :func:`marks` finds them, :func:`what_counts` says what is
left of a request whose beginning was taken back, and :func:`without_contrast` drops what only tells the order apart
from another one ("the blue cup, not the red one").

The words (``assets/orders``) are closed classes of the language: negators, words of retraction, of reported speech, of
questions. Polite forms that hold one of them ("why don't you", "if you don't mind") are taken out first.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from functools import cache, lru_cache, reduce
from importlib.resources import files
from operator import getitem
from typing import Final, Literal, NamedTuple, get_args

from engine.han import SIMPLER
from engine.planner.text.language import read
from engine.planner.text.patterns import written_out

MarkKind = Literal["taken_back", "forbidden", "told", "asked"]


class Mark(NamedTuple):
    """A word, or several, because of which something is no order."""

    kind: MarkKind
    words: str
    start: int  # characters of the plain text
    end: int


@lru_cache(maxsize=256)  # several readers of one request ask for the same
def marks(text: str) -> tuple[Mark, ...]:
    """The marks of ``text``, in their order. Never raises; linear in the length of the text."""
    plain = _plain(text)
    words = _words()
    searched = words.polite.sub(lambda found: " " * len(found[0]), plain)
    found = [
        Mark(kind, " ".join(match[0].split()), *match.span())
        for kind, pattern in words.marks
        for match in pattern.finditer(searched)
    ]
    return tuple(sorted(found, key=lambda mark: mark.start))


def what_counts(text: str) -> str | None:
    """What was said after the last word that takes back all before it; empty where nothing was said after it, and None
    where nothing was taken back."""
    back = [mark for mark in marks(text) if mark.kind == "taken_back"]
    if not back:
        return None
    rest = _plain(text)[back[-1].end :]
    return "" if _IDLE.fullmatch(rest) else _JOINT.sub("", rest).strip()


def skipped(text: str, reading: str) -> tuple[Mark, ...]:
    """The marks of ``text`` that ``reading``, the same request in other words, has no longer."""
    left = [(mark.kind, mark.words) for mark in marks(reading)]
    lost: list[Mark] = []
    for mark in marks(text):
        if mark.kind == "forbidden" and _UNTIL.search(_plain(text), mark.end):
            continue
        if (mark.kind, mark.words) in left:
            left.remove((mark.kind, mark.words))
        else:
            lost.append(mark)
    return tuple(lost)


def without_contrast(text: str) -> Iterator[str]:
    """``text`` without what it only contrasts the order with; nothing where it contrasts nothing."""
    plain = _plain(text)
    for pattern in _words().contrasts:
        meant = pattern.sub(lambda found: found.groupdict().get("meant") or "", plain).strip(" ,.;，。")
        if meant != plain.strip(" ,.;，。") and meant and not marks(meant):
            yield meant


def last_clauses(text: str) -> Iterator[str]:
    """The ends of ``text``, the longest first, that may be an order of their own after what is only denied or forbidden
    before it ("you didn't go far enough, go on half a metre"); nothing where it reports or supposes anything."""
    plain = _plain(text)
    found = marks(text)
    if any(mark.kind != "forbidden" for mark in found) or not found:
        return
    for cut in _CUT.finditer(plain, found[-1].end):
        denied = plain[found[-1].end : cut.start()]
        if len(denied.split()) >= 2 or _HAN_PAIR.search(denied):  # and not "don't, I repeat, go there"
            yield plain[cut.end() :]


def question(text: str) -> str:
    """What is asked of the robot about itself (``holding``, ``stopped``, ``battery``, ``done``), or that it shall
    ``continue``; empty where ``text`` is, or holds, anything else."""
    plain = _AROUND.sub("", _plain(text)).strip(" ,.;:!?，。！？")
    return next((name for name, pattern in _words().itself if pattern.fullmatch(plain)), "")


def _plain(text: str) -> str:
    """In lower case, with plain apostrophes and single spaces, without what is only to be said aloud."""
    plain = unicodedata.normalize("NFKC", text).casefold().translate(SIMPLER).replace("’", "'").replace("`", "'")
    return " ".join(_SPOKEN.sub(r"\1\2 ", plain).split())


_SPOKEN: Final = re.compile(
    r"(\b(?:say|repeat|announce|shout|whisper)|说)[,:：]? *(?:[\"“「][^\"”」]*[\"”」])|"
    r"((?:^|[,.;!?] |\band |\bthen )(?:please |just )?(?:say|announce|repeat|shout|whisper)) [^,.;!?]*"
)
_IDLE: Final = re.compile(
    r"(?:[\W_]|\b(?:please|thanks?|thank you|sorry|robot|then|for now|after all|okay|ok|it|that|this|any ?more|i|you|"
    r"said|want|need|don't|do not|will do)\b|谢谢|吧|了|啊|哈|呢|我|你)*"
)
"""Says nothing after a word that takes all back."""
_JOINT: Final = re.compile(r"^(?:[\W_]|(?:and|but|so|then|just|please|instead|rather)\b|还是|就|那|请|那就)*")
_AROUND: Final = re.compile(
    r"^(?:(?:请问|请|喂|嘿)[\s,，:]*|(?:hey|hi|hello|robot|sayso|please|so|and|but|well|ok|okay|now|then|tell me|"
    r"say)\b[\s,，:]*)*|"
    r"[\s,，]*(?:please|robot|sayso|right now|now|then|exactly|actually|again|呢|啊|吗|吧)*[\s?!.。？！]*$"
)
_CUT: Final = re.compile(
    r"[,.;!?，。；！？]\s*(?:(?:so|but|just|and|now|please|instead)\b[\s,]*)*|\b(?:so|but)\b[\s,]*"
)
_HAN_PAIR: Final = re.compile(r"[\u3400-\u9fff]{2}")
_UNTIL: Final = re.compile(r"\b(?:until|till|before)\b")
""" "Don't go until you have waved" orders both, and tells which comes first."""


class _Words(NamedTuple):
    """The patterns of all languages: a sentence may hold words of two."""

    polite: re.Pattern[str]
    marks: tuple[tuple[MarkKind, re.Pattern[str]], ...]
    contrasts: tuple[re.Pattern[str], ...]
    itself: tuple[tuple[str, re.Pattern[str]], ...]


@cache
def _words() -> _Words:
    languages = [read(files("assets") / "orders" / f"{language}.yaml") for language in ("en", "zh")]

    def written(*keys: str) -> Iterator[str]:
        for words in languages:
            for pattern in reduce(getitem, keys, words):
                yield written_out(pattern, words["parts"])

    def any_of(*keys: str) -> re.Pattern[str]:
        return re.compile("|".join(written(*keys)))

    return _Words(
        any_of("polite"),
        tuple((kind, any_of(kind)) for kind in get_args(MarkKind)),
        tuple(map(re.compile, written("contrasts"))),
        tuple((name, any_of("itself", name)) for name in languages[0]["itself"]),
    )
