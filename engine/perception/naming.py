"""Words for things: what ``the red box``, ``block 3`` or 红色的盒子 asks for, and whether a thing is it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final, get_args

from engine.errors import PlanError
from engine.han import HAN, SIMPLER
from engine.perception.sighting import Colour, Kind

KINDS: Final[dict[str, Kind]] = {
    "box": "box", "cube": "box", "ball": "ball", "cup": "cup", "mug": "cup", "bottle": "bottle", "block": "block",
    "tag": "block", "person": "person", "human": "person", "thing": "thing", "object": "thing", "toy": "thing",
}  # fmt: skip
"""What people call the kinds."""

CHINESE: Final[dict[str, str]] = {
    "盒子": "box", "盒": "box", "箱子": "box", "箱": "box", "方盒": "box", "方块": "box", "立方体": "box",
    "球": "ball", "小球": "ball", "皮球": "ball",
    "杯子": "cup", "杯": "cup", "水杯": "cup", "茶杯": "cup", "马克杯": "cup",
    "瓶子": "bottle", "瓶": "bottle", "水瓶": "bottle",
    "积木": "block", "积木块": "block", "木块": "block", "块": "block", "标签": "tag",
    "人": "person", "东西": "thing", "物体": "thing", "物品": "thing", "玩具": "thing", "物件": "thing",
    "红": "red", "橙": "orange", "橘": "orange", "橘黄": "orange", "黄": "yellow", "绿": "green", "蓝": "blue",
    "紫": "purple", "白": "white", "灰": "grey", "黑": "black",
}  # fmt: skip
"""Chinese words for kinds and colours, in English."""

_CHINESE: Final = re.compile("|".join(sorted(CHINESE, key=len, reverse=True)))
_CHINESE_ARTICLES: Final = re.compile("颜?色的?|[的个只号]|编号|^(?:[这那]|我的|你的|所有)|一(?=[个只])")
_NUMERALS: Final = str.maketrans("一二三四五六七八九", "123456789")
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
            return tag == self.tag and kind != "person"
        kinds: tuple[Kind | None, ...] = (None, "thing", kind, *(("box",) if kind == "block" else ()))
        return self.kind in kinds and self.colour in (None, colour) and (kind != "person" or self.kind == "person")

    def covers(self, other: Wanted) -> bool:
        """Whether everything that ``other`` asks for is what is wanted here."""
        if self.tag is not None:
            return other.tag == self.tag
        return self.kind in (None, "thing", other.kind) and self.colour in (None, other.colour)

    def __str__(self) -> str:
        if self.tag is not None:
            return f"block {self.tag}"
        return " ".join(filter(None, (self.colour, self.kind or "thing")))


def wanted(words: str) -> Wanted:
    """What these words ask for, in English or Chinese. Raises :class:`UnknownObject`."""
    kind: Kind | None = None
    colour: Colour | None = None
    tag: int | None = None
    for word in re.findall(rf"[a-z]+|\d+|{HAN}+", _in_english(words.lower())):
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


def _in_english(words: str) -> str:
    """With the Chinese words that are known in English, and without those that change nothing."""
    plain = _CHINESE_ARTICLES.sub(" ", words.translate(SIMPLER))
    return _CHINESE.sub(lambda found: f" {CHINESE[found[0]]} ", plain).translate(_NUMERALS)
