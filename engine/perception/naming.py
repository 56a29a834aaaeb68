"""Words for things: what ``the red box``, ``block 3`` or 红色的盒子 asks for, and whether a thing is it."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Final, Literal, get_args

from config.nearest import nearest
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

    def __init__(self, message: str, *, hint: str = "", near: str = "") -> None:
        """``near`` is what was probably meant."""
        super().__init__(message, hint=" ".join(filter(None, (near and f"Did you mean {near}?", hint))))
        self.near = near
        self.known = hint
        """What else there is."""


Rank = Literal[
    "nearest", "farthest", "leftmost", "rightmost", "biggest", "smallest", "tallest", "shortest", "heaviest",
    "lightest", "thinnest",
]  # fmt: skip
"""Which one of several; what is left and right is as the robot sees it."""
Side = Literal["left of", "right of", "behind", "in front of", "next to", "on top of", "under"]
"""Where a thing is, by another one, as the robot sees it."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is asked for; None leaves open."""

    kind: Kind | None = None
    colour: Colour | None = None
    tag: int | None = None
    among: tuple[Wanted, ...] = ()
    """Each of these will do, in place of the above."""
    rank: Rank | None = None
    """Which one of all that fit."""
    beside: tuple[Side, Wanted] | None = None
    """The one by another thing."""

    @property
    def is_choice(self) -> bool:
        """Whether all that fit must be seen before it is known which one is meant."""
        return self.rank is not None or self.beside is not None

    def fits(self, kind: Kind, colour: Colour, tag: int | None) -> bool:
        """Whether a thing may be what is wanted. A block may be asked for as a box."""
        if self.among:
            return any(one.fits(kind, colour, tag) for one in self.among)
        if self.tag is not None:
            return tag == self.tag and kind != "person"
        kinds: tuple[Kind | None, ...] = (None, "thing", kind, *(("box",) if kind == "block" else ()))
        return self.kind in kinds and self.colour in (None, colour) and (kind != "person" or self.kind == "person")

    def covers(self, other: Wanted) -> bool:
        """Whether everything that ``other`` asks for is what is wanted here."""
        if self.among:
            return any(one.covers(other) for one in self.among)
        if self.tag is not None:
            return other.tag == self.tag
        return self.kind in (None, "thing", other.kind) and self.colour in (None, other.colour)

    def __str__(self) -> str:
        if self.among:
            plain = f"{'of ' if self.rank else ''}{' or '.join(map(str, self.among))}"
        elif self.tag is not None:
            plain = f"block {self.tag}"
        else:
            plain = " ".join(filter(None, (self.colour, self.kind or "thing")))
        beside = f"{self.beside[0]} {self.beside[1]}" if self.beside else None
        return " ".join(filter(None, (self.rank, plain, beside)))


def wanted(words: str) -> Wanted:
    """What these words ask for, in English or Chinese. Raises :class:`UnknownObject`."""
    plain = _in_english(words.lower())
    if (beside := parted(plain)) is not None:
        head, side, anchor = beside
        return replace(wanted(head), beside=(side, wanted(anchor)))
    if (found := _RANK.search(plain)) is not None:
        rest = f"{plain[: found.start()]} {plain[found.end() :]}".strip()
        return replace(wanted(rest.removeprefix("of ") or "thing"), rank=_RANK_WORDS[found["rank"]])
    if " or " in plain:
        return Wanted(among=tuple(wanted(one) for one in plain.split(" or ")))
    return _plainly_wanted(words, plain)


def is_choice(words: str) -> bool:
    """Whether these words single one thing out of all that fit; never raises."""
    try:
        return wanted(words).is_choice
    except UnknownObject:
        return False


def ranked(words: str) -> tuple[Rank | None, str]:
    """The rank in these words, and what is left of them: "the largest fruit" is the biggest "fruit"."""
    plain = _in_english(words.lower())
    found = _RANK.search(plain)
    if found is None:
        return None, words
    return _RANK_WORDS[found["rank"]], f"{plain[: found.start()]} {plain[found.end() :]}".strip()


