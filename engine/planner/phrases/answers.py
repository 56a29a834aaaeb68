"""Telling people what a plan does: one sentence for each step, and one short answer for all of it.

The words come from the language records of the skills and from the phrase file, the facts from the actions themselves,
so that what is announced is what is done.
What skills know by its English name is told by the one it has in the language of the answer, where there is one.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any, Final

from config.schema import Place, Telling
from engine.han import is_chinese
from engine.perception.someone import someone
from engine.plan import ActionCall, Argument, Quantity
from engine.planner.text.words import digits
from engine.skills.places import ZERO_SYMBOL, Places
from engine.skills.registry import Parameter, Skill
from engine.skills.vocabulary import ME, Vocabulary

GO: Final = "navigation"
"""The skill that nobody has without a place to go to."""
MAX_TOLD = 4
"""More things than these are not listened to in one answer."""


class Answers:
    """The answers of one language."""

    def __init__(
        self,
        sections: Mapping[str, Any],
        places: Mapping[str, Place],
        vocabulary: Vocabulary,
        skills: Mapping[str, Skill],
        robot: Places,
    ) -> None:
        """``robot`` has the places of the running robot, which knows where it started."""
        self._skills = skills
        self._words: Mapping[str, Any] = sections["answers"]
        self._chinese = sections["language"] == "zh"
        self._vocabulary = vocabulary
        self._robot = robot
        self._places = {symbol: self._name((place.name, *place.aliases)) for symbol, place in places.items()}
        name = next(iter(self._places.values()), "")
        self.understood: str = self._words["understood" if name else "understood_anywhere"].format(place=name)
        """A sentence with examples of what can be said."""
        self.abilities: str = self._can(name)
        """A sentence that tells what these skills can do."""
        self._example_place = name

    @property
    def places(self) -> tuple[str, ...]:
        """Names of the places on the map."""
        return tuple(self._places.values())

    def _can(self, place: str) -> str:
        words: Mapping[str, str] = self._words["abilities"]
        told = [words[name].format(place=place) for name in words if name in self._skills and (place or name != GO)]
        listed = self._words["comma"].join(told[:-1])
        return words["told"].format(abilities=words["last"].join(filter(None, (listed, *told[-1:]))))

    def phrase(self, key: str) -> str:
        """A fixed sentence."""
        return str(self._words[key])

    def question(self, key: str) -> str:
        """The question for what is missing in a command."""
        return str(self._words["questions"][key]).format(place=self._example_place)

    def steps(self, calls: Iterable[ActionCall]) -> tuple[str, ...]:
        """One sentence for each action."""
        full_stop = self._words["sentence"].format(told="")
        return tuple(
            self._words["together_step"].format(step=self._tell(call, 0).removesuffix(full_stop))
            if call.alongside
            else self._tell(call, 0)
            for call in calls
        )

    def response(self, calls: Sequence[ActionCall]) -> str:
        """What the robot is about to do, in one sentence; empty where the actions speak for themselves."""
        told = [(call, text) for call in calls if (text := self._tell(call, 1))]
        parts: list[tuple[str, str]] = []  # what joins it to the one before, and the part
        for text, group in groupby(told, key=lambda one: one[1]):
            same = list(group)
            times = self._words["times"].format(count=len(same)) if len(same) > 1 else ""
            parts.append((self._words["together" if same[0][0].alongside else "then"], text + times))
        more = ""
        if len(parts) > MAX_TOLD:
            more = self._words["more"].format(count=len(parts) - MAX_TOLD + 1)
            parts = parts[: MAX_TOLD - 1]
        sentence = "".join(joint + part for joint, part in parts)[len(parts[0][0]) :] + more if parts else ""
        return str(self._words["sentence"]).format(told=f"{sentence[0].upper()}{sentence[1:]}") if sentence else ""

    def _tell(self, call: ActionCall, form: int) -> str:
        """An action in a sentence of its own (form 0), or as what is being done (form 1)."""
        skill = self._skills[call.name]
        names = [parameter.name for parameter in skill.parameters]
        given = {**dict(zip(names, call.positional, strict=False)), **call.named}
        words = skill.words.zh if self._chinese else skill.words.en
        telling = next((one for one in words.told if _fits(one, skill, given)), None)
        if telling is None:  # nobody has found words for it
            return (words.called or skill.summary, "")[form]
        full_stop = self._words["sentence"].format(told="")
        doing = telling.step.removesuffix(full_stop) if telling.doing is None else telling.doing
        told = {parameter.name: self._argument(parameter, given.get(parameter.name)) for parameter in skill.parameters}
        unusual = {p.name for p in skill.parameters if given.get(p.name, p.default) not in ("", p.default)}
        return _filled((telling.step, doing)[form], told, {*given} & unusual)

    def _argument(self, parameter: Parameter, value: Argument | None) -> str:
        match value:
            case Quantity(number):
                return self._amount(abs(number), parameter.unit) if parameter.unit else digits(number)
            case None | "":
                return str(self._words["things"]["room"]) if parameter.word == "room" else ""
        match parameter.word:
            case "place":
                return self._place(value)
            case "places":
                *others, last = [self._place(symbol) for symbol in value.split(",")]
                return str(self._words["and"].join([self._words["comma"].join(others), last] if others else [last]))
            case "object":
                return self._thing(value)
            case "surface":
                return self._surface(value)
            case "room":
                return self._called(value)
            case "person":
                return self._person(value)
            case "people" if self._chinese:
                return someone(value).in_chinese()
            case "colour" | "thing_colour":
                return self._word(value)
        return value

    def _person(self, who: str) -> str:
        """A name, or a description with its article."""
        if who == ME:
            return str(self._words["person"])
        described = someone(who)
        if self._chinese:
            return described.in_chinese()
        if described.is_anybody:
            return "somebody"
        return who if described.name else f"the {who}"

    def _thing(self, thing: str) -> str:
        """With its article; what has a number has a name."""
        words: Mapping[str, str] = self._words["things"]
        if thing[-1:].isdigit():
            return words["numbered"].format(thing=thing, number=thing.rpartition(" ")[2])
        translated = (self._word(word) for word in thing.split())
        return words["thing"].format(thing=("" if self._chinese else " ").join(translated))

    def _surface(self, name: str) -> str:
        """A piece of furniture with its article."""
        called = self._called(name)
        return called if called[-1:].isdigit() else str(self._words["things"]["thing"].format(thing=called))

    def _word(self, word: str) -> str:
        """A colour or a kind."""
        return str(self._words["words"].get(word, word))

    def _called(self, name: str) -> str:
        """What a piece of furniture or a room is called."""
        if not self._chinese or name in self._words["words"]:
            return self._word(name)
        return self._name(self._vocabulary.words_for(name))

    def _name(self, names: Sequence[str]) -> str:
        """The one of several names that is in the language of the answers; else the first."""
        return next((name for name in names if is_chinese(name)), names[0]) if self._chinese else names[0]

    def _amount(self, value: float, unit: str) -> str:
        if unit == "m" and value < 1 and (value * 100).is_integer():
            value, unit = value * 100, "cm"
        one, many = self._words["units"][unit]
        told = round(value, 2) or value  # nobody listens to a tenth of a millimetre
        return str(self._words["amount"]).format(number=digits(told), unit=one if value == 1 else many)

    def _place(self, symbol: str) -> str:
        if symbol not in self._places:  # in some worlds, where the speaker is
            remembered = self._vocabulary.resolvers()["place"](ZERO_SYMBOL) == ZERO_SYMBOL
            return str(self._words[("start" if self._robot.zero_is_start else "zero") if remembered else "person"])
        name = self._places[symbol]
        pattern = self._words["place_symbol" if len(name) == 1 and name.isascii() else "place"]
        return str(pattern.format(name=name.removeprefix("the ")))


def _fits(telling: Telling, skill: Skill, given: Mapping[str, Argument]) -> bool:
    """Whether an action is told so."""
    for parameter in skill.parameters:
        if (wanted := telling.when.get(parameter.name)) is None:
            continue
        value = given.get(parameter.name, "" if parameter.default is None else parameter.default)
        number = value.value if isinstance(value, Quantity) else value
        match wanted, number:
            case "negative", float():
                fits = number < 0
            case "positive", float():
                fits = number > 0
            case _, float():
                fits = digits(number) == wanted
            case _:
                fits = number == wanted
        if not fits:
            return False
    return True


def _filled(pattern: str, told: Mapping[str, str], given: Collection[str]) -> str:
    """The pattern with its slots filled, and its optional parts where all their slots were given."""

    def optional(found: re.Match[str]) -> str:
        return found[1] if all(slot in given for slot in _SLOT.findall(found[1])) else ""

    return _SLOT.sub(lambda slot: told[slot[1]], _OPTIONAL.sub(optional, pattern))


_OPTIONAL: Final = re.compile(r"\[([^\[\]]*)\]")
_SLOT: Final = re.compile(r"\{(\w+)\}")
