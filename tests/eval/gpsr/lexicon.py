"""What the world of a competition has, from its files: rooms, places, things with their kinds, gestures and names.

Also what all of it is called in Chinese; people keep their names.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

Gender = Literal["female", "male"]
Language = Literal["en", "zh"]


@dataclass(frozen=True, slots=True)
class Location:
    """A piece of furniture or a spot that has a name."""

    name: str
    room: str
    is_beacon: bool  # people stand there
    is_placement: bool  # things are put there


@dataclass(frozen=True, slots=True)
class Ware:
    """A thing by its name."""

    name: str
    category: str
    known: bool  # looks always the same; else alike others of its kind
    special: bool  # carries others
    kept: str  # the place where it belongs


@dataclass(frozen=True, slots=True)
class Lexicon:
    """All words."""

    locations: tuple[Location, ...]
    wares: tuple[Ware, ...]
    gestures: tuple[str, ...]
    names: tuple[tuple[str, Gender], ...]
    questions: tuple[str, ...] = ("question",)

    @property
    def rooms(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(location.room for location in self.locations))

    @property
    def categories(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(ware.category for ware in self.wares))

    def room_of(self, location: str) -> str:
        return next((known.room for known in self.locations if known.name == location), location)

    def category_of(self, ware: str) -> str:
        return next(known.category for known in self.wares if known.name == ware)

    def wares_of(self, category: str) -> tuple[str, ...]:
        return tuple(ware.name for ware in self.wares if ware.category == category)


def read_lexicon(folder: Path) -> Lexicon:
    """The words of the XML files of a folder."""
    locations = tuple(
        Location(
            found.attrib["name"],
            room.attrib["name"],
            found.get("isBeacon") == "true",
            found.get("isPlacement") == "true",
        )
        for room in _tree(folder / "Locations.xml").iter("room")
        for found in room.iter("location")
    )
    wares = tuple(
        Ware(
            found.attrib["name"],
            category.attrib["name"],
            found.get("type") == "known",
            found.get("type") == "special",
            category.attrib["defaultLocation"],
        )
        for category in _tree(folder / "Objects.xml").iter("category")
        for found in category.iter("object")
    )
    gestures = tuple(found.attrib["name"] for found in _tree(folder / "Gestures.xml").iter("gesture"))
    names: list[tuple[str, Gender]] = [
        (str(found.text), "female" if found.get("gender") == "Female" else "male")
        for found in _tree(folder / "Names.xml").iter("name")
    ]
    return Lexicon(locations, wares, gestures, tuple(names))


def _tree(file: Path) -> ElementTree.Element:
    return ElementTree.parse(file).getroot()


CHINESE: Final[Mapping[str, str]] = {
    # rooms and places
    "corridor": "走廊", "bedroom": "卧室", "dining room": "餐厅", "living room": "客厅", "kitchen": "厨房",
    "entrance": "入口", "bed": "床", "side table": "边桌", "desk": "书桌", "dining table": "餐桌", "exit": "出口",
    "couch": "沙发", "end table": "茶几", "bookcase": "书架", "cupboard": "橱柜", "storage table": "储物桌",
    "sink": "水槽", "counter": "料理台", "dishwasher": "洗碗机", "taxi": "出租车", "bin": "垃圾桶",
    # kinds of things
    "cleaning stuff": "清洁用品", "containers": "容器", "cutlery": "刀叉", "drinks": "饮料", "food": "食物",
    "fruits": "水果", "snacks": "零食", "tableware": "餐具",
    # things
    "cloth": "抹布", "scrubby": "百洁布", "sponge": "海绵", "cascade pod": "洗碗块", "tray": "托盘", "basket": "篮子",
    "bag": "袋子", "fork": "叉子", "knife": "餐刀", "spoon": "勺子", "chocolate drink": "巧克力饮料", "coke": "可乐",
    "grape juice": "葡萄汁", "orange juice": "橙汁", "sprite": "雪碧", "cereal": "麦片", "noodles": "面条",
    "sausages": "香肠", "apple": "苹果", "orange": "橙子", "paprika": "甜椒", "pringles": "品客薯片",
    "crackers": "饼干", "potato chips": "薯片", "dish": "盘子", "bowl": "碗", "cup": "茶杯",
    # people
    "waving": "挥手", "raising their left arm": "举左手", "raising their right arm": "举右手",
    "pointing to the left": "指向左边", "pointing to the right": "指向右边",
    "sitting": "坐着", "standing": "站着", "lying down": "躺着",
    "man": "男人", "woman": "女人", "boy": "男孩", "girl": "女孩", "male person": "男人", "female person": "女人",
    "men": "男人", "women": "女人", "boys": "男孩", "girls": "女孩", "male": "男的", "female": "女的",
    "people": "人", "guests": "客人", "elders": "老人", "children": "孩子",
    "name": "名字", "gender": "性别", "pose": "姿势",
    # properties and sides
    "biggest": "最大", "largest": "最大", "smallest": "最小", "heaviest": "最重", "lightest": "最轻",
    "thinnest": "最细",
    "left most": "最左边", "right most": "最右边", "at the left of": "左边", "at the right of": "右边",
    "on top of": "上面", "above": "上面", "behind": "后面", "under": "下面",
}  # fmt: skip


def said(word: str, language: Language) -> str:
    """A word of the world in a language; one that has no Chinese stays as it is."""
    return CHINESE.get(word, word) if language == "zh" else word