def parted(words: str) -> tuple[str, Side, str] | None:
    """A thing by another one: the words for it, on which side, and the words for the other one."""
    plain = _in_english(words.lower())
    found = _BESIDE.search(plain)
    return None if found is None else (plain[: found.start()], _SIDE_WORDS[found["side"]], plain[found.end() :])


def _plainly_wanted(words: str, plain: str) -> Wanted:
    kind: Kind | None = None
    colour: Colour | None = None
    tag: int | None = None
    for word in re.findall(rf"[a-z]+|\d+|{HAN}+", plain):
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
            near = nearest(word, (*KINDS, *get_args(Colour)))
            raise UnknownObject(
                f"I do not know what {words!r} looks like.",
                hint=f"I know {', '.join(sorted(set(KINDS) - {'thing'}))}, and {', '.join(get_args(Colour))}.",
                near=near and plain.replace(word, near, 1),
            )
    if kind is None and colour is None and tag is None:
        raise UnknownObject(f"{words!r} names nothing that I could look for.")
    if tag is not None and kind not in (None, "block", "thing", "box"):
        raise UnknownObject(f"Only blocks have numbers, not a {kind}.")
    return Wanted("block" if tag is not None else kind, colour, tag)


def _in_english(words: str) -> str:
    """With the Chinese words that are known in English, and without those that change nothing."""
    plain = words.translate(SIMPLER)
    plain = _BESIDE_ZH.sub(lambda found: f"{found['head']} {_SIDES_ZH[found['side']]} {found['anchor']}", plain)
    plain = _RANK_ZH.sub(lambda found: f" {_RANKS_ZH[found[1]]} ", plain)
    plain = _CHINESE_ARTICLES.sub(" ", plain)
    plain = _CHINESE.sub(lambda found: f" {CHINESE[found[0]]} ", plain).translate(_NUMERALS)
    return " ".join(plain.split()) if plain != words else words


_RANK_WORDS: Final[dict[str, Rank]] = {
    **{rank: rank for rank in get_args(Rank)},
    "closest": "nearest", "furthest": "farthest", "left most": "leftmost", "left-most": "leftmost",
    "right most": "rightmost", "right-most": "rightmost", "largest": "biggest", "littlest": "smallest",
    "tiniest": "smallest", "highest": "tallest", "slimmest": "thinnest", "narrowest": "thinnest",
}  # fmt: skip
_RANK: Final = re.compile(
    rf"\b(?:(?:that|which)(?:'s| is| are) (?:the )?)?(?P<rank>{'|'.join(sorted(_RANK_WORDS, key=len, reverse=True))})\b"
    r"(?: (?:to|from) (?:you(?:rself)?|here|the robot)\b)?"
)
_RANKS_ZH: Final[dict[str, Rank]] = {
    "近": "nearest", "远": "farthest", "左": "leftmost", "右": "rightmost", "大": "biggest", "小": "smallest",
    "高": "tallest", "矮": "shortest", "重": "heaviest", "轻": "lightest", "细": "thinnest", "薄": "thinnest",
}  # fmt: skip
_RANK_ZH: Final = re.compile(f"最([{''.join(_RANKS_ZH)}])[边面侧]?的?")
_SIDE_WORDS: Final[dict[str, Side]] = {
    **{side: side for side in get_args(Side)}, "beside": "next to", "close to": "next to",
    "underneath": "under", "beneath": "under", "below": "under",
}  # fmt: skip
_BESIDE: Final = re.compile(
    rf"\s+(?:(?:that|which) is )?(?:(?:at|to|on) )?(?:the )?(?P<side>{'|'.join(_SIDE_WORDS)})\s+(?=\S)"
)
_SIDES_ZH: Final[dict[str, Side]] = {
    "左": "left of", "右": "right of", "后": "behind", "前": "in front of", "旁": "next to",
    "上": "on top of", "下": "under",
}  # fmt: skip
_BESIDE_ZH: Final = re.compile(
    f"^(?P<anchor>[^最]+?)的?(?P<side>[{''.join(_SIDES_ZH)}])[边面侧](?:的|那[个只])+(?P<head>.+)$"
)
"""The thing on the left of the cup, 杯子左边的东西; "the leftmost one" has no other thing before it."""
