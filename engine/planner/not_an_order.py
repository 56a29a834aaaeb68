"""Words because of which a request, or a part of it, is no order: nothing may move on them.

People take back what they have just said ("forget it", "actually no"), forbid ("don't go there"), and speak of orders
without giving one: they report ("she said go left"), suppose ("if I say turn"), quote, ask why, and tell of the past.
Readers of a request skip words; these they may not skip. :func:`marks` finds them, :func:`what_counts` says what is
left of a request whose beginning was taken back.

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

    def is_within(self, other: Mark) -> bool:
        """Whether it is a part of the other: "never" in "never mind"."""
        return other.start <= self.start and self.end <= other.end


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
    taken_back = [mark for mark in found if mark.kind == "taken_back"]
    whole = [mark for mark in found if mark in taken_back or not any(map(mark.is_within, taken_back))]
    return tuple(sorted(whole, key=lambda mark: mark.start))


def what_counts(text: str) -> str | None:
    """What was said after the last word that takes back all before it; empty where nothing was said after it, and None
    where nothing was taken back."""
    back = [mark for mark in marks(text) if mark.kind == "taken_back"]
    if not back:
        return None
    rest = _plain(text)[back[-1].end :]
    return "" if _IDLE.fullmatch(rest) else _JOINT.sub("", rest).strip()


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


class _Words(NamedTuple):
    """The patterns of all languages: a sentence may hold words of two."""

    polite: re.Pattern[str]
    marks: tuple[tuple[MarkKind, re.Pattern[str]], ...]


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
    )
