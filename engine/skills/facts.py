"""What the robot can say without looking: the time, the day, a joke, something about itself. Never made up."""

from __future__ import annotations

import datetime
import re
from typing import Final

from engine.han import is_chinese

_DAYS_ZH: Final = "一二三四五六日"
_JOKE: Final = "Why did the robot cross the room? It was told to, and nobody said stop."
_ABOUT: Final = "I am a robot that listens, thinks and acts on the machine before you, and nothing of it leaves this place."
_NAME: Final = "I am called sayso."
_TOMORROW: Final = re.compile(r"\btomorrow\b|明天")
_TOPICS: Final = (
    ("time", re.compile(r"\b(?:the |what )?time\b|\bo'?clock\b|几点|时间")),
    ("month", re.compile(r"\bday of the month\b|\bdate\b|几号|日期|几月")),
    ("day", re.compile(r"\bday of the week\b|\b(?:what|which) day\b|\bweekday\b|星期几|周几|礼拜几")),
    ("joke", re.compile(r"\bjoke|\bfunny|笑话")),
    ("name", re.compile(r"\byour (?:own )?name\b|\bwho (?:are )?you\b|你(?:的名字|叫什么|是谁)")),
    ("about", re.compile(r"\babout (?:you|your)(?:self|rself)?\b|介绍.*自己|你自己")),
)


def topic_of(words: str) -> str:
    """Which of these facts is asked for: time, month, day, joke, name, about; empty for none."""
    plain = words.casefold()
    return next((name for name, pattern in _TOPICS if pattern.search(plain)), "")


def fact(words: str, now: datetime.datetime | None = None) -> str:
    """The sentence that answers these words, in English or Chinese as they are; empty where none does."""
    topic, chinese = topic_of(words), is_chinese(words)
    now = now or datetime.datetime.now().astimezone()
    if _TOMORROW.search(words.casefold()):
        now += datetime.timedelta(days=1)
        when, when_zh = "Tomorrow is", "明天是"
    else:
        when, when_zh = "Today is", "今天是"
    match topic:
        case "time":
            return f"现在是{now.hour}点{now.minute:02d}分。" if chinese else f"It is {now.hour}:{now.minute:02d}."
        case "month":
            told = f"{when} the {_ordinal(now.day)} of {now:%B}."
            return f"{when_zh}{now.month}月{now.day}日。" if chinese else told
        case "day":
            return f"{when_zh}星期{_DAYS_ZH[now.weekday()]}。" if chinese else f"{when} {now:%A}."
        case "joke":
            return "机器人为什么穿过房间？因为有人叫它去，又没有人喊停。" if chinese else _JOKE
        case "name":
            return "我叫sayso。" if chinese else _NAME
        case "about":
            return "我是一个会听、会想、会做事的机器人，一切都在您面前的机器上进行。" if chinese else _ABOUT
    return ""


def _ordinal(day: int) -> str:
    ending = "th" if 10 <= day % 100 <= 20 else {1: "st", 2: "nd", 3: "rd"}.get(day % 10, "th")
    return f"{day}{ending}"
