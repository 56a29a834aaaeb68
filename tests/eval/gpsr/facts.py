"""Whether what was asked for has been told, and nothing else: numbers, names, what things are called, the day.

Sentences are the robot's own words for people; they are looked through for words, never understood.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime, timedelta
from typing import Final

from engine.perception.naming import CHINESE
from engine.robot.sim.scene import Scene
from tests.eval.gpsr.acts import has
from tests.eval.gpsr.goal import Fact
from tests.eval.gpsr.truths import Run

_NUMBERS: Final = (
    ("none", "zero", "nobody", "nothing", "零", "没有"), ("one",), ("two", "两", "二"), ("three", "三"), ("four", "四"),
    ("five", "五"), ("six", "六"), ("seven", "七"), ("eight", "八"), ("nine", "九"),
)  # fmt: skip
_ONE: Final = re.compile("一(?=个)")
"""A number where it is there once; more of them make a list."""
_DAYS: Final = (
    ("monday", "星期一", "周一"), ("tuesday", "星期二", "周二"), ("wednesday", "星期三", "周三"),
    ("thursday", "星期四", "周四"), ("friday", "星期五", "周五"), ("saturday", "星期六", "周六"),
    ("sunday", "星期日", "星期天", "周日"),
)  # fmt: skip
_TIME: Final = re.compile(r"(\d{1,2})\s*(?:[:：点])\s*(\d{1,2})?")
_LATE: Final = timedelta(minutes=20)
_SHORTEST: Final = 8  # characters of something that is told for its own sake


def untold(facts: Sequence[Fact], run: Run, now: datetime) -> tuple[str, ...]:
    """What was asked for and not told."""
    return tuple(fault for fact in facts if (fault := _missing(fact, run, now)))


def made_up(facts: Sequence[Fact], run: Run) -> tuple[str, ...]:
    """What was told and is wrong: another number, or wrong words instead of right ones. Who tells more of them than
    were asked for lists what is there, and claims nothing."""
    found: list[str] = []
    for fact in facts:
        answer = run.evidence.words
        wrong = _wrong(fact, answer, run.evidence.scene)
        right = [g for g in fact.groups if any(_tells(answer, word, run.evidence.scene) for word in g)]
        if len(right) + len(wrong) <= len(fact.groups):
            found += wrong
        said = numbers(answer)
        if fact.number is not None and said and fact.number not in said:
            found.append(f"{said[0]} instead of {fact.number}")
    return tuple(found)


def _wrong(fact: Fact, text: str, scene: Scene) -> list[str]:
    """Words of a text that are wrong."""
    rest = _without(text, [word for group in fact.groups for word in group])
    return [word for word in fact.wrong if _tells(rest, word, scene)]


def _without(text: str, words: Sequence[str]) -> str:
    """A text without these words, of which others may be parts: the orange juice is no orange."""
    rest = text.casefold()
    for word in sorted(words, key=len, reverse=True):
        rest = rest.replace(word.casefold(), "…")
    return rest


def _missing(fact: Fact, run: Run, now: datetime) -> str:
    everything = [*(spoken.text for spoken in run.spoken), run.evidence.words]
    texts = run.heard_by(fact.to) if fact.to else everything
    if not any(texts):
        return "nothing was told"
    text = " ".join(texts)
    said = [number for told in texts for number in numbers(told)]
    if fact.number is not None and fact.number not in said:
        return f"told {', '.join(map(str, dict.fromkeys(said))) or 'no number'}, not {fact.number}"
    lost = ["|".join(g) for g in fact.groups if not any(_tells(text, word, run.evidence.scene) for word in g)]
    if lost:
        return f"not told: {', '.join(lost)}"
    if wrong := _wrong(fact, run.evidence.words, run.evidence.scene):
        return f"told with what is wrong: {', '.join(wrong)}"
    if fact.of_the_day and not _is_of_the_day(fact, text, now):
        return f"the {fact.of_the_day} was not told"
    if not fact.of_the_day and not fact.groups and fact.number is None and max(map(len, texts)) < _SHORTEST:
        return "too little was told"
    return ""


def numbers(text: str) -> list[int]:
    """All whole numbers of a text, in digits or words."""
    plain = text.casefold()
    found = [int(digits) for digits in re.findall(r"(?<![\d.])\d+(?![\d.]*\d)", plain)]
    found += [n for n, words in enumerate(_NUMBERS) if any(has(plain, word) for word in words)]
    return found or [1] * (len(_ONE.findall(plain)) == 1)


def _tells(text: str, word: str, scene: Scene) -> bool:
    """Whether a text has a word, or of a thing its name or what it looks like."""
    loose = scene.objects.get(word)
    if loose is None:
        return has(text, word)
    chinese = {english: said for said, english in reversed(CHINESE.items())}
    in_chinese = chinese.get(loose.colour, "?") in text and any(
        said in text for said, english in CHINESE.items() if english == loose.kind
    )
    return has(text, word) or has(text, f"{loose.colour} {loose.kind}") or in_chinese


def _is_of_the_day(fact: Fact, text: str, now: datetime) -> bool:
    day = now + timedelta(days=fact.of_the_day == "tomorrow")
    if fact.of_the_day == "time":
        return any(_is_now(int(hour), int(minute or 0), now) for hour, minute in _TIME.findall(text))
    is_weekday = any(has(text, word) for word in _DAYS[day.weekday()])
    is_day = day.day in numbers(text) or re.search(rf"(?<!\d){day.day}(?:st|nd|rd|th|号|日)", text) is not None
    return is_weekday if fact.of_the_day == "weekday" else is_day if fact.of_the_day == "day" else is_weekday or is_day


def _is_now(hour: int, minute: int, now: datetime) -> bool:
    if hour > 23 or minute > 59:
        return False
    hours = {hour % 24, (hour + 12) % 24}
    return any(abs(now.replace(hour=one, minute=minute) - now) < _LATE for one in hours)
