"""What is asked about an argument that has no ground."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from engine.planner.grounding.colours import IN_CHINESE
from engine.planner.request import Language
from engine.skills.registry import Parameter, Skill


@dataclass(frozen=True, slots=True)
class Question:
    """A question in each language of the planner."""

    en: str
    zh: str

    def text(self, language: Language) -> str:
        return self.zh if language == "zh" else self.en


WHICH_THING: Final = Question("Which thing do you mean?", "你指的是哪个东西？")
WHERE_PUT: Final = Question("Where shall I put it?", "放到哪里？")
HOW_OFTEN: Final = Question("How many times?", "几次？")
_WHICH_COLOUR: Final = Question("Which colour?", "什么颜色？")
_WHERE: Final = Question("Where to?", "去哪里？")
_WHICH_ROOM: Final = Question("Which room?", "哪个房间？")
_HOW_FAR: Final = Question("How far?", "多远？")
_HOW_HIGH: Final = Question("How high?", "多高？")
_WHICH_ANGLE: Final = Question("By how many degrees?", "转多少度？")
_HOW_LONG: Final = Question("For how long?", "多长时间？")
_HOW_FAST: Final = Question("How fast?", "多快？")
_WHICH_NUMBER: Final = Question("Which number?", "几号？")

_OF_A_WORD: Final = {
    "place": _WHERE, "places": _WHERE, "surface": WHERE_PUT, "room": _WHICH_ROOM, "object": WHICH_THING,
    "colour": _WHICH_COLOUR, "thing_colour": _WHICH_COLOUR,
}  # fmt: skip
_OF_A_UNIT: Final = {
    "m": _HOW_FAR, "deg": _WHICH_ANGLE, "s": _HOW_LONG, "m/s": _HOW_FAST, "rad/s": _HOW_FAST,
}  # fmt: skip
_OF_A_CARRY: Final = {"object": WHICH_THING, "place": WHERE_PUT, "source": _WHERE}
_NOUNS_ZH: Final = {
    "box": "盒子", "ball": "球", "cup": "杯子", "bottle": "瓶子", "block": "积木", "thing": "东西", "person": "人",
}  # fmt: skip


def question_about(skill: Skill, parameter: Parameter, language: Language) -> str:
    """What to ask for an argument that nobody has told."""
    asked = _OF_A_CARRY[parameter.name] if skill.name == "carry" else about(parameter)
    return asked.text(language)


def about(parameter: Parameter) -> Question:
    """What is asked about a parameter of any skill."""
    if parameter.type == "number":
        return _HOW_HIGH if parameter.name == "height" else _OF_A_UNIT.get(parameter.unit, _WHICH_NUMBER)
    return _OF_A_WORD.get(parameter.word or "", WHICH_THING)


def which_one(noun: str, colours: Iterable[str]) -> Question:
    """Of several things of one kind, in their colours."""
    in_order = sorted(colours)
    *first, last = (f"the {colour} one" for colour in in_order)
    in_chinese = "还是".join(f"{IN_CHINESE.get(colour, colour)}色的" for colour in in_order)
    return Question(f"Which {noun}: {', '.join(first)} or {last}?", f"哪个{_NOUNS_ZH.get(noun, noun)}：{in_chinese}？")


def as_it_stands(text: str) -> Question:
    """A question in words of the house, which are in one language."""
    return Question(text, text)
