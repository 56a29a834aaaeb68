"""What is refused before any model is asked: harm, damage, unsafe driving, tampering with safety, spying.

The rules are patterns over the words of a request (``assets/refusals``), of every language at once, and each match is
looked at in its surroundings: what is denied ("don't hit the wall"), asked about ("did you hit the wall?") or feared
("if you hit the wall") is no request. Idioms that only sound violent ("hit the lights") are taken out first.
:func:`impossible` knows the clear cases of what this robot has no body for; they are no refusals, and a request that is
both is refused.

Only what a person said is judged here. Text that was read from a picture or came with the feedback of a skill is data:
it is shown to models as such, is never a request, and never reaches these functions as one.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any, Final, Literal, get_args

from engine.han import SIMPLER, is_chinese
from engine.planner.text.language import read
from engine.planner.text.patterns import written_out

RefusalKind = Literal["harm", "damage", "unsafe", "tamper", "privacy"]


@dataclass(frozen=True, slots=True)
class Refusal:
    """A request that is not carried out."""

    kind: RefusalKind
    reason: str
    """A plain sentence in the language of the request."""


def refusal(text: str) -> Refusal | None:
    """Why ``text`` is refused; None where nothing is wrong with it. Never raises; linear in the length of the text."""
    for reading in _readings(text):
        for rules in _all_rules():
            plain = rules.classed(reading)
            for kind, pattern in rules.refused:
                if rules.asks_for(pattern, plain):
                    return Refusal(kind, _in_language_of(text).reasons[kind])
    return None


def impossible(text: str) -> str | None:
    """A sentence that says what this robot cannot do of what ``text`` asks, and what it can; None where that is not
    clear from the words alone. Never raises."""
    for reading in _readings(text):
        for rules in _all_rules():
            for index, pattern in enumerate(rules.impossible):
                if rules.asks_for(pattern, reading):
                    return _in_language_of(text).cannot[index]
    return None


# From text to readings

_INVISIBLE: Final = re.compile(r"[\u200b-\u200f\u2060-\u2064\ufeff\u00ad]")
_HAN_GAP: Final = re.compile(r"(?<=[\u3400-\u9fff])\s+(?=[\u3400-\u9fff])")
_APOSTROPHES: Final = str.maketrans("’‘", "''")
_SPOKEN: Final = re.compile(r"(?:\b(?:say|repeat|announce|shout|whisper)[,:]?|说[：:]?) *[\"“「][^\"”」]*[\"”」]")
"""What is only to be said aloud."""
_WARNING: Final = re.compile(r"\b(careful|watch out|look out|caution|attention)[,;:!. ]+")
_MARKS: Final = re.compile(r"(?:[;:!?…。，；：！？、\n]|(?<!\d)[.,]|[.,](?!\d))+|(?<=\s)[-–—]+(?=\s)")
_NEITHER: Final = re.compile(r"[^\w'\s.]+|_+")
"""A dot that is left here stands within a number."""


def _readings(text: str) -> Iterator[str]:
    """What was said between two marks, one part after the other, and then all of it as one: recognisers and people
    set commas anywhere. Each is in lower case, single-spaced, and begins and ends with a space."""
    plain = _INVISIBLE.sub("", unicodedata.normalize("NFKC", text)).casefold().translate(SIMPLER)
    plain = _HAN_GAP.sub("", plain.translate(_APOSTROPHES))
    plain = _WARNING.sub(r"\1 ", _SPOKEN.sub(" say ", plain))
    parts = [" ".join(_NEITHER.sub(" ", part).split()) for part in _MARKS.split(plain)]
    parts = [part for part in parts if part]
    for part in parts if len(parts) < 2 else [*parts, " ".join(parts)]:
        yield f" {part} "


# The rules of a language

_FOLDER: Final = files("assets") / "refusals"
_LANGUAGES: Final = ("en", "zh")
_BEFORE: Final = 60
"""Characters before a match that are looked at: the beginning of a long sentence says nothing about its end."""


@dataclass(frozen=True, slots=True)
class _Rules:
    """The patterns of one language and what is answered in it."""

    reasons: Mapping[str, str]
    cannot: Sequence[str]  # one sentence for each of ``impossible``, which are the same in every language
    classes: Mapping[str, str]  # from a word to what it stands for in the patterns of ``refused``
    idioms: re.Pattern[str]
    unasked: re.Pattern[str]
    asked_about: re.Pattern[str] | None
    polite: re.Pattern[str] | None
    refused: Sequence[tuple[RefusalKind, re.Pattern[str]]]
    impossible: Sequence[re.Pattern[str]]

    def classed(self, reading: str) -> str:
        """A reading without its idioms, and with classes ("child") instead of the words of each ("toddlers")."""
        words = self.idioms.sub(" ", reading).split(" ")
        parts = (word.partition("'") for word in words)
        return " ".join(f"{self.classes.get(head, head)}{mark}{tail}" for head, mark, tail in parts)

    def asks_for(self, pattern: re.Pattern[str], reading: str) -> bool:
        """Whether something that matches is wanted, and not denied, asked about or feared."""
        return any(not self._is_unasked(match, reading) for match in pattern.finditer(reading))

    def _is_unasked(self, match: re.Match[str], reading: str) -> bool:
        before = f" {reading[max(0, match.start() - _BEFORE) : match.start()].strip()} "
        if self.unasked.search(before) is not None:
            return True
        if self.asked_about is None or (self.polite is not None and self.polite.search(before) is not None):
            return False
        return self.asked_about.match(reading, match.end()) is not None


@lru_cache
def _all_rules() -> tuple[_Rules, ...]:
    return tuple(_load(language) for language in _LANGUAGES)


def _in_language_of(text: str) -> _Rules:
    return _all_rules()[_LANGUAGES.index("zh" if is_chinese(text) else "en")]


def _load(language: str) -> _Rules:
    sections = read(_FOLDER / f"{language}.yaml")
    # A Chinese word may stand anywhere, an English one stands between spaces.
    begins, ends = ("", "") if language == "zh" else ("(?<= )", "(?![a-z'])")

    def compiled(pattern: str, begin: str = begins, end: str = "") -> re.Pattern[str]:
        return re.compile(f"{begin}(?:{written_out(pattern, sections['parts'])}){end}")

    refused: list[tuple[RefusalKind, re.Pattern[str]]] = [
        (kind, compiled(pattern))
        for kind, patterns in sections["refused"].items()
        if kind in get_args(RefusalKind)
        for pattern in patterns
    ]
    entries: Sequence[Mapping[str, Any]] = sections["impossible"]
    return _Rules(
        reasons=sections["reasons"],
        cannot=tuple(sections["cannot"].format(what=entry["what"]) for entry in entries),
        classes={word: name for name, words in sections.get("classes", {}).items() for word in words.split()},
        idioms=compiled(sections["idioms"], end=ends),
        unasked=compiled(sections["unasked"], begin=""),
        asked_about=compiled(sections["asked_about"]) if "asked_about" in sections else None,
        polite=compiled(sections["polite"]) if "polite" in sections else None,
        refused=refused,
        impossible=tuple(compiled(entry["when"]) for entry in entries),
    )
