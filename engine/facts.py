"""What the robot can say without looking: the time, the day, a joke, something about itself. Never made up."""

from __future__ import annotations

import datetime
import re
from typing import Final

from engine.han import is_chinese

_DAYS_ZH: Final = "一二三四五六日"
_JOKE: Final = "Why did the robot cross the room? It was told to, and nobody said stop."
_ABOUT: Final = "I am a robot that listens, thinks and acts, and nothing that I hear or see leaves this place."
_NAME: Final = "I am called sayso."
_TOMORROW: Final = re.compile(r"\btomorrow\b|明天")
_ASKING: Final = re.compile(
    r"^(?:(?:(?:please|so|and|can you|could you|would you|do you know|i want to know|tell(?: (?:me|us|them|him|her))?|"
    r"say|what(?:'s| is))\b|请问|请|告诉我|你知道)\s*)+"
)
_WHEN: Final = r"(?: (?:is )?(?:it|today|tomorrow)(?: is)?(?: today| tomorrow)?)"
_TOPICS: Final = (
    ("time", re.compile(r"(?:what )?(?:the )?(?:current )?time(?: is it| it is)?(?: right)?(?: now)?")),
    ("month", re.compile(rf"(?:the )?day of the month{_WHEN}?|(?:the |today's |tomorrow's )?date{_WHEN}?")),
    ("month", re.compile(rf"(?:what|which) date{_WHEN}")),
    ("day", re.compile(rf"(?:the )?day of the week{_WHEN}?|(?:what |which )?(?:week)?day(?: of the week)?{_WHEN}")),
    ("joke", re.compile(r"(?:me )?(?:an?|some|another)? ?(?:good |funny |short )?jokes?")),
    ("name", re.compile(r"your (?:own )?name|who (?:are you|you are)")),
    ("about", re.compile(r"(?:something |a bit |a little )?about (?:yourself|you)")),
    ("time", re.compile("(?:现在)?是?(?:几点(?:了|钟)?|什么时间|时间)")),
    ("month", re.compile("(?:今天|明天)?是?(?:几月|(?:这个?|本)月的?第?)?(?:几号|几日|几天|哪一?天|日期|什么日子)")),
    ("day", re.compile("(?:今天|明天)?是?(?:星期几|周几|礼拜几)")),
    ("joke", re.compile("讲?个?笑话")),
    ("name", re.compile("你(?:的名字|叫什么(?:名字)?|是谁)")),
    ("about", re.compile("介绍一?下?(?:你)?自己|(?:关于)?你自己")),
)


def topic_of(words: str) -> str:
    """Which of these facts is asked for: time, month, day, joke, name, about; empty for none."""
    plain = _ASKING.sub("", " ".join(words.casefold().replace("’", "'").split()).strip(" .,?!。？！"))
    return next((name for name, pattern in _TOPICS if pattern.fullmatch(plain)), "")


def is_of_the_clock(words: str) -> bool:
    """Whether the time or the day is asked for."""
    return topic_of(words) in ("time", "month", "day")


def fact(words: str, now: datetime.datetime | None = None) -> str:
    """The sentence that answers these words, in English or Chinese as they are; empty where none does."""
    topic, chinese = topic_of(words), is_chinese(words)
    now = now or datetime.datetime.now().astimezone()
    if _TOMORROW.search(words.casefold()):
        now += datetime.timedelta(days=1)
        when, when_zh = "tomorrow", "明天是"
    else:
        when, when_zh = "today", "今天是"
    match topic:
        case "time":
            return f"现在是{now.hour}点{now.minute:02d}分。" if chinese else f"It is {now.hour}:{now.minute:02d}."
        case "month":
            told = f"{now:%B} the {_ordinal(now.day)}"
            return f"{when_zh}{now.month}月{now.day}日。" if chinese else f"It is {told} {when}."
        case "day":
            return f"{when_zh}星期{_DAYS_ZH[now.weekday()]}。" if chinese else f"It is {now:%A} {when}."
        case "joke":
            return "机器人为什么穿过房间？因为有人叫它去，又没有人喊停。" if chinese else _JOKE
        case "name":
            return "我叫sayso。" if chinese else _NAME
        case "about":
            return "我是一个会听、会想、会做事的机器人，我听到和看到的都不会离开这里。" if chinese else _ABOUT
    return ""


def _ordinal(day: int) -> str:
    ending = "th" if 10 <= day % 100 <= 20 else {1: "st", 2: "nd", 3: "rd"}.get(day % 10, "th")
    return f"{day}{ending}"
