"""Words for things: what ``the red box``, ``block 3`` or ``a bottle`` asks for, and whether a thing is it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final, get_args

from engine.errors import PlanError
from engine.perception.sighting import Colour, Kind

KINDS: Final[dict[str, Kind]] = {
    "box": "box", "cube": "box", "ball": "ball", "cup": "cup", "mug": "cup", "bottle": "bottle", "block": "block",
    "tag": "block", "person": "person", "human": "person", "thing": "thing", "object": "thing", "toy": "thing",
}  # fmt: skip
"""What people call the kinds."""

_ARTICLES: Final = frozenset({"the", "a", "an", "some", "any", "that", "this", "my", "with", "number"})


class UnknownObject(PlanError):
    """Words that name nothing that can be looked for."""

    code = "unknown_object"


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is asked for; None leaves open."""

    kind: Kind | None = None
    colour: Colour | None = None
    tag: int | None = None

    def fits(self, kind: Kind, colour: Colour, tag: int | None) -> bool:
        """Whether a thing is what is wanted. A block may be asked for as a box."""
        if self.tag is not None:
            return tag == self.tag
        kinds: tuple[Kind | None, ...] = (None, "thing", kind, *(("box",) if kind == "block" else ()))
        return self.kind in kinds and self.colour in (None, colour) and (kind != "person" or self.kind == "person")

    def __str__(self) -> str:
        if self.tag is not None:
            return f"block {self.tag}"
        return " ".join(filter(None, (self.colour, self.kind or "thing")))


def wanted(words: str) -> Wanted:
    """What these words ask for. Raises :class:`UnknownObject`."""
    kind: Kind | None = None
    colour: Colour | None = None
    tag: int | None = None
    for word in re.findall(r"[a-z]+|\d+", words.lower()):
        if word in _ARTICLES:
            continue
        single = next((form for form in (word, word.removesuffix("es"), word.removesuffix("s")) if form in KINDS), word)
        if word in get_args(Colour):
            colour = word
        elif word == "gray":
            colour = "grey"
        elif word.isdigit():
            tag = int(word)
        elif single in KINDS:
            kind = KINDS[single] if kind in (None, "thing") else kind
        else:
            raise UnknownObject(
                f"I do not know what {words!r} looks like.",
                hint=f"I know {', '.join(sorted(set(KINDS) - {'thing'}))}, and {', '.join(get_args(Colour))}.",
            )
    if kind is None and colour is None and tag is None:
        raise UnknownObject(f"{words!r} names nothing that I could look for.")
    if tag is not None and kind not in (None, "block", "thing", "box"):
        raise UnknownObject(f"Only blocks have numbers, not a {kind}.")
    return Wanted("block" if tag is not None else kind, colour, tag)
