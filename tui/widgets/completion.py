"""What somebody who types is about to type: the rest of an earlier request, of a frequent phrase, or of a name.

A suggestion always continues what stands there, and is only that: grey until somebody accepts it. Names are those of
the house in every language that it has; Chinese ones need no space before them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from msgspec import Struct

LEAST: Final = 2
"""Letters of an English word after which it is completed; a Chinese one is after its first character."""
_LONGEST: Final = 40
"""Characters at the end of a line in which the beginning of a name is looked for."""
_BOUNDARY: Final = re.compile(r"(?<!\w)(?=\w)")


class Completion(Struct, frozen=True):
    """What can be completed: names, and phrases in the order in which they are suggested."""

    names: tuple[str, ...] = ()
    phrases: tuple[str, ...] = ()

    def rest(self, text: str, earlier: Sequence[str] = ()) -> str:
        """How ``text`` goes on, to be written behind it; nothing when nobody knows. ``earlier``: requests, the newest
        last, which are likelier than phrases."""
        if not text.strip():
            return ""
        return self._whole(text, (*reversed(earlier), *self.phrases)) or self._name(text)

    @staticmethod
    def _whole(text: str, lines: Iterable[str]) -> str:
        if len(text) < LEAST and text.isascii():
            return ""
        folded = text.casefold()
        return next((line[len(text) :] for line in lines if _begins(line, folded)), "")

    def _name(self, text: str) -> str:
        """The rest of a name that the text ends in the beginning of; the longest beginning counts."""
        for beginning in _beginnings(text):
            folded = beginning.casefold()
            if folded in self.names:
                return ""
            for name in self.names:
                if _begins(name, folded):
                    return name[len(beginning) :]
        return ""


def _begins(line: str, folded: str) -> bool:
    return len(line) > len(folded) and line[: len(folded)].casefold() == folded


def _beginnings(text: str) -> Iterator[str]:
    """The ends of a text that may be the beginning of a name, the longest first."""
    start = max(0, len(text) - _LONGEST)
    for match in _BOUNDARY.finditer(text, start):
        if len(text) - match.start() >= LEAST or not text[match.start() :].isascii():
            yield text[match.start() :]
    for at in range(start + 1, len(text)):
        if not text[at].isascii() and text[at - 1].isalnum():
            yield text[at:]
