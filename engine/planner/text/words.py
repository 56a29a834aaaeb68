"""The words of a sentence, with their places in it.

People type and recognisers write the same command in many ways: capitals, hyphens, typographic quotes, full stops.
:func:`words_of` turns a sentence into tokens that look the same however it was written, and each token remembers
where it stood, so that what is quoted back ("say …", the part that was not understood) is the speaker's own text. Each
Chinese character is a token of its own.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from engine.han import HAN, SIMPLER

Kind = Literal["word", "mark", "number", "quantity"]


@dataclass(frozen=True, slots=True)
class Token:
    """A word, a punctuation mark that separates, a bare number, or a number with a unit."""

    kind: Kind
    text: str  # in lower case; a number as digits
    start: int  # character span in the sentence
    end: int
    value: float = 0.0  # of a number or quantity, in ``unit``
    unit: str = ""  # of a quantity: m, deg, s, m/s, rad/s or times
    quoted: bool = False  # stands between quotation marks


@dataclass(frozen=True, slots=True)
class Sentence:
    """What was said, and its tokens."""

    text: str
    tokens: tuple[Token, ...]

    def part(self, tokens: Sequence[Token]) -> str:
        """The speaker's own text from the first to the last of ``tokens``."""
        return self.text[tokens[0].start : tokens[-1].end] if tokens else ""


_QUOTED = re.compile(
    r""" "[^"\n]+" | “[^”\n]+” | «[^»\n]+» | 「[^」\n]+」 | 『[^』\n]+』 | (?<!\w)['‘][^'’\n]+['’](?!\w) """, re.VERBOSE
)
_TOKEN = re.compile(
    rf"""
      (?P<number> (?<!\w)[-+−](?=[\d.])(?:\d+(?:[.,]\d+)*|\.\d+) | \d+(?:[.,]\d+)* | (?<![\w.])\.\d+ )
    | (?P<vulgar> [¼½¾⅐-⅞] )
    | (?P<han>    {HAN} )
    | (?P<word>   (?!{HAN})[^\W\d_](?:(?!{HAN})[^\W_])*(?:['’](?:(?!{HAN})[^\W_])+)* )
    | (?P<mark>   [,;:.!?…\n。，；：！？、～¿¡؟–—―]+ | (?<=\s)-+(?=\s) | (?<={HAN})\s+(?={HAN}) )
    | (?P<skip>   [\s_"'“”‘’«»()\[\]「」『』《》【】（）]+ | - )
    | (?P<other>  . )
    """,
    re.VERBOSE | re.DOTALL,
)
_THOUSANDS = re.compile(r"[1-9]\d{0,2}(?:,\d{3})+(?:\.\d+)?")
_DECIMAL = re.compile(r"\d*(?:[.,]\d+)?")
_FULL_WIDTH = str.maketrans("．－＋％／", ".-+%/")
"""Beside Chinese, figures are often as wide as its characters; wide digits need no help."""
_MAX_DIGITS = 15
"""More digits than a double holds are no measurement."""


def words_of(text: str) -> Sentence:
    """Split ``text`` into tokens. Any text will do; what is neither word, number nor mark is a word of its own.

    Recognisers write a space between Chinese characters where they would write a comma in English.
    """
    text = unicodedata.normalize("NFC", text)
    quotes = [match.span() for match in _QUOTED.finditer(text)]
    tokens = []
    for match in _TOKEN.finditer(text.translate(_FULL_WIDTH)):
        kind, found = match.lastgroup, match[0]
        if kind == "skip":
            continue
        start, end = match.span()
        quoted = any(left < start < right for left, right in quotes)
        value = _value(found) if kind == "number" else unicodedata.numeric(found) if kind == "vulgar" else None
        if value is not None:
            tokens.append(Token("number", digits(value), start, end, value, quoted=quoted))
        elif kind == "mark":
            if not quoted:  # what is quoted stays in one piece
                tokens.append(Token("mark", found, start, end))
        elif found == "&":
            tokens.append(Token("word", "and", start, end, quoted=quoted))
        else:
            word = unicodedata.normalize("NFKC", found).casefold().replace("’", "'").translate(SIMPLER)
            tokens.append(Token("word", word, start, end, quoted=quoted))
    return Sentence(text, tuple(tokens))


def digits(value: float) -> str:
    """``value`` as people write it: no exponent, no trailing zeros."""
    return f"{value:.6f}".rstrip("0").rstrip(".")


def merged(tokens: Sequence[Token], start: int, end: int, value: float, unit: str) -> Token:
    """The tokens from ``start`` to before ``end`` as one number; as one quantity where there is a ``unit``."""
    first, last = tokens[start], tokens[end - 1]
    kind = "quantity" if unit else "number"
    return Token(kind, digits(value), first.start, last.end, value, unit, first.quoted)  # type: ignore[arg-type]


def _value(written: str) -> float | None:
    """Number as written; a comma stands for thousands where it can ("1,500"), else for the decimal point ("1,5")."""
    sign = -1.0 if written[0] in "-−" else 1.0
    written = written.lstrip("+-−")
    if len(written) > _MAX_DIGITS:
        return None
    if _THOUSANDS.fullmatch(written):
        return sign * float(written.replace(",", ""))
    if _DECIMAL.fullmatch(written):
        return sign * float(written.replace(",", "."))
    return None
