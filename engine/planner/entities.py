"""What the noun phrases of a request name in this house, before any skill is chosen.

A phrase is looked up as every type at once: a place to drive to, a surface, a room, a thing, a person, a side of the
robot. What it turns out to be decides which role it can fill and which skill serves. Words that describe a thing
further ("the cup on the table") become a second entity beside it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

from engine.errors import PlanError
from engine.han import is_chinese
from engine.perception.naming import is_choice, parted
from engine.perception.someone import Someone
from engine.planner.amounts import number
from engine.skills.places import ZERO_SYMBOL
from engine.skills.registry import is_said
from engine.skills.vocabulary import Ambiguous, Vocabulary

Side = Literal["left", "right", "behind", "ahead"]

_RELATION: Final = re.compile(
    r"\s+(?:(?:that|which|who)(?:'s| is| are|'re)\s+)?(?:(?:lying|standing|sitting|kept|(?<!the )left|placed)\s+)?"
    r"(?:on top of|in front of|next to|close to|to the (?:left|right) of|(?:at|on) the (?:left|right) of|underneath|"
    r"beside|behind|between|inside|under|near|from|over|off|on|in|at|by)\s+(?=\S)"
)
_OUTER: Final = re.compile(
    r"^(?:(?:on top of|in front of|next to|close to|(?:to |at |on )?the (?:left|right)(?: side)? of|underneath|beside|"
    r"behind|inside|under|near|towards?|into|onto|over at|over by|over in|by|at|in|on|to|from)\s+)+(?=\S)"
)
_DETERMINERS: Final = re.compile(
    r"^(?:(?:all|both|every|each|any|some|one|either) (?:one )?(?:of )?)?"
    r"(?:(?:the|a|an|my|your|our|his|her|their|this|that|these|those|some|another)\s+)*(?=\S)"
)
_BEHIND: Final = re.compile(
    r"(?:[ ,]+(?:please|again|now|too|as well|instead|over there|over here|there|here|will you))+$"
)
_BUT: Final = re.compile(
    r"\s+(?:that (?:isn't|is not|aren't)|which (?:isn't|is not)|who (?:isn't|is not)|but not|"
    r"but|except(?: for)?|other than|not) "
    r"(?=\S)|不是|除了"
)
_IS_NOT: Final = re.compile(r"\b(?:isn't|is not|aren't|but not|other than|except)\b|不是")
_NUMBERED: Final = re.compile(
    r"(?:block|cube|box|tag|marker|apriltag|one)s?(?: (?:with|that has|marked|labelled|labeled|numbered))*"
    r"(?: (?:a|the))?(?: (?:tag|number|no))*"
    r" (?P<n>[\w]+)(?: tag)?(?: on it)?|(?:number|tag|tag number) (?P<m>[\w]+)|"
    r"(?P<zh>[\d一二三四五六七八九十]+)号的?(?P<noun>.*)"
)
"""A block by its number, however that is said."""
_HAS_NUMBER: Final = ("block", "box", "tag")
"""What a block is called: a tray with a number is none."""
_SOME: Final = re.compile(r"^(?:some|any|one|either|a few|several|a couple|\d+|two|three|four|five|six|both)\b|\bof\b")
_ALL: Final = re.compile(
    r"^(?:all|every|everything|everyone|everybody|each|both|whatever|anything)\b|^(?:所有|全部|每|大家)|都"
)
_MEASURE: Final = "[个张只把台本瓶条块件盒袋杯间些颗支根部盏双副罐碗串座扇辆]"
"""Measure words."""
_SO_MANY: Final = re.compile(
    r"(?:(?:the|those|these|my) )?(?P<en>two|three|four|five|[2-5]) (?=[a-z])|"
    rf"[这那]?(?P<zh>[两二三四五2-5]){_MEASURE}(?=.)"
)
_SO_MANY_INNER: Final = re.compile(rf"(?<=的)(?P<zh>[两二三四五2-5]){_MEASURE}(?=.)")
"""The same in the middle of a Chinese phrase: "the biggest three cups"."""
_EVERY_ROOM: Final = re.compile(
    r"^(?:(?:in|into|to|through) )?(?:all|every|each)(?: one)?(?: of)?(?: the| my| our)? (?:single |other )*rooms?\b|"
    r"^(?:所有的?|每一?个?|各个?|全部的?)(?:房间|屋子|屋)"
)
_SUPERLATIVE: Final = re.compile(
    r"\b(?:left|right|upper|lower|top|bottom)[ -]?most\b"
    r"|\b(?:big|larg|small|tall|short|heavi|light|thinn?|old|new)est\b"
    r"|\b(?:first|second|third|last) (?:one|thing|object|item)\b"
    r"|\b(?:other|next)\b|最|另"
)
"""The nearest one is no such thing: a skill takes the nearest that fits."""
_ME: Final = re.compile(
    r"(?:to |for |by |with )?(?:me|us|here|over here|right here|my (?:place|side|spot|position)|where i am|myself)|"
    r"我|我们|咱们?|这|这里|这儿|这边|我(?:这|那)?(?:里|儿|边|面前|身边|手里|手上)|我旁边|本人"
)
_IT: Final = re.compile(
    r"its?|them|that|this|that one|this one|these|those|the (?:thing|object|item|one|same)|"
    r"(?:all of )?'?em|(?:that|this) (?:thing|object|item)|"
    r"(?:them|those|these) (?:both|all|two|three)|(?:both|all|the pair) of (?:them|those|these)|它们?俩|"
    r"[那这]?[把将]?它们?|[把将]?(?:这个|那个|这些|那些|这|那|这东西|那东西|这个东西|那个东西)"
)
_HELD: Final = re.compile(
    r"(?:the thing|whatever|what|that(?: what)?|anything|everything|the one)(?: it is)?(?: that)? "
    r"(?:you(?:'re| are|'ve| have)?(?: got)?|is|there is|you have there)(?: now| still)? ?"
    r"(?:holding|carrying|gripping|hold|carry|got|have|(?:got )?in (?:your|the) (?:hand|gripper|claw|grip|fingers?))"
    r"(?: in (?:your|the) (?:hand|gripper|claw|grip|fingers?))?(?: there)?"
    r"|你?(?:手里|手上|爪子里|夹子里)(?:[拿抓夹攥拎]着?)?的?(?:[那这]个?)?(?:东西|玩意儿?)?|你?[拿抓夹攥拎]着?的(?:那个)?东西"
)
"""What is held, in other words than its name."""
_HELD_THING: Final = re.compile(
    r"(?P<en>(?:the |that |this )?[\w -]+?),? (?:(?:that|which) )?you(?:'re| are|'ve| have)? (?:still |now |already )?"
    r"(?:(?:got |have )?(?:holding|carrying|gripping|hold|carry|(?:got )?in (?:your|the) (?:hand|gripper|claw))|"
    r"got(?! to\b))"
    r"(?: (?:now|there|in (?:your|the) (?:hand|gripper|claw)))*|"
    r"(?P<hand>(?:the |that |this )?[\w -]+?) in your (?:hand|gripper|claw)|"
    r"你?(?:手里|手上|爪子里|夹子里)(?:[拿抓夹攥拎]着?)?的?(?:[那这][个只]?)?(?P<zh>[\u3400-\u9fff]{1,8})|"
    r"你?[拿抓夹攥拎]着的(?:[那这][个只]?)?(?P<taken>[\u3400-\u9fff]{1,8})"
)
"""A thing that is said to be held."""
_STUFF: Final = frozenset({"one", "ones", "stuff", "things", "objects", "items", "bits", "pieces"})
"""Nouns for things of any kind."""
_ONE: Final = re.compile(r"(?P<which>[\w -]+) ones?")
_ONE_ZH: Final = re.compile(rf"(?:[这那]{_MEASURE}?)?(?P<which>[\u3400-\u9fff]+?)色?的(?:那{_MEASURE}?)?")
"""One of a kind that was named before: "the blue one"."""
_REMEMBERED: Final = re.compile(
    r"(?:(?:the|that|your|my) )?(?:saved|stored|remembered|memori[sz]ed|marked|noted|recorded) "
    r"(?:place|spot|position|point|pose|location)|(?:刚才|你)?(?:记住|记下|保存)(?:下来)?的(?:那个)?(?:位置|地方|点)"
)
_LYING_ABOUT: Final = re.compile(
    r"(?<=\w)(?: (?:that|which))?(?:'s| is| are)? (?:lying|left|strewn) (?:about|a?round)(?: here| there)?$"
)
"""What says no more of a thing than that it is somewhere."""
_STUFF_OF_A_KIND: Final = re.compile(r"(?<=\w )stuff$")
_OF_COLOUR: Final = re.compile(r"\b(\w+) (?:of|in) (?:the )?(?:colou?r (\w+)|(\w+) colou?r)$")
_NOTHING_SAID: Final = re.compile(
    r"(?:\b(?:the|a|an|my|your|that|this|to|u[hm]+|e+r?h?m+|er|hmm+|well|whatsit|thingy|thingamajig|thingummy|doodah|"
    r"whatchamacallit|what's it called|what's its name|you know|the one)\b[ ,.]*)+|"
    r"(?:那个|这个|那什么|那啥|嗯|呃|啥|什么来着)+"
)
"""What a speaker says who has not found the word."""
_WHERE: Final = re.compile(
    r"\bwhere(?:ver)?\b|\b(?:room|place|spot|station|furniture) (?:for|to|in which)\b|的(?:地方|房间|位置|那个?地方)"
)
_USED_FOR: Final[tuple[tuple[re.Pattern[str], Sequence[str]], ...]] = (
    (re.compile(r"\b(?:sleep|sleeps|nap|naps)\b|睡"), ("bedroom", "bed")),
    (re.compile(r"\b(?:charge|charges|charged|charging|recharge)\b|充电"), ("charging dock", "dock")),
    (re.compile(r"\b(?:cook|cooks|cooking|cooked)\b|做饭|煮饭|炒菜"), ("kitchen", "stove")),
    (re.compile(r"\b(?:eat|eats|dine|dines|have (?:our |your )?(?:meals|dinners?|lunch|breakfast))\b|吃饭"),
     ("dining table", "dining room", "kitchen table")),
    (re.compile(r"\b(?:rubbish|trash|garbage|waste|litter)\b|垃圾"), ("bin", "trash can")),
    (re.compile(r"\b(?:clothes|coats|shirts|dresses)\b|衣服"), ("wardrobe", "closet")),
    (re.compile(r"\bbooks\b|书放|放书"), ("bookshelf", "bookcase", "shelf")),
    (re.compile(r"\b(?:bathe|shower|wash (?:ourselves|yourself|themselves))\b|洗澡"), ("bathroom",)),
)  # fmt: skip
"""What is done at a place, and what such a place is called."""
_THERE: Final = re.compile(
    r"there|over there|(?:that|this) (?:place|spot)(?: there| here)?|(?:the )?same (?:place|spot)(?: as before)?|"
    r"(?:right )?where you(?:'re| are)(?: now)?|"
    r"原地|那|那里|那儿|那边"
)
_FLOOR: Final = re.compile(r"floor|ground|carpet|rug")
_FLOOR_OF: Final = re.compile(r"(?P<en>[a-z' ]+?)(?:'s)? floor|(?P<zh>.+?)里?的?(?:地上|地面上?|地板上?)")
_PERSON: Final = re.compile(
    r"\b(?:person|people|man|men|woman|women|boy|girl|kid|kids|child|children|guest|guests|everyone|everybody|someone|"
    r"somebody|anyone|anybody|human|lady|ladies|gentlem[ae]n|guys?|elders?|adults?|folks?|friend|colleague|wife|husband|son|daughter|mother|father|mum|"
    r"mom|dad|grandma|grandpa|granny|brother|sister|neighbou?r|visitor|whoever)\b|"
    r"人|妈|爸|爷|奶|哥|姐|弟|妹|孩|客|老师|同事|先生|女士|大家|他|她|医生"
)
_PEOPLE: Final = re.compile(
    r"(?:people|men|women|boys|girls|kids|children|guests|ladies|gentlemen|guys|elders|adults|folks|friends|visitors|"
    r"colleagues|neighbou?rs)\b|(?<![我你您他她它咱])们|每一?[个位名]|所有的?|大家|各位"
)
"""Several of them, though no word says how many."""
_SIDES: Final[tuple[tuple[Side, re.Pattern[str]], ...]] = (
    ("left", re.compile(r"(?:(?:to|on|over|at) )*(?:the |your )?left(?: hand)?(?: side)?|左|左边|左侧|左面|左手边")),
    ("right", re.compile(r"(?:(?:to|on|over|at) )*(?:the |your )?right(?: hand)?(?: side)?|右|右边|右侧|右面|右手边")),
    ("behind", re.compile(
        r"(?:behind|in back of) (?:you|yourself)|(?:to )?(?:the |your )?(?:back|rear)|backwards?|后|后面|身后|背后|后边"
    )),
    ("ahead", re.compile(
        r"(?:straight )?(?:ahead|forwards?)(?: of you)?|in front(?: of you)?|(?:the )?(?:front|middle|cent(?:re|er))|"
        r"前|前面|前方|正前方|中间|正中|面前"
    )),
)  # fmt: skip
_SIDE_OF: Final = re.compile(r"\b(?:on|to) (?:the |your )(left|right)\b|[你的在](左|右)[边侧手]")
_ZH_INNER: Final = re.compile(rf"(?<=[\u3400-\u9fff])的?[这那]一?{_MEASURE}(?=[\u3400-\u9fff])")
"""In the middle of a noun phrase: "white, that cup" is "that white cup"."""
_ZH_FRONT: Final = re.compile(
    rf"^(?:(?:[这那](?:一?{_MEASURE}|儿的?|里的?)?|[一两几某每]{_MEASURE})|"
    "[我你他她咱](?:们|家)?的|[我你他她](?=[^们的我你他她].)|所有的?|全部的?|在|到|去|从)+(?=.)"
)
_ZH_AT: Final = re.compile(
    "在?(?P<at>.+?)(?:里面?|上面?|旁边?|边上?|那[边里儿]|前面?)?的?(?P<who>(?:穿|正在|坐|站|躺|挥|招|举|指).+|[^的]*(?:人|孩子?|[男女]士|[男女]生|先生|小姐|朋友|客人|访客))"
)
"""Somebody, and before that where they are."""
_VESSEL: Final = re.compile(r".*?[这那一]([瓶杯盒])(?=.)")
"""What measures a drink by what it is in."""
_ZH_BACK: Final = re.compile(
    "(?:(?<=.)那?个?地方|的?(?:[上里下前后外]面|[上里]头)|[这那](?:边|儿|里|头|屋|间屋?|间?房间?|块儿?|个地方)|[上里下前后外]面|旁边|边上|跟前|附近|[上里]头|上|里|下|边|旁|处|中)$"
)


@dataclass(frozen=True, slots=True)
class Entity:
    """What some words can be; None for each type that they cannot be."""

    words: str
    place: str | None = None
    """Symbol of the map."""
    surface: str | None = None
    room: str | None = None
    thing: str | None = None
    """As skills know it (``red box``)."""
    person: str | None = None
    """What is said of a person other than the speaker."""
    side: Side | None = None
    me: bool = False
    """The speaker, or where the speaker is."""
    refers: bool = False
    """It stands for something that was named before ("it", "there")."""
    held: bool = False
    """It stands for what is in the hand."""
    every: bool = False
    """All of its kind are meant."""
    superlative: bool = False
    """It is the biggest, the leftmost, the last one of several: no name tells which."""
    vague: bool = False
    """Nothing is named: the word was not found."""
    which: str = ""
    """The question which one is meant, where the words fit several."""
    at: Entity | None = None
    """Where it is said to be ("on the table")."""

    @property
    def known(self) -> bool:
        """Whether it names anything at all."""
        return any((self.place, self.surface, self.room, self.thing, self.person, self.side, self.me, self.refers))


class Entities:
    """Looks phrases up in one house."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        resolvers = vocabulary.resolvers()
        self._vocabulary = vocabulary
        self._place, self._object = resolvers["place"], resolvers["object"]
        self._surface, self._room = resolvers["surface"], resolvers["room"]

    def of(self, words: str) -> Entity:
        """What ``words`` name."""
        plain = " ".join(words.casefold().replace("’", "'").split()).strip(' ,.!?;:，。！？；：、"“”')
        if _ME.fullmatch(plain):
            return Entity(words, place=ZERO_SYMBOL, me=True)
        if _REMEMBERED.fullmatch(plain):
            return Entity(words, place=ZERO_SYMBOL)
        for side, pattern in _SIDES:
            if pattern.fullmatch(plain):
                return Entity(words, side=side)
        plain = _OF_COLOUR.sub(r"\2\3 \1", _LYING_ABOUT.sub("", plain.removesuffix("'s")))
        plain = _STUFF_OF_A_KIND.sub("things", plain)
        if _IT.fullmatch(plain) or _THERE.fullmatch(plain):
            return Entity(words, refers=True)
        if _HELD.fullmatch(plain):
            return Entity(words, refers=True, held=True)
        if (in_hand := _HELD_THING.fullmatch(plain)) is not None:
            return replace(self.of(next(filter(None, in_hand.groups()))), held=True)
        if _NOTHING_SAID.fullmatch(plain):
            return Entity(words, vague=True)
        chinese = is_chinese(plain)
        inner = plain if chinese else _OUTER.sub("", plain)
        if _IT.fullmatch(_ZH_BACK.sub("", plain) if chinese else inner):  # "next to it"
            return Entity(words, refers=True)
        head, where = (plain, "") if chinese or _BUT.search(inner) else _parted(plain)
        candidates = list(dict.fromkeys(_chinese(plain) if chinese else _english(head)))
        bare = () if chinese else (inner, _bare(inner))  # a place may have been named "my corner"
        floor = _FLOOR_OF.fullmatch(plain) if chinese else _FLOOR_OF.fullmatch(_bare(inner))
        rest = tuple(_bare(words.rpartition(" of ")[2]) for words in bare if " of " in words)  # … of the kitchen
        whole = list(dict.fromkeys((*bare, *candidates, *rest)))
        which: list[str] = []
        if not chinese:
            whole += [one[:-1] for one in whole if _ONE_TOO_MANY.search(one)]  # "if the coffee tables free"
        room = self._first(self._room, whole, [])
        if room is None and floor is not None and (around := self.of(floor["en"] or floor["zh"])).room is not None:
            return replace(around, words=words)  # the floor of a room is that room
        whole += self._by_use(plain)
        found = Entity(
            words,
            place=self._first(self._place, whole, which),
            surface=self._first(self._surface, whole, which),
            room=room,
            thing=self._but_for(inner, chinese)
            or self._numbered(inner)
            or self._plainly(inner, candidates, chinese, which),
            person=plain if _PERSON.search(head) else None,
            every=_ALL.search(plain) is not None or _PEOPLE.search(head) is not None,
            superlative=_SUPERLATIVE.search(head) is not None,
            at=self.of(where) if where else None,
        )
        if found.at is not None and found.place is not None:
            found = self._near_there(found, head)
        if found.at is not None and found.at.room and _FLOOR.fullmatch(_bare(head)):
            return replace(found.at, words=words)
        if beside := self._beside(plain):
            found = replace(found, thing=beside, superlative=False, at=None)
        elif found.thing is not None and found.superlative and is_choice(found.thing):
            found = replace(found, superlative=False, every=False)
        if found.thing is not None and _is_plural(head, found.thing):
            found = replace(found, every=True)  # "the red boxes" are all that there are
        many = _SO_MANY.match(plain)
        if many is not None and len(self.members(found)) == number(many["en"] or many["zh"]):
            found = replace(found, every=True)  # "the two cups" of a house that has two
        return _with_question(found, which)

    @staticmethod
    def _by_use(plain: str) -> Sequence[str]:
        """Names of what is used so: "where the rubbish goes", "the room where Mum and Dad sleep"."""
        if (where := _WHERE.search(plain)) is None:
            return ()
        return next((names for use, names in _USED_FOR if use.search(plain, where.start())), ())

    def _near_there(self, found: Entity, head: str) -> Entity:
        """Of several pieces of furniture that are called so the one in the room where it is said to be: "the table by
        the bed"."""
        assert found.at is not None
        room = found.at.room or self.room_of(found.at.surface or "")
        noun = _bare(head).split()[-1:]
        if (
            not room
            or not noun
            or set((found.surface or "").split()) <= set(head.split())
            or self.room_of(found.surface or "") in ("", room)
        ):
            return found
        others = [
            name for name in self._vocabulary.places() if name.split()[-1:] == noun and self.room_of(name) == room
        ]
        return replace(self.of(others[0]), words=found.words, at=found.at) if len(others) == 1 else found

    def like(self, words: str, thing: str) -> str | None:
        """What "the blue one", or "the blue", is where one like ``thing`` is meant; None where it is none of those."""
        plain = " ".join(words.casefold().split()).strip(" ,.!?;:，。！？；：、")
        chinese = is_chinese(plain)
        found = _ONE_ZH.fullmatch(plain) if chinese else _ONE.fullmatch(_DETERMINERS.sub("", _BEHIND.sub("", plain)))
        which = found["which"] if found is not None else ""
        of_any_kind = self.of(f"{which}东西" if chinese else f"{which} thing").thing if which else self.of(words).thing
        if of_any_kind is not None and of_any_kind.endswith(" thing"):
            which = of_any_kind.removesuffix(" thing")
        if not which or not thing:
            return None
        try:
            return self._object(f"{which} {thing.split()[-1]}")
        except PlanError:
            return None

    def somebody(self, words: str) -> tuple[Someone, str]:
        """Who is meant, and the words for where they are said to be: "the person in red in the kitchen". Raises
        :class:`UnknownPerson`."""
        plain = " ".join(words.replace("’", "'").split()).strip(' ,.!?;:，。！？；：、"“”')
        if is_chinese(plain):
            found = _ZH_AT.fullmatch(plain)
            if found is not None and self._is_spot(found["at"]):
                return self._vocabulary.people.who(found["who"]), found["at"]
            return self._vocabulary.people.who(plain), ""
        for found in reversed(list(_RELATION.finditer(plain.casefold()))):
            where = plain[found.end() :]
            if self._is_spot(where):
                return self._vocabulary.people.who(plain[: found.start()]), where
        return self._vocabulary.people.who(plain), ""

    def _is_spot(self, words: str) -> bool:
        found = self.of(words)
        return any((found.room, found.place, found.surface)) and not found.me

    def is_stranger(self, who: Someone) -> bool:
        """Whether only a name is said, and nobody here is known to have it."""
        return self._vocabulary.people.is_stranger(who)

    def is_known(self, words: str) -> bool:
        """Whether these words name somebody whom the robot knows."""
        return bool(self._vocabulary.people.name(words))

    def is_name(self, who: str) -> bool:
        """Whether it is the name of a stranger, and no description."""
        try:
            return self._vocabulary.people.is_stranger(self._vocabulary.people.who(who))
        except PlanError:
            return False

    def is_stranger_called(self, name: str) -> bool:
        """Whether somebody of this name, or this description, is not known by name."""
        return not self._vocabulary.people.name(name)

    def place_name(self, place: str) -> str:
        """What people call a place of the map; a name is what it is called."""
        return self._vocabulary.place_name(place) if self._vocabulary.is_marked(place) else place

    def thing_in(self, text: str) -> str:
        """The thing of this house that a text names last; empty where it names none."""
        return self._named_last(text, self._vocabulary.inventory())

    def place_in(self, text: str) -> str:
        """The place that a text names last; empty where it names none."""
        return self._named_last(text, self._vocabulary.places())

    @staticmethod
    def _named_last(text: str, names: Sequence[str]) -> str:
        plain = text.casefold()
        ends = {name: plain.rfind(name) + len(name) for name in names if is_said(name, plain)}
        return max(ends, key=lambda name: (ends[name], len(name)), default="")

    def side_in(self, words: str) -> Side | None:
        """The side that is spoken of in a description: "the wall on your right"."""
        found = _SIDE_OF.search(words.casefold())
        side = None if found is None else found[1] or found[2]
        return None if side is None else "left" if side in ("left", "左") else "right"

    def near(self, words: str) -> str:
        """``words`` as a name that may be asked back: without what stands around it."""
        plain = " ".join(words.casefold().split()).strip(" ,.!?;:")
        return next(iter(_chinese(plain) if is_chinese(plain) else _english(_parted(plain)[0])), plain)

    def members(self, group: Entity) -> tuple[str, ...]:
        """The names of all things of this house that are meant by a group ("all the cups"); nothing where the house
        has none, or they are of no kind ("everything")."""
        if not group.thing or group.thing == "thing":
            return ()
        known = self._vocabulary.inventory()
        return tuple(name for name in self._vocabulary.fitting(group.thing) if name in known)

    def fitting(self, words: str) -> tuple[str, ...]:
        """The names of all things of this house that the words fit."""
        try:
            return self.members(Entity(words, thing=self._object(self.near(words))))
        except PlanError:
            return ()

    def room_of(self, place: str) -> str:
        """The room of a piece of furniture; empty where it is in none."""
        return self._vocabulary.room_of(place)

    def may_be(self, words: str, thing: str) -> bool:
        """Whether a thing of this house may be called so."""
        return thing in self._vocabulary.fitting(self.near(words))

    def rooms(self) -> tuple[str, ...]:
        """The rooms of this house, in the order of the map."""
        return self._vocabulary.all_rooms()

    def rooms_meant(self, words: str) -> bool:
        """Whether ``words`` are all rooms of the house."""
        return _EVERY_ROOM.search(" ".join(words.casefold().split())) is not None

    def _beside(self, phrase: str) -> str | None:
        """ "The object left of the cup": a thing that another thing tells; a place or furniture tells where it is."""
        if (found := parted(_bare(phrase))) is None:
            return None
        anchor = self.of(found[2])
        if anchor.thing is None or anchor.surface or anchor.place or anchor.room:
            return None
        try:
            return self._object(f"{_bare(found[0])} {found[1]} {anchor.thing}")
        except PlanError:
            return None

    def several(self, words: str) -> tuple[str, int]:
        """Things of a kind, any of which will do, and how many are asked for (0: not said): "the three largest
        drinks", "cups". Empty where it is no kind of thing."""
        plain = " ".join(words.casefold().split()).strip(" ,.!?;:，。！？；：、")
        so_many = _SO_MANY.match(plain) or _SO_MANY_INNER.search(plain)
        count = round(number(next(filter(None, so_many.groups()))) or 0) if so_many is not None else 0
        rest = f"{plain[: so_many.start()]}{plain[so_many.end() :]}" if so_many is not None else _bare(plain)
        for candidate in (_chinese if is_chinese(rest) else _english)(rest):
            if found := self._vocabulary.any_of(candidate):
                return found, count
            try:
                return self._object(candidate), count
            except PlanError:
                continue
        return "", count

    def _first(self, resolve: Callable[[str], str], candidates: list[str], which: list[str]) -> str | None:
        for words in candidates:
            try:
                found = resolve(words)
            except Ambiguous as several:
                if (only := self._only_one(several.names, candidates[0])) is not None:
                    return resolve(only)
                which.append(several.message)
                return None
            except PlanError:
                continue
            return found if self._fits_room(words, candidates[0], found) else None
        return None

    def _only_one(self, names: Sequence[str], phrase: str) -> str | None:
        """The only one of several whose every word stands in the phrase: "the chair on the west side"."""
        said = set(phrase.split())
        meant = [name for name in names if set(name.split()) <= said]
        return meant[0] if len(meant) == 1 else None

    def _fits_room(self, words: str, whole: str, found: str) -> bool:
        """ "The bathroom sink" is no sink of the kitchen: what stands in front of the name must not be another room."""
        before = whole.removesuffix(words).strip(" 的") if whole != words else ""
        if not before:
            return True
        try:
            room = self._room(before)
        except PlanError:
            return True
        return self._vocabulary.room_of(words) in (room, "") or self._vocabulary.room_of(found) in (room, "")

    def _but_for(self, phrase: str, chinese: bool) -> str | None:
        """ "The cup that isn't blue": the only one of those that is none of these."""
        found = _BUT.search(phrase)
        if found is None or not phrase[: found.start()] or not phrase[found.end() :]:
            return None
        first = list((_chinese if chinese else _english)(phrase[: found.start()]))
        noun = first[-1] if first else ""
        others = list((_chinese if chinese else _english)(phrase[found.end() :]))
        every = next((names for words in first if (names := self._vocabulary.fitting(words))), ())
        meant = (*others[:1], *(f"{word} {noun}" for word in others))
        without = {name for words in meant for name in self._vocabulary.fitting(words)}
        left = [name for name in every if name not in without]
        return self._vocabulary.object(left[0]) if len(left) == 1 and len(every) > 1 else None

    def _numbered(self, phrase: str) -> str | None:
        found = _NUMBERED.fullmatch(_DETERMINERS.sub("", phrase))
        said = number(found["n"] or found["m"] or found["zh"]) if found is not None else None
        if found is None or said is None:
            return None
        try:
            if found["noun"] and self._object(found["noun"]).split()[-1] not in _HAS_NUMBER:
                return None
            return self._object(f"block {said:g}")
        except PlanError:
            return None

    def _plainly(self, phrase: str, candidates: list[str], chinese: bool, which: list[str]) -> str | None:
        """A thing that is told by what it is, and not by what it is not."""
        return None if _IS_NOT.search(phrase) else self._thing(candidates, chinese, which)

    def _thing(self, candidates: list[str], chinese: bool, which: list[str]) -> str | None:
        for words in candidates:
            numbered = _NUMBERED.fullmatch(words)
            alone = number(words) is not None or (numbered is not None and numbered["m"])
            if alone and words != candidates[0]:
                continue  # of "tray 4", the number alone: it is that of a tray
            try:
                found = self._object(words)
                return found if found != "thing" or words == candidates[0] else None  # "the heavy thing" is not any
            except Ambiguous as several:
                which.append(several.message)
                return None
            except PlanError:
                continue
        if chinese or not candidates:
            return None
        *before, noun = candidates[0].split()
        if noun not in _STUFF and number(noun) is not None:
            return None
        noun = "thing" if noun in _STUFF else noun
        for colour in before:  # "the shiny red cup": what is known of it, and its colour
            try:
                return self._object(f"{colour} {noun}")
            except PlanError:
                continue
        return None


