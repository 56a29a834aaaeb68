"""What a Chinese request leaves open: a thing that only points, a place that is none, or no aim at all."""

from __future__ import annotations

import re
from typing import Final

from engine.planner.phrases.said import Question

_POLITE: Final = re.compile(
    r"^(?:请|麻烦|劳驾|拜托|能不能|能否|可以|可不可以|你能|你可以|你|帮我|帮忙|替我|给我|现在|那就|那|就|再|先|快|赶紧|快点|，)+(?=.)"
)
_CLOSING: Final = re.compile(r"(?:吧|呢|啊|呀|哦|嘛|吗|好吗|行吗|可以吗|好不好|谢谢|一下|[，,])+$")
_SOME: Final = (
    r"(?:它们?|那个|这个|那些|这些|那|这|另一个|另外一个|另外那个|别的|其他的?|其中一个|同一个|一样的|剩下的|某个)"
    r"(?:大|小|新|旧|好)?的?(?:东西|玩意儿?|物品|家伙|一?个)?"
)
_UNNAMED: Final = re.compile(
    rf"(?:把|将)?{_SOME}(?:给(?:我|他|她|他们|妈妈|爸爸))?(?:拿|取|带|送|搬|放|递|扔|丢|收|移|挪|捡|还|弄|处理|搞定|解决).*"
    rf"|(?:拿|取|带|送|搬|放|递|扔|丢|收拾?|移|挪|捡|找|抓|跟着?|弄|处理|搞定|解决|看看?)(?:一下|给我|给他|给她|过来|来|起|走)?{_SOME}"
    r"(?:给(?:我|他|她|他们|妈妈|爸爸).*|过来|来|起来|走|拿走|去.*)?"
    r"|(?:给|为)(?:他|她|他们|她们|妈妈|爸爸|奶奶|爷爷|客人|大家)?(?:拿|取|带|送|递|搬)(?:过去|去|过来|来|一下|一个|个|点)?"
)
_NOWHERE: Final = re.compile(
    r"(?:去|到|往|开到|走到|来到|在|上)(?:那边|那里|那儿|那头|隔壁|别处|别的地方|别的房间|某个地方|另一个房间|另外一个房间|"
    r"那个房间|那个地方|老地方|对面|旁边|外边|里面)(?:去|等.*|待.*|看.*|转.*|站.*|停.*)?"
)
_HALF: Final = re.compile(
    r"(?:把|将).+(?:放到|放在|拿到|送到|带到|搬到|放进|扔进|移到)$|(?:去|到|往)$|.+(?:然后|再|和|跟|或者|还有|的)$"
)
_SIDELESS: Final = re.compile(r"(?:转|旋转|转动|转个?)[\d一二三四五六七八九十百两半]+(?:度|个?直角)")
_AIMLESS: Final = re.compile(
    r"(?:还是)?(?:老样子|老规矩|照旧|照常|照老样子|和?跟?(?:上次|昨天|之前|以前|往常|平时)一样|像(?:上次|昨天|之前|以前|往常|平时)(?:一样|那样)?)"
    r"|(?:再|又)?(?:来|做|弄|试|重复|走|搞)(?:一次|一遍|一回|一下|一个)|重复|再来|同样的?|一样的?|还要|继续"
    r"|(?:处理|解决|搞定|弄好?|修|对付|想办法|看着办|安排|负责|管|收拾)(?:一下|好|掉)?(?:它|那个|这个|那些|这些|那件事|这件事|那事|这事)?"
    r"|(?:把)?(?:它|那个|这个|那些|这些|那件事|这件事)(?:处理|解决|搞定|弄好|弄|修|做|办|安排)(?:一下|好|掉|了)*"
    r"|你(?:懂|知道|明白)(?:的|我的意思|该做什么|怎么做)?|你看着办"
)


def gap_zh(text: str, names_thing: bool, *, alone: bool) -> Question | None:
    """What ``text`` leaves open; None where it is nothing. ``alone``: it goes on about nothing."""
    plain = text.replace(" ", "")
    bare = _CLOSING.sub("", _POLITE.sub("", plain)) or plain
    if _SIDELESS.fullmatch(bare):
        return "which_way"
    if not alone:
        return None
    if any(_AIMLESS.fullmatch(words) for words in (plain, bare, _CLOSING.sub("", plain))):
        return "what_do"
    if not names_thing and any(_UNNAMED.fullmatch(words) for words in (bare, _CLOSING.sub("", plain))):
        return "which_thing"
    if _NOWHERE.fullmatch(bare):
        return "where"
    if _HALF.fullmatch(bare):
        return "where_put" if names_thing else "where"
    return None
