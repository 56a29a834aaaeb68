"""Continue, undo and again as whole sentences, recognised from bare text in any language: a closed class of words, so
that what the console offers is understood for certain, also without the learned reader. All else is for the reader.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Literal, get_args

from engine.planner.text.language import all_phrases
from engine.planner.text.words import words_of

FollowUp = Literal["resume", "undo", "again"]


def follow_up(text: str) -> FollowUp | None:
    """What ``text`` as a whole asks for, where it is one of these words and nothing else."""
    return _said().get(_bare(text))


@lru_cache
def _said() -> dict[str, FollowUp]:
    kinds: tuple[FollowUp, ...] = get_args(FollowUp)
    return {
        _bare(words): kind
        for sections in all_phrases().values()
        for kind in kinds
        for words in sections["follow_up"][kind]
    }


def _bare(text: str) -> str:
    """The words alone."""
    return " ".join(token.text for token in words_of(text).tokens if token.kind != "mark")