def _is_plural(words: str, thing: str) -> bool:
    """Whether English words mean several, none of which is singled out by a number or as "some": ``thing`` is what they
    were read as, in the singular."""
    one, *_, last = thing.split()[-1], *words.split()
    plural = last in (f"{one}s", f"{one}es", f"{one.removesuffix('y')}ies")
    return plural and _SOME.match(words) is None


def _with_question(entity: Entity, which: list[str]) -> Entity:
    if not which or entity.place or entity.surface or entity.thing:
        return entity
    return Entity(entity.words, person=entity.person, every=entity.every, which=which[0], at=entity.at)


def _parted(plain: str) -> tuple[str, str]:
    """A phrase, and where that is said to be: "the cup on the table"."""
    inner = _OUTER.sub("", plain)
    found = _RELATION.search(inner)
    return (inner[: found.start()], inner[found.end() :]) if found is not None else (inner, "")


def _bare(phrase: str) -> str:
    return _DETERMINERS.sub("", _BEHIND.sub("", phrase))


def _english(phrase: str) -> Iterator[str]:
    """The phrase, and its ends that may be a name by themselves, longest first."""
    plain = _DETERMINERS.sub("", _BEHIND.sub("", _OUTER.sub("", phrase)))
    if " of " in plain:
        yield plain
        yield " ".join(reversed(plain.split(" of ", 1)))  # "the table of coffee"
        plain = plain.partition(" of ")[0]
    if (use := _FOR_USE.search(plain)) is not None:
        yield f"{use[2]} {use[1]}"
    words = plain.split()
    for start in range(len(words)):
        yield " ".join(words[start:])


_ONE_TOO_MANY: Final = re.compile(r"[a-z]{3}s$")
_FOR_USE: Final = re.compile(r"(\w+) for (\w+ing)$")
""" "The table for dining"."""


def _chinese(phrase: str) -> Iterator[str]:
    plain = _ZH_INNER.sub("的", phrase)
    while (shorter := _ZH_FRONT.sub("", plain)) != plain:
        plain = shorter
    yield plain
    bare = _ZH_BACK.sub("", plain)
    if bare:
        yield bare
    for text in (plain, bare):
        _, de, last = text.rpartition("的")
        if de and last:
            yield last
            yield _ZH_BACK.sub("", last) or last
    for start in range(1, max(1, len(bare) - 1)):
        yield bare[start:]
    if (vessel := _VESSEL.match(phrase)) is not None:  # "that bottle of water" is a bottle
        yield vessel[1]
