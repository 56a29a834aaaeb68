"""One sentence, several commands: where one ends and the next begins.

A sentence is cut at punctuation, at joining words ("then", "and") and before words that open a clause of their own
(一边), except inside the names of places ("bed and breakfast room"). Recognisers put punctuation where they please
("Turn left, 90 degrees."), so :func:`interpret` reads from left to right and, where a clause or what follows cannot be
read, tries again with the next one joined to it. What one clause was about (``state``) helps to read the next.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from engine.planner.text.words import Token

R = TypeVar("R")
S = TypeVar("S", bound=Hashable)
Phrase = tuple[str, ...]

MAX_SEGMENTS = 60
"""More commands than a plan may have actions; a longer sentence is not read."""
MAX_JOINED = 3
"""How many segments one clause may span."""


@dataclass(frozen=True, slots=True)
class Segment:
    """A stretch of words without anything that separates, and the joining words in front of it."""

    words: tuple[Token, ...]
    joint: tuple[Token, ...] = ()


def split(
    tokens: Sequence[Token], joints: Sequence[Phrase], names: Sequence[Phrase] = (), openings: Sequence[Phrase] = ()
) -> tuple[Segment, ...]:
    """Cut at every mark and at every one of ``joints``, of which the longer ones stand first, and before every one of
    ``openings``, but not in ``names``."""
    segments: list[Segment] = []
    words: list[Token] = []
    joint: list[Token] = []

    def close() -> None:
        if words:
            segments.append(Segment(tuple(words), tuple(joint)))
            words.clear()
            joint.clear()

    at = 0
    while at < len(tokens):
        if length := max((_name_at(tokens, at, name) for name in names), default=0):
            words.extend(token for token in tokens[at : at + length] if token.kind != "mark")
            at += length
        elif tokens[at].kind != "mark" and (length := _joint_at(tokens, at, openings)):
            close()
            words.extend(tokens[at : at + length])
            at += length
        elif length := _joint_at(tokens, at, joints):
            close()
            joint.extend(token for token in tokens[at : at + length] if token.kind != "mark")
            at += length
        else:
            words.append(tokens[at])
            at += 1
    close()
    return tuple(segments)


def without_frame(tokens: Sequence[Token], frames: Sequence[tuple[Phrase, Phrase]]) -> tuple[Token, ...]:
    """``tokens`` without the words around them that make a request a question (能…吗), and the marks behind those."""
    end = len(tokens)
    while end and tokens[end - 1].kind == "mark":
        end -= 1
    said = tuple(token.text for token in tokens[:end])
    for first, last in frames:
        if len(said) > len(first) + len(last) and said[: len(first)] == first and said[end - len(last) :] == last:
            return tuple(tokens[len(first) : end - len(last)])
    return tuple(tokens)


def _name_at(tokens: Sequence[Token], at: int, name: Phrase) -> int:
    """How many tokens from ``at`` on make up ``name``, marks between its words included; 0 if they do not."""
    end = at
    for word in name:
        while end > at and end < len(tokens) and tokens[end].kind == "mark":
            end += 1
        if end >= len(tokens) or tokens[end].kind == "mark" or tokens[end].text != word:
            return 0
        end += 1
    return end - at


def _joint_at(tokens: Sequence[Token], at: int, joints: Sequence[Phrase]) -> int:
    if tokens[at].kind == "mark":
        return 1
    if tokens[at].quoted:
        return 0
    for joint in joints:
        if tuple(token.text for token in tokens[at : at + len(joint)]) == joint:
            return len(joint)
    return 0


def interpret(
    segments: Sequence[Segment], read: Callable[[tuple[Token, ...], bool, S], tuple[R, S] | None], state: S
) -> tuple[R, ...] | Segment:
    """Read all segments as clauses; else the segment that could not be read, the furthest one reached.

    ``read`` gets the words of one clause, whether they are a single segment, and the state before them; it gives what
    it read and the state after it, or None. Takes at most ``MAX_JOINED`` readings for each segment and state.
    """
    failed: set[tuple[int, S]] = set()
    furthest = 0

    def rest(at: int, state: S) -> tuple[R, ...] | None:
        nonlocal furthest
        if at == len(segments):
            return ()
        if (at, state) in failed:
            return None
        furthest = max(furthest, at)
        for end in range(at + 1, min(at + MAX_JOINED, len(segments)) + 1):
            words = segments[at].words
            for segment in segments[at + 1 : end]:
                words += segment.joint + segment.words
            found = read(words, end == at + 1, state)
            if found is not None and (following := rest(end, found[1])) is not None:
                return (found[0], *following)
        failed.add((at, state))
        return None

    return rest(0, state) or segments[furthest]
