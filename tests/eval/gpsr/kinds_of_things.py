"""What the grammar's commands about things mean: the house that each needs, and what is to be judged.

One function a kind, under the productions that it belongs to, as the grammar's file writes them without metas.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from tests.eval.gpsr.goal import Fact, Goal, MustBe, Side, Want
from tests.eval.gpsr.lexicon import said
from tests.eval.gpsr.making import Kind, Making, Order, Receiver, Undrawable

BOXES: Final = ("cereal", "noodles", "sausages", "pringles", "crackers", "potato chips")
"""Things that something can stand on: what :data:`tests.eval.houses.LOOKS` makes boxes of."""
_LARGEST: Final = frozenset({"biggest", "largest", "heaviest"})
_ABOUT: Final[Mapping[str, tuple[str, ...]]] = {
    "biggest": ("big", "large", "大"), "largest": ("big", "large", "大"), "smallest": ("small", "小"),
    "heaviest": ("heav", "重"), "lightest": ("light", "轻"), "thinnest": ("thin", "narrow", "细"),
}  # fmt: skip
"""Parts of words that a plan must have that is about a property."""
_SIDES: Final[Mapping[str, Side]] = {
    "at the left of": "left", "at the right of": "right", "on top of": "on", "above": "on", "behind": "behind",
    "under": "under",
}  # fmt: skip
_SIZES: Final = (1.0, 0.88, 0.8, 0.75, 0.72)
"""Scales of five things of which one is clearly the largest; the other way round the smallest."""


def _zh(word: str) -> str:
    return said(word, "zh")


def _put(m: Making, thing: str, source: str, at: str, chinese: str) -> Order:
    """A thing comes from a placement or a room onto a placement."""
    if source == at:
        raise Undrawable
    key = m.item(thing, source)
    wants = (Want(("pick",), things=(key,)), Want(("put",), places=(at,)))
    return m.order(chinese, Goal(wants, (MustBe("on", things=(key,), place=at),)))


def _bring(
    m: Making, keys: tuple[str, ...], to: Receiver, chinese: str, answers: Mapping[str, str] | None = None
) -> Order:
    """One of these things comes to somebody."""
    near = (to.place,) if to.place else ("zero", "start")
    wants = (Want(("pick",), things=keys), Want(("give", "put"), to.who, places=near))
    return m.order(chinese, Goal(wants, (MustBe("given", to.key, keys),), answers=answers or {}))


def take_from_room(m: Making) -> Order:
    thing, room, at = m.thing(), m.place("room"), m.place("placement", 2)
    source = m.spot(room)
    return _put(m, thing, source, at, f"把{_zh(room)}里的{_zh(thing)}拿到{_zh(at)}上")


def take_and_place(m: Making) -> Order:
    thing, at = m.thing(), m.place("placement", 2)
    if m.drawn.has("takefrom") or m.drawn.has("goplace"):
        source = m.place("placement", 1)
        where = "去" if m.drawn.has("goplace") else ""
        chinese = f"{where}{_zh(source)}拿{_zh(thing)}，然后放到{_zh(at)}上"
        if not where:
            chinese = f"从{chinese}"
        return _put(m, thing, source, at, chinese)
    return _put(m, thing, m.home(thing, at), at, f"把{_zh(thing)}放到{_zh(at)}上")


def take_past_a_block(m: Making) -> Order:
    thing, at = m.thing(), m.place("placement", 2)
    m.blocked = at
    return _put(m, thing, m.home(thing, at), at, f"把{_zh(thing)}拿到{_zh(at)}")


def bring_from(m: Making) -> Order:
    thing = m.thing()
    source = m.place("placement")
    to = m.receiver()
    led = f"去{_zh(source)}找到{_zh(thing)}，" if m.drawn.has("goplace") else f"从{_zh(source)}拿{_zh(thing)}，"
    return _bring(m, (m.item(thing, source),), to, f"{led}然后拿给{to.chinese}")


def bring(m: Making) -> Order:
    thing, to = m.thing(), m.receiver()
    return _bring(m, (m.item(thing, m.home(thing)),), to, f"把{_zh(thing)}拿给{to.chinese}")


def bring_something_of_a_kind(m: Making) -> Order:
    """The command says the category; the thing is told when the robot asks."""
    filled = m.drawn.filled("object")
    to = m.receiver()
    others = [name for name in m.lexicon.wares_of(filled.said) if name != filled.value]
    key = m.item(filled.value, m.home(filled.value))
    other = m.chance.choice(others)
    m.item(other, m.home(other))
    return _bring(m, (key,), to, f"把{_zh(filled.said)}拿给{to.chinese}", {"": m.here(filled.value)})


def luggage(m: Making) -> Order:
    taxi, bag = m.drawn.word("taxi"), m.drawn.word("luggage")
    wants = (Want(("pick",)), Want(("put",), places=("taxi",)))
    goal = Goal(wants, cannot=f"a {bag} is too large and too heavy for this hand, and the {taxi} is outside")
    return m.order("把我的行李拿到出租车上", goal)


def bring_the_outermost(m: Making) -> Order:
    source, side = m.place("placement", 2), m.drawn.word("abspos")
    m.clear.add(source)
    keys: list[str] = []
    for name in m.others(count=5):
        keys.append(m.item(name, source, beside=("right", keys[-1]) if keys else None))
    to = m.receiver()
    wanted = keys[0] if side.startswith("left") else keys[-1]
    return _bring(m, (wanted,), to, f"把{_zh(source)}上{_zh(side)}的东西拿给我")


def bring_from_beside(m: Making) -> Order:
    source, word = m.place("placement", 2), m.drawn.word("relpos")
    other, side = m.drawn.fill("object"), _SIDES[word]
    thing = m.chance.choice([box for box in BOXES if box != other])
    if side == "on" and other not in BOXES:
        raise Undrawable
    m.clear.add(source)
    to = m.receiver()
    if side == "under":
        key = m.item(thing, source)
        m.item(other, source, beside=("on", key))
    else:
        key = m.item(thing, source, beside=(side, m.item(other, source)))
    for name in m.others(other, thing, count=3):
        m.item(name, source)
    return _bring(m, (key,), to, f"把{_zh(source)}上{_zh(other)}{_zh(word)}的东西拿给我")


def _sized(m: Making, source: str, prop: str, category: str, most: int = 1) -> tuple[str, ...]:
    """Five things on a placement, so many of which are the largest or the smallest; the keys of those."""
    m.clear.add(source)
    scales = _SIZES if prop in _LARGEST else tuple(0.72 / scale for scale in _SIZES)
    if most == 3:
        scales = (1.0, 0.97, 0.94, 0.75, 0.72) if prop in _LARGEST else (0.72, 0.74, 0.76, 0.97, 1.0)
    # Sizes are told apart among things of one shape, and so are those of each category.
    names = list(m.lexicon.wares_of(category) if category else BOXES)
    names = m.chance.sample(names, min(5, len(names)))
    keys = [m.item(name, source, scale=scale) for name, scale in zip(names, scales, strict=False)]
    if category:
        for name in m.others(*m.lexicon.wares_of(category), count=5 - len(names)):
            m.item(name, source)
    return tuple(keys[:most])


def _category(m: Making) -> str:
    return m.drawn.fill("category") if any(one.slot.kind == "category" for one in m.drawn.tree.fills()) else ""


def bring_the_most(m: Making) -> Order:
    source, prop, category = m.place("placement", 2), m.drawn.word("oprop"), _category(m)
    keys = _sized(m, source, prop, category)
    return _bring(m, keys, m.receiver(), f"把{_zh(source)}上{_zh(prop)}的{_zh(category) if category else '东西'}拿给我")


def tell_the_most(m: Making) -> Order:
    source, prop, category = m.place("placement"), m.drawn.word("oprop"), _category(m)
    keys = _sized(m, source, prop, category)
    what = _zh(category) if category else "东西"
    return _told_things(m, keys, source, f"告诉我{_zh(source)}上{_zh(prop)}的{what}是什么")


def tell_the_three_most(m: Making) -> Order:
    source, prop, category = m.place("placement"), m.drawn.word("oprop"), _category(m)
    keys = _sized(m, source, prop, category, most=3)
    what = _zh(category) if category else "东西"
    return _told_things(m, keys, source, f"告诉我{_zh(source)}上{_zh(prop)}的三个{what}是哪些")


def _told_things(m: Making, keys: tuple[str, ...], source: str, chinese: str) -> Order:
    about = _ABOUT[m.drawn.word("oprop")]
    wants = (Want(("look", "find"), places=(source,), about=about),)
    wrong = tuple(item.key for item in m.items if item.key not in keys)
    return m.order(chinese, Goal(wants, facts=(Fact(tuple((key,) for key in keys), wrong),)))


def count_things(m: Making) -> Order:
    source, category = m.place("placement"), _category(m)
    m.clear.add(source)
    count = m.chance.randint(1, 3)
    thing = category or m.thing()
    for name in m.lexicon.wares_of(category)[:count] if category else [thing] * count:
        m.item(name, source)
    but = m.lexicon.wares_of(category) if category else (thing,)
    for name in m.others(*but, count=2):
        m.item(name, source)
    goal = Goal((Want(("look", "find"), places=(source,)),), facts=(Fact(number=count),))
    return m.order(f"告诉我{_zh(source)}上有几个{_zh(thing)}", goal)


def find_thing(m: Making) -> Order:
    room, category = m.place("room"), _category(m)
    thing = category or m.drawn.word("object") or m.drawn.filled("object").said
    of_a_kind = thing in m.lexicon.categories
    name = m.chance.choice(m.lexicon.wares_of(thing)) if of_a_kind else thing
    return _find(m, room, [name], f"在{_zh(room)}里找{_zh(thing)}")


def find_three(m: Making) -> Order:
    room, category = m.place("room"), m.drawn.fill("category")
    m.clear.add(room)
    names = m.chance.sample(m.lexicon.wares_of(category), 3)
    return _find(m, room, names, f"在{_zh(room)}里找三个{_zh(category)}")


def _find(m: Making, room: str, names: list[str], chinese: str) -> Order:
    keys = tuple(m.item(name, m.spot(room)) for name in names)
    wants = (Want(("find", "look"), things=keys, places=(room,)),)
    truths = (MustBe("found", things=keys, place=room, count=len(keys)),)
    return m.order(chinese, Goal(wants, truths, (Fact(tuple((key,) for key in keys)),)))


def clean(m: Making) -> Order:
    room = m.place("room")
    m.clear.add(room)
    names = m.others(count=3)
    keys = (m.item(names[0], room), *(m.item(name, m.spot(room)) for name in names[1:]))
    goal = Goal((Want(("clean",), places=(room,)),), (MustBe("put away", things=keys, place=room, count=3),))
    return m.order(f"打扫{_zh(room)}", goal)


def take_out(m: Making) -> Order:
    """Refuse lies on the kitchen's floor, and its way out of this house is the bin."""
    keys = tuple(m.item(name, "kitchen") for name in m.others(count=2))
    m.clear.add("kitchen")
    goal = Goal((Want(("clean", "put", "pick")),), (MustBe("binned", things=keys, count=2),))
    return m.order("把垃圾扔掉", goal)


