"""The two kinds of clause with a free part: words to say aloud, and names of places that the map does not have.

Free text would swallow what was meant otherwise ("say hello if you see a cup"), so both are hedged in: what is said
holds no condition unless it is quoted, and a name is short and holds none of the words that names do not have.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from engine.planner.phrases.templates import NOTHING, Context, Templates, render
from engine.planner.text.language import any_of
from engine.planner.text.words import Sentence, Token

MAX_SPEECH = 300
"""Longest text that is said aloud, characters."""

Phrase = tuple[str, ...]
_ADDRESSED = re.compile(
    r"\bto (?:everyone|everybody|them|all|the (?:kids|children|guests|others|family|people)) (?:who is |that are "
    r")?in the \w+"
)
"""Those who are somewhere else are to be gone to: "say hello to everybody in the kitchen"."""


class FreeText:
    """Reads the free part of a clause, as it was written."""

    def __init__(self, sections: Mapping[str, Any], templates: Templates) -> None:
        self._templates = templates
        self._fillers = _phrases(sections["fillers"])
        self._after_speech = _phrases(sections["after_speech"])
        self._articles = frozenset(sections["articles"])
        self._not_in_names = frozenset(sections["not_in_names"])
        self._longest_name: int = sections["longest_name"]
        self._name_endings = frozenset(sections["name_endings"])
        self._conditions = re.compile(any_of(sections["conditions"]))
        self._no_speech = frozenset(sections["no_speech"])
        self._placeholders = frozenset(sections["placeholders"])

    def speech(self, sentence: Sentence, words: Sequence[Token], single: bool) -> str:
        """What the clause asks to say; empty when it asks for nothing of the kind.

        Unless it is quoted it must be a ``single`` segment: "say hello and pick up the cup" are two requests.
        """
        words = _without_first(words, self._fillers)
        said = self._free_part("Say", _without_last(words, self._after_speech)) or self._free_part("Say", words)
        if not all(token.quoted for token in said):
            spoken = " ".join(token.text for token in said)
            if not single or self._conditions.search(spoken) or spoken in self._placeholders:
                return ""
            if said[0].text in self._no_speech or _ADDRESSED.search(spoken):
                return ""
        text = sentence.part(said)
        return text if len(text) <= MAX_SPEECH and text.isprintable() else ""

    def unknown_place(self, sentence: Sentence, words: Sequence[Token], state: Context) -> str:
        """The name of the place that the clause leads to; empty when it leads to none."""
        words = _without_last(_without_first(words, self._fillers), self._fillers)
        name = self._free_part("Somewhere", words, state)
        while len(name) > 1 and name[0].text in self._articles:
            name = name[1:]
        plain = all(token.kind != "quantity" and token.text.replace("'", "").isalnum() for token in name)
        known = self._templates.is_place(" ".join(token.text for token in name))
        if self._name_endings and name and name[-1].text not in self._name_endings:
            return ""
        if len(name) > self._longest_name or not plain or known or self._not_in_names & {token.text for token in name}:
            return ""
        return " ".join(sentence.part(name).split())

    def _free_part(self, intent: str, words: Sequence[Token], state: Context = NOTHING) -> Sequence[Token]:
        """The tokens that fill the wildcard, which stands at the end of every template."""
        match = self._templates.match(render(words)[0], state, "open_intents")
        if match is None or match.intent != intent:
            return ()
        first, length = len(words), 0
        while first and length < len(match.wildcard.split()):
            first -= 1
            length += 2 if words[first].kind == "quantity" else 1  # rendered as its index and unit
        return words[first:]


def _phrases(phrases: Iterable[str]) -> tuple[Phrase, ...]:
    return tuple(sorted((tuple(phrase.split()) for phrase in phrases), key=len, reverse=True))


def _without_first(words: Sequence[Token], phrases: Iterable[Phrase]) -> Sequence[Token]:
    for phrase in phrases:
        if len(phrase) < len(words) and tuple(token.text for token in words[: len(phrase)]) == phrase:
            return _without_first(words[len(phrase) :], phrases)
    return words


def _without_last(words: Sequence[Token], phrases: Iterable[Phrase]) -> Sequence[Token]:
    for phrase in phrases:
        if len(phrase) < len(words) and tuple(token.text for token in words[-len(phrase) :]) == phrase:
            return _without_last(words[: -len(phrase)], phrases)
    return words
