"""Words for people: whom ``William``, "the person waving" or 穿红衣服的人 means, and whether somebody is it."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Final, Literal, get_args

from engine.errors import PlanError
from engine.han import SIMPLER, is_chinese
from engine.perception.naming import CHINESE
from engine.perception.sighting import Colour
from engine.robot.company import Gesture, Posture

Gender = Literal["female", "male"]


class UnknownPerson(PlanError):
    """Words that name nobody who can be looked for."""

    code = "unknown_person"


@dataclass(frozen=True, slots=True)
class Someone:
    """Who is asked for; what is empty or None is left open."""

    name: str = ""
    gender: Gender | None = None
    posture: Posture | None = None
    gesture: Gesture | None = None
    shirt: Colour | None = None
    trousers: Colour | None = None

    @property
    def is_anybody(self) -> bool:
        """Whether everybody is it."""
        return self == Someone()

    def fits(
        self,
        *,
        name: str | None,
        gender: Gender | None,
        posture: Posture | None,
        gesture: Gesture | None,
        shirt: Colour | None,
        trousers: Colour | None,
    ) -> bool:
        """Whether somebody of whom this is known is it. What does not show, is not what is asked for; but a gender that
        nobody knows may be any."""
        wanted_and_seen = (
            (self.name or None, name),
            (self.posture, posture),
            (self.gesture, gesture),
            (self.shirt, shirt),
            (self.trousers, trousers),
        )
        alike = all(wanted in (None, seen) for wanted, seen in wanted_and_seen)
        return alike and (self.gender is None or gender in (None, self.gender))

    def __str__(self) -> str:
        """In words that :func:`someone` reads: ``William``, ``woman sitting in red``."""
        who = self.name or {None: "person", "female": "woman", "male": "man"}[self.gender]
        posture = {"lying": "lying down"}.get(self.posture or "", self.posture)
        dressed = f"in {self.shirt}" if self.shirt else ""
        legs = f"with {self.trousers} trousers" if self.trousers else ""
        return " ".join(filter(None, (who, posture, self.gesture, dressed, legs)))

    def in_chinese(self) -> str:
        """The same in Chinese: ``William``, 坐着的穿红衣服的女士."""
        posture = {None: "", "sitting": "坐着的", "standing": "站着的", "lying": "躺着的"}[self.posture]
        gesture = _GESTURES_ZH[self.gesture] if self.gesture else ""
        shirt = f"穿{_COLOURS_ZH[self.shirt]}衣服的" if self.shirt else ""
        legs = f"穿{_COLOURS_ZH[self.trousers]}裤子的" if self.trousers else ""
        who = self.name or {None: "人", "female": "女士", "male": "男士"}[self.gender]
        return f"{posture}{gesture}{shirt}{legs}{who}"


_GESTURES_ZH: Final[dict[Gesture, str]] = {
    "waving": "挥手的", "raising the left arm": "举左手的", "raising the right arm": "举右手的",
    "pointing to the left": "指着左边的", "pointing to the right": "指着右边的",
}  # fmt: skip
_COLOURS_ZH: Final = {colour: word for word, colour in reversed(CHINESE.items()) if colour in get_args(Colour)}
_COLOURS: Final = "|".join((*get_args(Colour), "gray"))
_SIDE: Final = r"(?P<side>left|right)"
_TOP: Final = r"(?:shirt|top|t-?shirt|jumper|jacket|sweater|blouse|coat|dress|hoodie|pullover|vest)"
_LEGS: Final = r"(?:trousers|pants|jeans|skirt|shorts|leggings)"
_ENGLISH: Final = tuple(
    (re.compile(rf"\b(?:{pattern})\b"), name)
    for pattern, name in (
        (
            rf"(?:(?:wearing|in|with|has|dressed in) )?(?:an? |the )?(?P<colour>{_COLOURS})(?: coloured)? {_LEGS}",
            "legs",
        ),
        (
            rf"(?:wearing|in|with|has|dressed in) (?:an? |the )?(?P<colour>{_COLOURS})(?: {_TOP})?|"
            rf"(?:an? |the )?(?P<top>{_COLOURS}) {_TOP}",
            "shirt",
        ),
        (
            rf"(?:who is |that is |is )?point\w*(?: (?:to|towards|at))?(?: (?:the|their|his|her))? {_SIDE}",
            "pointing to the",
        ),
        (
            rf"(?:rais|lift|hold|putt)\w*(?: up)?(?: (?:the|a|their|his|her))? {_SIDE} (?:arm|hand)(?: up| raised)?|"
            rf"with (?:the|a|their|his|her) (?P<hand>left|right) (?:arm|hand) (?:up|raised)",
            "raising",
        ),
        (
            r"(?:who is |that is |is )?wav(?:ing|es?)(?: (?:their|his|her|a|at (?:me|you|us)))?(?: (?:arms?|hands?))?",
            "waving",
        ),
        (r"(?:who is |that is |is )?(?:sitting|seated|sits|sat)(?: down)?", "sitting"),
        (r"(?:who is |that is |is )?(?:standing|stands|stood)(?: up)?", "standing"),
        (r"(?:who is |that is |is )?(?:lying|laying|lies)(?: down)?", "lying"),
    )
)
_COLOUR_ZH: Final = "[红橙橘黄绿蓝紫白灰黑]"
_CHINESE: Final = tuple(
    (re.compile(pattern), name)
    for pattern, name in (
        (rf"穿着?(?P<colour>{_COLOUR_ZH})色?的?(?:裤子|裙子|牛仔裤|短裤)的?", "legs"),
        (rf"穿着?(?P<colour>{_COLOUR_ZH})色?的?(?:衣服|上衣|衬衫|外套|毛衣|T恤|t恤|夹克|衣裳)?的?", "shirt"),
        (r"(?:手?指[着向]?|向)(?P<side>左|右)[边侧面]?(?:指着?)?的?", "pointing to the"),
        (r"(?:举|抬)起?着?(?P<side>左|右)(?:手|臂|胳膊|手臂)的?", "raising"),
        (r"(?:正在|在)?(?:挥|招)着?手的?", "waving"),
        (r"(?:正在|在)?坐[着下]的?", "sitting"),
        (r"(?:正在|在)?站[着立]的?", "standing"),
        (r"(?:正在|在)?躺[着下]的?", "lying"),
    )
)
_KINDS: Final = re.compile(
    r"(?:(?P<male>man|men|boy|boys|gentleman|guy|guys|lad|male|males)|"
    r"(?P<female>woman|women|girl|girls|lady|ladies|female|females)|"
    r"person|persons|people|human|humans|someone|somebody|anyone|anybody|one|guest|guests|visitor|visitors|"
    r"individual|folks?|everyone|everybody|child|children|kid|kids|elder|elders|adult|adults|friend|who|whoever|body)"
)
_KINDS_ZH: Final = re.compile(
    "(?P<male>男[人士的孩生]|先生|男性)|(?P<female>女[人士的孩生]|女性|小姐)|人|客人|孩子|小孩|访客|朋友|谁|大家"
)
_FILLERS: Final = re.compile(
    r"\b(?:the|a|an|any|some|that|this|those|these|em|all|every|each|other|who|which|is|are|'s|'re|there|of|and|"
    r"only|to|with|on|in|at|my|our|please|mr|mrs|ms|miss|dr|male|female|specific)\b|[.,!?;:]"
)
_FILLERS_ZH: Final = re.compile("[这那每各]一?[个位名]|一[个位名]|[个位名每]|全部|全体|有|在|正|的|所有|所|和|，|。|？")
_NAME: Final = re.compile(r"[^\W\d_][^\W\d_'’.-]*(?: [^\W\d_][^\W\d_'’.-]*){0,2}")


_KIN: Final = re.compile(
    r"^(?:(?:my|our|your|his|her|their|the) )?(?:(?:little|big|old|younger|older|best|dear|good) )?"
    r"(?:grandson|granddaughter|sister|brother|husband|wife|son|daughter|friend|colleague|neighbou?r|boss|cousin|nephew|niece|flatmate|"
    r"roommate|girlfriend|boyfriend|partner|guest|visitor|mother|father|student|assistant|manager)"
    r",? (?=[^\W\d_][\w'’.-]*(?: [^\W\d_][\w'’.-]*)?$)(?!(?:in|on|at|by|with|who|that|is|near|sitting|standing|lying|"
    r"waving|wearing|pointing|raising|over|from|under|next|beside|there|here|and|or)\b)",
    re.IGNORECASE,
)
"""What a person is to others, before their name."""


def is_named_after_kin(words: str) -> bool:
    """Whether a name follows what a person is to others: "my sister Emma"."""
    return _KIN.match(words) is not None


def someone(words: str) -> Someone:
    """Whom these words mean, in English or Chinese; what is nothing else is a name. Raises :class:`UnknownPerson`."""
    chinese = is_chinese(words)
    rest = _KIN.sub("", " ".join(words.translate(SIMPLER).split()))
    found = Someone()
    for pattern, what in _CHINESE if chinese else _ENGLISH:
        match = pattern.search(rest.casefold() if len(rest.casefold()) == len(rest) else rest)
        if match is not None:
            found = _with(found, what, match)
            rest = f"{rest[: match.start()]} {rest[match.end() :]}"
    if chinese:
        kind = _KINDS_ZH.search(rest)
        rest = _FILLERS_ZH.sub("", _KINDS_ZH.sub("", rest)).replace(" ", "")
    else:
        kinds = [one for word in re.findall(r"[a-z]+", rest.casefold()) if (one := _KINDS.fullmatch(word))]
        kind = next((one for one in kinds if one["male"] or one["female"]), kinds[0] if kinds else None)
        without = re.sub(rf"\b(?:{_KINDS.pattern})\b", " ", rest, flags=re.I)
        rest = " ".join(re.sub(_FILLERS.pattern, " ", without, flags=re.I).split())
    if kind is not None:
        found = replace(found, gender="male" if kind["male"] else "female" if kind["female"] else None)
    if re.search(r"\bmale\b", words, re.I):
        found = replace(found, gender="male")
    elif re.search(r"\bfemale\b", words, re.I):
        found = replace(found, gender="female")
    if not rest:
        return found
    if not _NAME.fullmatch(rest) or (kind is not None and not chinese):
        raise UnknownPerson(f"I don't know how to tell who {words!r} is.", hint="A name, clothes, a pose or a gesture.")
    return replace(found, name=rest.title() if rest.islower() and not chinese else rest)


def _with(found: Someone, what: str, match: re.Match[str]) -> Someone:
    groups = match.groupdict()
    colour = groups.get("colour") or groups.get("top")
    side = groups.get("side") or groups.get("hand")
    left = side in ("left", "左")
    match what:
        case "legs":
            return replace(found, trousers=_colour(colour))
        case "shirt":
            return replace(found, shirt=_colour(colour))
        case "pointing to the":
            return replace(found, gesture="pointing to the left" if left else "pointing to the right")
        case "raising":
            return replace(found, gesture="raising the left arm" if left else "raising the right arm")
        case "waving":
            return replace(found, gesture="waving")
    return replace(found, posture=what)  # type: ignore[arg-type]


def _colour(word: str | None) -> Colour | None:
    name = CHINESE.get(word or "", word or "")
    return next((colour for colour in get_args(Colour) if colour == {"gray": "grey"}.get(name, name)), None)
