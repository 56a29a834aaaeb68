"""Piles of blocks: what stands one on the other looks like one tall thing, but blocks are cubes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from engine.perception.sighting import Sighting, TagSighting

EDGE: Final = 1.25
"""Edge of a block in edges of its tag's black square: the tag has a white margin."""
_TALL = 1.5  # edges from which it is more than one block


def apart(pile: Sighting, tags: Sequence[TagSighting]) -> tuple[Sighting, ...]:
    """The blocks of a pile, the lowest first; the thing itself when it is none. ``tags`` are those in the picture."""
    width, height = pile.size
    own = [tag for tag in tags if _is_on(tag, pile)]
    if pile.kind != "block" or not (own or pile.complete):
        return (pile,)
    edge = EDGE * sum(tag.size for tag in own) / len(own) if own else width
    if height < _TALL * edge:
        return (pile,)
    count = round(height / edge)
    edge = height / count
    left, top, right, bottom = pile.box
    x, y, _ = pile.position
    blocks = []
    for level in range(count):
        surface = pile.surface + level * edge
        tag = next((tag.id for tag in own if surface + 0.1 * edge < tag.position[2] < surface + 1.1 * edge), None)
        low, high = (bottom - round((bottom - top) * part / count) for part in (level, level + 1))
        blocks.append(
            replace(
                pile,
                box=(left, high, right, low),
                position=(x, y, surface + edge / 2),
                size=(edge, edge),
                surface=surface,
                tag=tag,
            )
        )
    return tuple(blocks)


def _is_on(tag: TagSighting, pile: Sighting) -> bool:
    column, row = tag.corners.mean(axis=0)
    left, top, right, bottom = pile.box
    return bool(left <= column <= right and top <= row <= bottom)
