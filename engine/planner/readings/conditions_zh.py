"""Requests in Chinese that depend on what is there: 如果桌上有苹果，就拿到厨房，否则鸣笛.

Read as the English ones are, clause by clause: what is said to be there (``_presence``), what is said of it afterwards
("有的话", "不在就"), and what is to be done then as a request of its own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from engine.han import SIMPLER
from engine.planner.readings.presence import Presence
from engine.planner.request import Conditional

_IF: Final = r"(?:如果说?|要是|假如|假使|若是|倘若|若|当|只要|万一|一旦)"
_OPENER: Final = re.compile(
    rf"{_IF}|(?P<unless>除非)|(?:(?<=^)|(?<=，))(?:你)?一?(?=看到|看见|发现|找到|遇到|碰到)|(?:(?<=^)|(?<=，))"
    r"(?=[^，]{4,16}?的话)"
)
_BREAK: Final = re.compile(
    r"(?:的话|的时候|时)?(?:，(?:那么|那你就|那就|你就|就|那|则|请你?|便)?|(?:那么|那就|你就|就|则|便|请))|的话"
)
"""Where a condition may end and what is to be done begin."""
_LOOKS: Final = re.compile(
    r"(?:先)?(?:看看|看一看|看一下|看下|看|检查一下|检查|瞧瞧|瞧一下|确认一下|确认|确定一下|确定|查看一下|"
    r"查看)(?!到|见)"
)
_SEEKS: Final = re.compile(r"(?:先)?(?:找一下|找一找|找找|找)(?!到|不)")
_ELSE: Final = re.compile(r"，?(?:(?:否则|不然|要不然|要不)(?:的话)?(?:，|那就|就|请|则)*|没有(?:的话)?(?:，?就))")
_MUST: Final = re.compile(r"^，?(?:否则|不然|要不然)(?:的话)?(?:，|那就|就|请|则)*")
_ASKS: Final = (
    (re.compile(r"还?(?:有没有|是否有|是不是有|有无|是否还有)"), "有"),
    (re.compile(r"还?(?:在不在|是否在|是不是在|是否还在|是不是还在)"), "在"),
    (re.compile(r"(?:是否|是不是)"), "是"),
    (re.compile(r"(?:吗|么|呢)$"), ""),
)
"""A question, and how it begins as a statement."""

_SIDE: Final = r"(?:上面|里面|下面|旁边|上边|里边|底下|那里|那边|附近|上|里|内|下|中|边)"
_SPOT: Final = r"(?:(?![有没在看是的，吗就找]|发现)\w){1,8}?"
_PLACE: Final = rf"(?:在)?(?P<where>{_SPOT}){_SIDE}?"
_COUNT: Final = r"(?:(?:至少)?(?:有)?一?[个只瓶杯条本件些双块位](?!子)|一|任何|什么)?"
_THING: Final = rf"{_COUNT}(?P<thing>(?:(?![，就那则请否有没在吗来叫去是])\w){{1,10}}?)(?:了)?"
_COLOUR: Final = r"(?P<colour>[红橙黄绿蓝紫白灰黑])(?:色)?的?"
_EMPTY: Final = (
    r"(?:是)?(?:空的|空着的?|空|空无一物|空无一人|什么(?:东西)?[都也]没有|没有?(?:任何|什么)?东西|"
    r"一个人[都也]没有|谁[都也]不在)"
)
_SEES: Final = r"(?:能)?(?:看[到见]|见到|发现|找到|遇到|碰到)"
_CLAUSES: Final = tuple(
    (negated, re.compile(pattern))
    for negated, pattern in (
        (True, rf"{_PLACE}(?P<empty>{_EMPTY})"),
        (True, rf"(?:{_PLACE})?(?:没有|没看[到见]|看不[到见]|找不到|没找到|没发现|没见到|没){_THING}"),
        (True, rf"(?:没有|没看[到见]|没){_THING}在{_PLACE}"),
        (True, rf"{_THING}(?:不在|没在)(?:{_PLACE})?"),
        (True, rf"{_THING}不见了?"),
        (False, rf"{_SEES}(?:{_PLACE})有{_THING}"),
        (False, rf"(?:{_SEES})?(?:有)?{_THING}在{_PLACE}"),
        (False, rf"(?:{_PLACE})?(?:{_SEES}|有)(?:有)?{_THING}"),
        (True, rf"(?:{_PLACE}的)?{_THING}不是{_COLOUR}"),
        (False, rf"(?:{_PLACE}的)?{_THING}是{_COLOUR}"),
    )
)
_SOUGHT: Final = re.compile(rf"(?:{_PLACE}的)?{_THING}")
_FILLERS: Final = re.compile(r"还(?=[有在没是])|仍然|仍旧|依然|正好|刚好|恰好|碰巧|现在|目前|此时|已经|剩下?")
_OTHER_TIMES: Final = re.compile(r"昨|明天|后天|刚才|以前|之前|曾经|过|点钟|分钟|小时|早就|将来|以后|今晚")
_NOWHERE: Final = "你 我 他 她 它 您 咱 我们 你们 他们 这 那 谁 手 电 天 心 家里 外 天气 时间 电池"
_NO_PLACE: Final = frozenset(_NOWHERE.split())
_NOT_SEEN: Final = (
    "电 电量 电池 问题 时间 危险 需要 声音 办法 机会 空 困难 你 我 它 他 她 雨 雪 风 事 事情 兴趣 信号 网 网络 意思 "
    "钱 可能 必要 噪音 音乐 空间 位置 光 灯 麻烦 心情 消息 您 我们 你们 他们"
)
_UNSEEN: Final = frozenset(_NOT_SEEN.split())
_COUNTED: Final = re.compile(r"[两三四五六七八九十几多\d](?!号)|不止|很多|好多|超过|一个以上")
_ROOM: Final = re.compile(r"(?:厅|室|房|房间|走廊|过道|卫生间|厕所|办公室|车库)$")
_YES: Final = re.compile(
    rf"(?:它|他|她|那里|里面|上面)?(?:有(?:人|的|东西|一[个只瓶])?|在(?:那[里儿边])?|{_SEES}了?(?:它|他|的)?|能)"
)
_NO: Final = re.compile(
    r"(?:它|他|她|那里|里面|上面)?(?:没有?(?:人|东西)?|不在(?:那[里儿边])?|找不到|看不[到见]|没看[到见]|没找到|"
    r"没发现|不见了?|是?空的?)(?:它|他)?"
)

_PREPARES: Final = r"(?:请|麻烦你?|你|就|再|先|然后|接着|帮我|给我(?=[去到看找])|能不能|可以|，)*"
_DOES: Final = re.compile(
    rf"^{_PREPARES}(?:把|将|去|到|拿|带|送|放|捡|抓|取|搬|扔|丢|说|告诉|叫|鸣|蜂鸣|响|滴|转|左转|右转|向|往|"
    rf"前进|后退|回|停|等|跟|跳|点头|点|摇|"
    r"鼓掌|拍手|举|抬|打扫|打招呼|打|收拾|找|开|关|给|报告|嘀|哔|发出|拾|清理|移动|走|过来|亮|播|巡逻|记住|看|"
    r"继续|离开|充电|对|向|问好|闪|挥手|挥)"
)
_WITHOUT_OBJECT: Final = re.compile(
    r"^(?P<does>(?:拿|带|送|放|搬|扔|丢|捡|取|抓|拾)(?:到|给|去|进|起来?|回|过来|来|走|掉|在|住|出)\S*)$"
)
_ON_TOP: Final = re.compile(r"(?P<put>放)(?:到|在)?(?:上去|上面去?|那[里儿]|里面去?|进去)$")
_HANGS: Final = re.compile(r"如果|要是|假如|否则|不然|是否|的话|有没有|直到|除非|只要")
_TELLS: Final = re.compile(
    r"(?:告诉|通知|提醒|跟|对)(?:他们|她们|他|她|人|那个人|大家)(?:说)?(?P<what>(?!打招呼|问好|走|鼓掌).+)"
)
_GREETS: Final = re.compile(r"(?:跟|向|和|对|给)?(?:他们|她们|他|她|人|那个人)?(?:打个?招呼|问个?好|问候(?:他|她)?)")
_APPLAUDS: Final = re.compile(r"(?:给|为|向)(?:他们|她们|他|她|人|大家)(?P<does>鼓鼓?掌|拍拍?手|点头|挥手)")
_NOTHING: Final = re.compile(r"算了|什么(?:都|也)?(?:不做|不用做|别做)|(?:不用|别)管(?:它|了)?|不用了")
_TOLD: Final = re.compile(r"(?:告诉|通知)(?:我|我们)(?:一声|一下)?|说(?:一声)?|看看?|报告(?:一下)?")


def read(text: str) -> Conditional | None:
    """Take ``text`` apart; None where it is no condition on what can be seen, or is not understood in full."""
    plain = re.sub(r"[,;；。？?!！：:、]+", "，", text.replace(" ", "").translate(SIMPLER)).strip("，")
    for before, about, words in (*_looked(plain), *_asked(plain), *_leading(plain), *_trailing(plain)):
        if (found := _taken(before, about, words)) is not None:
            return found
    return None


def _presence(clause: str) -> Presence | None:
    """What a clause says is there; None for anything else."""
    if _OTHER_TIMES.search(clause) or _COUNTED.search(clause):
        return None
    plain = _FILLERS.sub("", re.sub(r"^(?:你|我们|，)+(?=看|发现|找|见|能|有|在)", "", clause)).removesuffix("的话")
    for negated, pattern in _CLAUSES:
        match = pattern.fullmatch(plain)
        if match is not None and (found := _read(match, negated)) is not None:
            return found
    return None


def _read(match: re.Match[str], negated: bool) -> Presence | None:
    parts = {name: words or "" for name, words in match.groupdict().items()}
    where, thing = parts.get("where", ""), parts.get("thing", "")
    if empty := parts.get("empty", ""):
        thing = "人" if "人" in empty or "谁" in empty or (_ROOM.search(where) and "东西" not in empty) else "东西"
    thing = re.sub(r"^(?:的|那|这)+[个只瓶杯条本件些双块]?", "", thing)
    if colour := parts.get("colour", ""):
        thing = f"{colour}色的{thing}"
    if not thing or thing in _UNSEEN or where in _NO_PLACE or "色的灯" in thing or (not where and thing == "门"):
        return None
    return Presence(thing, {"桌": "桌子", "床": "床"}.get(where, "" if where in ("地", "地板") else where), negated)


# How such requests are put

_Sentence = tuple[str, Presence, str]
"""What comes first, what is to be seen, and what is to be done (with what is to be done otherwise still in it)."""


def _parted(text: str) -> Iterator[tuple[str, str]]:
    for match in _BREAK.finditer(text):
        yield text[: match.start()], text[match.end() :]


def _stated(question: str) -> str:
    for pattern, words in _ASKS:
        question = pattern.sub(words, question, count=1)
    return question


def _looked(text: str) -> Iterator[_Sentence]:
    """看看桌子上有没有杯子，有的话…"""
    for looks in (_LOOKS, _SEEKS):
        for match in looks.finditer(text):
            before, rest = text[: match.start()], text[match.end() :]
            for end in (comma.start() for comma in re.finditer("，", rest)):
                clause = rest[:end]
                about = _presence(_stated(clause)) if looks is _LOOKS else None
                if about is None and looks is _SEEKS and (sought := _SOUGHT.fullmatch(clause)) is not None:
                    about = _read(sought, False)
                if about is not None:
                    yield from _answered(before, about, rest[end + 1 :])


def _asked(text: str) -> Iterator[_Sentence]:
    """桌子上有杯子吗，有的话…"""
    for match in re.finditer(r"(?:吗|么)，|(?<=[有在]没[有在])\w+，|(?<=在不在)\w+，", text):
        asked = text[: match.end() - 1]
        before, _, clause = asked.rpartition("，")
        if (about := _presence(_stated(clause))) is not None:
            yield from _answered(before, about, text[match.end() :])


def _answered(before: str, about: Presence, rest: str) -> Iterator[_Sentence]:
    for said, then in _parted(rest):
        there = _sign(said, about)
        if there is not None:
            yield before, replace(about, negated=not there), then


def _sign(said: str, about: Presence) -> bool | None:
    """Whether it is said that the thing is there (有的话) or is not (不在); None for neither."""
    said = re.sub(rf"^(?:{_IF})", "", said).removesuffix("的话")
    if said in ("是", "是的", "是这样", "对"):
        return not about.negated
    if said in ("不是", "不是的", "不是这样"):
        return about.negated
    if _YES.fullmatch(said):
        return True
    if _NO.fullmatch(said):
        return False
    again = _presence(said)
    return not again.negated if again is not None and again.thing == about.thing else None


def _leading(text: str) -> Iterator[_Sentence]:
    """如果桌上有苹果，就…; 沙发上要是有球，就…"""
    for match in _OPENER.finditer(text):
        before, _, subject = f"，{text[: match.start()]}".rpartition("，")
        subject = re.sub(r"^(?:然后|接着|再|就|请|你|并|，)+", "", subject)
        for clause, then in _parted(text[match.end() :]):
            about = _presence(subject + clause)
            if about is None:
                continue
            if match["unless"] is not None:
                about, then = replace(about, negated=not about.negated), _MUST.sub("", f"，{then}")
            yield before, about, then


def _trailing(text: str) -> Iterator[_Sentence]:
    """把杯子拿到厨房，如果它在桌子上的话"""
    for match in re.finditer(rf"，(?:但是?|不过)?(?:{_IF}|(?P<unless>除非))", text):
        then, clause = text[: match.start()], text[match.end() :]
        moved = re.match(r"(?:请|你)*把(?P<thing>\w+?)(?:拿|带|送|放|扔|搬|捡|丢)", then)
        about = _presence(re.sub("^它(?=[在不])", moved["thing"] if moved is not None else "它", clause))
        if about is not None:
            yield "", about if match["unless"] is None else replace(about, negated=not about.negated), then


# What the parts mean


def _taken(before: str, about: Presence, words: str) -> Conditional | None:
    going = re.sub(rf"(?:并|再|然后|，|{_LOOKS.pattern})+$", "", before.strip("，"))
    going = re.sub(r"^(?:请|先|你|麻烦你?|帮我|，)+", "", going)
    if (match := re.fullmatch(rf"(?:{_LOOKS.pattern})(?P<where>{_SPOT}){_SIDE}?", before.strip("，"))) is not None:
        going = f"去{match['where']}"
    if going in ("去", "过去", "回去"):
        going = ""
    if going and (not _DOES.match(going) or _HANGS.search(going)):
        return None
    for then, otherwise in _either(words, about):
        first, second = _request(then, about), _request(otherwise, replace(about, negated=not about.negated))
        if second is None and _TOLD.fullmatch(otherwise.strip("，")):
            second = ""  # what is there is told anyway
        if first and second is not None:
            return Conditional(going, about.thing, about.where, about.negated, first, second)
    return None


def _either(words: str, about: Presence) -> Iterator[tuple[str, str]]:
    """What is to be done, and what otherwise."""
    if (contrary := _ELSE.search(words)) is not None:
        yield words[: contrary.start()], words[contrary.end() :]
    for comma in re.finditer("，", words):
        for said, otherwise in _parted(words[comma.end() :]):
            if _sign(said, about) is about.negated:
                yield words[: comma.start()], otherwise
    yield words, ""


def _request(words: str, about: Presence) -> str | None:
    """The words as a request of their own; None where they are none."""
    words = re.sub(rf"^{_PREPARES}", "", words.strip("，")).removesuffix("吧").strip("，")
    if not words or _NOTHING.fullmatch(words):
        return ""
    if _HANGS.search(words) or not _DOES.match(words) or _TOLD.fullmatch(words):
        return None
    if _GREETS.fullmatch(words):
        return "说你好"
    if about.thing == "人" or not about.negated:
        if (match := _TELLS.fullmatch(words)) is not None and about.thing == "人":
            return f"说{match['what']}"
        if (match := _APPLAUDS.fullmatch(words)) is not None:
            return match["does"]
    if about.where:
        words = _ON_TOP.sub(lambda found: f"{found['put']}到{about.where}上", words)
    named = about.where if about.negated and about.where and about.thing in ("东西", "人") else about.thing
    if about.thing == "人":
        words = re.sub(r"他们|她们|他|她", about.thing, words, count=1)
    if re.fullmatch(r"去\w+找", words):
        return f"{words}{about.thing}"
    if "它" in words:
        return re.sub("它们?", named, words, count=1)
    if (match := _WITHOUT_OBJECT.match(words)) is not None and about.thing not in words and not about.negated:
        return f"把{about.thing}{match['does']}"
    return words
