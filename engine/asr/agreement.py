"""Local agreement: which words of a transcript that still grows are certain.

What a recogniser writes at the end of unfinished speech is a guess, and it guesses anew with every word that comes. The
words from the beginning on which its last two answers agree rarely change any more (Liu et al., 2020,
https://arxiv.org/abs/2005.11185; as in whisper_streaming).
"""

from __future__ import annotations

import re

from engine.han import HAN

_WORD = re.compile(rf"{HAN}|(?:(?!{HAN})\S)+")


class Agreement:
    """Takes one transcript after the other of the same speech as it grows."""

    def __init__(self) -> None:
        self._before: list[str] = []

    def add(self, text: str) -> int:
        """How many words of ``text`` the transcript before it has as well, from the first one on."""
        words = normalised_words(text)
        agreed = 0
        for word, before in zip(words, self._before, strict=False):
            if word != before:
                break
            agreed += 1
        self._before = words
        return agreed


def words_of(text: str) -> list[str]:
    """The words of a transcript with their punctuation; a Chinese character is a word of its own."""
    return _WORD.findall(text)


def normalised_words(text: str) -> list[str]:
    """The words of a transcript as they sound: without capitals and punctuation."""
    return [_normalised(word) for word in words_of(text)]


def first_words(text: str, count: int) -> str:
    """The beginning of ``text`` that holds so many words, with the space after it."""
    ends = [match.start() for match in _WORD.finditer(text)][count:]
    return text[: ends[0]] if ends else text


def _normalised(word: str) -> str:
    """Without capitals and the punctuation that a recogniser puts where it believes a sentence to end."""
    return "".join(sign for sign in word.casefold() if sign.isalnum() or sign in "'’°%") or word