KINDS: Final[Mapping[tuple[str, str], Kind]] = {
    ("deliver", "$vbbtake the {aobject} from the {room} to the {placement 2}"): take_from_room,
    ("deliver", "$vbbring me the {aobject} from the {placement}"): bring_from,
    ("deliver", "$takefrom and ($delivme | $delivat)"): bring_from,
    ("deliver", "$takefrom and $place"): take_and_place,
    ("deliver", "$vbbtake my $luggage to the $taxi"): luggage,
    ("deliver", "$take and $vbplace it on the {placement 2}"): take_and_place,
    ("deliver", "$vbplace the $object on the {placement 2}"): take_and_place,
    ("deliver", "$vbbring me the $object"): bring,
    ("deliver", "$vbdeliver the $object to $someone"): bring,
    ("deliver", "$takefrom and $vbplace it on the {placement 2}"): take_and_place,
    ("deliver", "$goplace , $vbfind the $object , and ($delivme | $delivat)"): bring_from,
    ("deliver", "$goplace , $vbfind the $object , and $place"): take_and_place,
    ("cmancmd", "$vbbtake the {kobject} to the {placement 2}"): take_past_a_block,
    ("cmancmd", "$vbbring me the $abspos object $cmanobjsrc"): bring_the_outermost,
    ("cmancmd", "$vbbring me the object $relpos the {object} $cmanobjsrc"): bring_from_beside,
    ("cmancmd", "$vbbring me the $oprop (object | {category}) $cmanobjsrc"): bring_the_most,
    ("cmancmd", "$vbclean the {room}"): clean,
    ("cmancmd", "$vbtakeout the $garbage"): take_out,
    ("fndobj", "$vbfind the {aobject?} in the {room}"): find_thing,
    ("fndobj", "Tell me how many {category} there are on the {placement}"): count_things,
    ("fndobj", "Tell me what's the $oprop object on the {placement}"): tell_the_most,
    ("fndobj", "Tell me what's the $oprop {category} on the {placement}"): tell_the_most,
    ("fndobj", "$vbfind the {category} in the {room}"): find_thing,
    (
        "fndobj",
        "tell me which are the three $oprop (objects | {category}) on the {placement 1}",
    ): tell_the_three_most,
    ("fndobj", "$vbfind three {category} in the {room}"): find_three,
    ("fndobj", "Tell me how many $object there are on the {placement}"): count_things,
    ("fndobj", "$vbfind the $object in the {room}"): find_thing,
    ("incomplete", "$cmanwarn $vbbring me the {object?}"): bring_something_of_a_kind,
    ("incomplete", "$vbdeliver {object?} to $someone"): bring_something_of_a_kind,
}
