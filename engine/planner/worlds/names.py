"""Names of a world and what they mean: a name, another name, a part of it, with its colour or without, its category.

People say "the box" for a red box where there is one box, "the teddy" for the teddy bear, "a fruit" for an apple. What
fits one thing means it; what fits several is asked about.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, get_args

from engine.errors import PlanError
from engine.perception.naming import KINDS
from engine.perception.sighting import Colour
from engine.skills.vocabulary import Ambiguous

_DEFINITE: Final = frozenset({"the", "my", "your", "our", "this", "that", "his", "her", "their", "whose"})
_INDEFINITE: Final = frozenset({"a", "an", "some", "any", "one", "of", "piece", "another"})
_COLOURS: Final = frozenset({*get_args(Colour), "gray"})
_CHINESE_ARTICLE: Final = re.compile("^(?:[这那]|[我你他她]们?的|一)[个张只把本台]?(?=.)")
_WORDS: Final = re.compile(r"[^\W\d_]+|\d+")


@dataclass(frozen=True, slots=True)
class Named:
    """Something with a name: ``key`` is how the world's file writes it, ``name`` how it is said."""

    key: str
    name: str
    aliases: tuple[str, ...] = ()
    category: str = ""
    colour: str = ""

    def said(self) -> tuple[str, ...]:
        """Every way to say it that means nothing else by itself."""
        coloured = (f"{self.colour} {self.name}",) if self.colour and self.colour not in self.name else ()
        return tuple(dict.fromkeys((self.name, *coloured, *self.aliases)))


@dataclass(frozen=True)
class Names:
    """All names of one sort. ``unknown`` makes the error for words that name nothing here."""

    named: Sequence[Named]
    unknown: Callable[[str], PlanError]
    _exact: dict[str, tuple[str, ...]] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        for one in self.named:
            for word in (one.key, *one.said()):
                keys = self._exact.get(said := " ".join(words_in(word)), ())
                if said and one.key not in keys:
                    self._exact[said] = (*keys, one.key)

    def key(self, words: str) -> str:
        """The key of what is meant. Raises :class:`Ambiguous`, or the error for unknown words."""
        means, any_will_do = self._means(words)
        if not means:
            raise self.unknown(words)
        if len(means) > 1 and not any_will_do:
            said = [one.name for one in self.named if one.key in means]
            raise Ambiguous(f"Which {_without_articles(words)[0]}: {', '.join(said[:-1])} or {said[-1]}?")
        return means[0]

    def keys(self, words: str) -> tuple[str, ...]:
        """The keys of everything that the words fit."""
        return self._means(words)[0]

    @cached_property
    def categories(self) -> tuple[str, ...]:
        """Words for the categories there are, of one and of several."""
        named = dict.fromkeys(one.category for one in self.named if one.category)
        return tuple(dict.fromkeys(word for category in named for word in (category, *_one_and_several(category))))

    def _means(self, words: str) -> tuple[tuple[str, ...], bool]:
        plain, any_will_do = _without_articles(words)
        parts = words_in(plain)
        if exact := self._exact.get(" ".join(parts), ()):
            return exact, any_will_do
        colours = {_colour(part) for part in parts if part in _COLOURS}
        rest = [part for part in parts if part not in _COLOURS]
        if not parts or (not rest and not colours):
            return (), False
        rest = [] if rest == ["thing"] else rest
        fitting = [one for one in self.named if set(rest) <= _described(one)]
        if colours:
            of_colour = [one for one in fitting if colours <= _colours(one)]
            fitting = of_colour or [one for one in fitting if rest and not _colours(one)]
        whole = [one for one in fitting if rest and words_in(one.category) == tuple(rest)]
        return tuple(one.key for one in whole or fitting), any_will_do


def words_in(text: str) -> tuple[str, ...]:
    """The words of a name as they are compared: lower case, singular, mugs are cups."""
    return tuple(_singular(part) for part in _WORDS.findall(text.casefold().replace("'", "").replace("’", "")))


def spoken(key: str) -> str:
    """How a name from a file is said: ``living room`` for ``living_room``."""
    return " ".join(key.replace("_", " ").split())


def _singular(word: str) -> str:
    for form in (word, word.removesuffix("es"), word.removesuffix("s")):
        if form in KINDS and KINDS[form] != "thing":
            return KINDS[form]
    if word.endswith("ies") and len(word) > 4:
        return f"{word[:-3]}y"
    if word.endswith(("ches", "shes", "xes", "sses", "oes")):
        return word[:-2]
    return word[:-1] if word.endswith("s") and not word.endswith(("ss", "us", "is")) and len(word) > 3 else word


def _one_and_several(category: str) -> tuple[str, ...]:
    head, _, last = category.rpartition(" ")
    one = _singular(last)
    return tuple(f"{head} {word}".strip() for word in (one, f"{one}s")) if category.isascii() else ()


def _without_articles(words: str) -> tuple[str, bool]:
    """The words without articles in front, and whether any thing of the sort will do ("a fruit", "one of the cups")."""
    parts = spoken(_CHINESE_ARTICLE.sub("", words.strip())).split()
    any_will_do = False
    while len(parts) > 1 and parts[0].casefold() in _DEFINITE | _INDEFINITE:
        any_will_do = any_will_do or parts[0].casefold() in _INDEFINITE
        del parts[0]
    return " ".join(parts), any_will_do


def _colour(word: str) -> str:
    return "grey" if word == "gray" else word


def _colours(one: Named) -> frozenset[str]:
    parts = (part for text in (one.key, one.colour, *one.said()) for part in words_in(text))
    return frozenset(_colour(part) for part in parts if part in _COLOURS)


def _described(one: Named) -> frozenset[str]:
    """Every word that is true of it."""
    return frozenset(part for text in (one.key, one.category, *one.said()) for part in words_in(text))


def listed(names: Iterable[str]) -> str:
    """``a, b, c``, or ``nothing``."""
    return ", ".join(names) or "nothing"
