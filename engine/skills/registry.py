"""Skills: typed functions that a plan may call, and nothing else may be called by a plan.

``@skill`` reads the function once: its name, the docstring (planners read it too), the parameters with their units
and limits from ``Annotated`` types, and the capabilities that it occupies while it runs. A :class:`SkillRegistry`
holds the skills that the connected robot can do, and turns an action as written into an action with typed
arguments, or says why not. This is the only door between text and motion.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Coroutine, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Final, Literal, NamedTuple, get_args, get_origin, get_type_hints

from config.nearest import did_you_mean, nearest
from config.schema import SkillRecord
from engine.errors import ExitCode, PlanError
from engine.events import Value
from engine.plan import Action, ActionCall, Argument, Quantity
from engine.robot.robot import Capability
from engine.skills.context import SkillContext
from engine.skills.outcome import Result
from engine.skills.record import record_of
from engine.skills.units import Unit, convert


class Measure(NamedTuple):
    """Annotation of a number: its unit and the range that is allowed."""

    unit: Unit
    low: float
    high: float


class Word(NamedTuple):
    """Annotation of a text: what kind of word it is. All but sentences are checked against a vocabulary, which also
    says what skills get.

    place: a symbol of the map, or zero. colour: of the light. thing_colour: of things that can be seen. object: a loose
    thing, as ``str`` of :class:`~engine.perception.naming.Wanted` (``red box``, ``block 3``). surface: the name of a
    piece of furniture, ``bin``, ``floor``, or where that makes sense a room or another place by name. room: its name.
    person: somebody, as ``str`` of :class:`~engine.perception.someone.Someone` (``William``, ``person waving``).
    people: the same, for each of several.
    """

    kind: Literal["place", "colour", "thing_colour", "object", "surface", "room", "person", "people", "sentence"]


Distance = Annotated[float, Measure("m", -50, 50)]
Angle = Annotated[float, Measure("deg", 0, 3600)]
Speed = Annotated[float, Measure("m/s", 0.02, 1.0)]
TurnSpeed = Annotated[float, Measure("rad/s", 0.05, 5.0)]
Duration = Annotated[float, Measure("s", 0, 600)]

Change = Literal["pose", "arm", "light", "things"]
"""What a skill may leave changed, and what can be put back. An arm that is only used to look or to grasp changes
nothing that anybody asked for."""

NOT_SAID = "not said"
"""Stands for an argument that nobody has told."""

Run = Callable[..., Coroutine[Any, Any, Result]]
Resolve = Callable[[str], str]
"""Turns a word as said into the word that skills use; raises PlanError when it is not known."""


class OutOfRange(PlanError):
    """A number of a plan is beyond what is allowed: refused."""

    code = "out_of_range"
    exit_code = ExitCode.REFUSED


class UnknownSkill(PlanError):
    """A plan names a skill that does not exist or that this robot cannot do."""

    code = "unknown_skill"


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of a skill. ``default`` is None where an argument is required."""

    name: str
    type: Literal["number", "text"]
    unit: Unit
    low: float | None
    high: float | None
    word: str | None
    default: Value | None

    def describe(self) -> dict[str, Value | None]:
        return {
            "name": self.name,
            "type": self.type,
            "unit": self.unit or None,
            "min": self.low,
            "max": self.high,
            "kind": self.word,
            "default": self.default,
            "required": self.default is None,
        }


@dataclass(frozen=True, slots=True)
class Skill:
    """A registered skill."""

    name: str
    doc: str
    parameters: tuple[Parameter, ...]
    occupies: frozenset[Capability]
    run: Run
    endless: bool = False
    """It goes on until told otherwise: no time limit ends it."""
    lasting: bool = False
    """It may take many minutes: it is not begun with a low battery."""
    own_words: SkillRecord | None = None
    """Of an external skill."""
    flat: bool = False
    """It sees, and can do without depth: what it looks for lies on the floor, or has a known size."""
    changes: frozenset[Change] | None = None
    """What it may leave changed, where all of that can be put back; None: something cannot."""

    @property
    def words(self) -> SkillRecord:
        """What it is called, and how it is told and asked for, in each language."""
        return self.own_words if self.own_words is not None else record_of(self.name)

    @property
    def summary(self) -> str:
        """First sentence of the docstring."""
        paragraph = " ".join(self.doc.partition("\n\n")[0].split())
        sentence, stop, _ = paragraph.partition(". ")
        return sentence + stop.strip()

    @property
    def signature(self) -> str:
        """As a planner writes it: ``move_left(angle deg, angular_speed rad/s = 1)``."""
        parts = []
        for p in self.parameters:
            default = "" if p.default is None else f" = {p.default:g}" if p.type == "number" else f" = {p.default!r}"
            parts.append(f"{p.name}{' ' + p.unit if p.unit else ''}{default}")
        return f"{self.name}({', '.join(parts)})"

    def describe(self) -> dict[str, Any]:
        """JSON-ready description."""
        return {
            "name": self.name,
            "signature": self.signature,
            "doc": self.doc,
            "parameters": [parameter.describe() for parameter in self.parameters],
            "occupies": sorted(self.occupies),
        }


def skill(
    *,
    occupies: Iterable[Capability] = (),
    changes: Iterable[Change] | None = None,
    endless: bool = False,
    lasting: bool = False,
    flat: bool = False,
) -> Callable[[Run], Skill]:
    """Make a coroutine function ``(context, …parameters) -> Result`` a skill that occupies these capabilities; an
    ``endless`` one goes on until told otherwise, a ``lasting`` one for many minutes, a ``flat`` one sees without
    depth. ``changes`` is what it may leave changed, where all of that can be put back."""

    def register(function: Run) -> Skill:
        hints = get_type_hints(function, include_extras=True)
        names = list(inspect.signature(function).parameters.values())
        if hints.get(names[0].name) is not SkillContext:
            raise TypeError(f"the first parameter of skill {function.__name__} is its SkillContext")
        doc = inspect.getdoc(function)
        if not doc:
            raise TypeError(f"skill {function.__name__} needs a docstring: planners read it")
        parameters = tuple(_parameter(p, hints[p.name]) for p in names[1:])
        leaves = None if changes is None else frozenset(changes)
        return Skill(
            function.__name__,
            doc,
            parameters,
            frozenset(occupies),
            function,
            endless,
            lasting,
            flat=flat,
            changes=leaves,
        )

    return register


def _parameter(parameter: inspect.Parameter, hint: Any) -> Parameter:
    if get_origin(hint) is not Annotated:
        raise TypeError(f"parameter {parameter.name} needs a unit or a kind of word: Annotated[…]")
    base, note = get_args(hint)
    default = None if parameter.default is inspect.Parameter.empty else parameter.default
    match note:
        case Measure(unit, low, high) if base is float:
            return Parameter(parameter.name, "number", unit, low, high, None, default)
        case Word(word) if base is str:
            return Parameter(parameter.name, "text", "", None, None, word, default)
    raise TypeError(f"parameter {parameter.name}: {hint} is neither a Measure of float nor a Word of str")


class SkillRegistry:
    """The skills on offer: those for which the robot has what they occupy, and whose camera measures ``depth`` where
    they need that. ``vocabulary`` resolves words of a kind (``place``) that must be known."""

    def __init__(
        self,
        skills: Iterable[Skill],
        *,
        capabilities: frozenset[Capability],
        depth: bool = True,
        vocabulary: Mapping[str, Resolve] | None = None,
    ) -> None:
        every = {skill.name: skill for skill in skills}
        self._skills = {
            name: skill
            for name, skill in every.items()
            if skill.occupies <= capabilities and (depth or skill.flat or "camera" not in skill.occupies)
        }
        self._impossible = every.keys() - self._skills.keys()
        self._vocabulary = dict(vocabulary or {})

    def __iter__(self) -> Iterator[Skill]:
        return iter(self._skills.values())

    def __getitem__(self, name: str) -> Skill:
        return self._skills[name]

    def resolve(self, call: ActionCall, said: str = "") -> Action:
        """Check an action as written. Raises :class:`PlanError` (unknown skill, wrong arguments, out of range,
        unknown word) with a message that says what is allowed. ``said`` is the request: of several things that a word
        fits, any will do where "a fruit" was asked for."""
        skill = self._skills.get(call.name)
        if skill is None:
            raise UnknownSkill(self._unknown(call.name))
        given = self._assign(skill, call)
        args: dict[str, Value] = {}
        for parameter in skill.parameters:
            if parameter.name in given:
                args[parameter.name] = self._check(skill, parameter, given[parameter.name], said)
            elif parameter.default is not None:
                args[parameter.name] = parameter.default
            else:
                raise PlanError(f"{skill.signature}: {parameter.name} is missing.")
        return Action(skill.name, args, call.alongside)

    def _assign(self, skill: Skill, call: ActionCall) -> dict[str, Argument]:
        names = [parameter.name for parameter in skill.parameters]
        if len(call.positional) > len(names):
            raise PlanError(f"{skill.signature} takes {len(names)} arguments, {len(call.positional)} were given.")
        given = dict(zip(names, call.positional, strict=False))
        for name, argument in call.named.items():
            if name not in names:
                raise PlanError(f"{skill.signature} has no argument {name!r}.", hint=did_you_mean(name, names))
            if name in given:
                raise PlanError(f"{skill.signature}: {name} is given twice.")
            given[name] = argument
        return given

    def _check(self, skill: Skill, parameter: Parameter, argument: Argument, said: str) -> Value:
        label = f"{skill.name}: {parameter.name}"
        if parameter.type == "number":
            if not isinstance(argument, Quantity):
                raise PlanError(f"{label} is a number in {parameter.unit or 'no unit'}, not {argument!r}.")
            value = convert(argument, parameter.unit, label)
            assert parameter.low is not None
            assert parameter.high is not None
            if not parameter.low <= value <= parameter.high:
                unit = f" {parameter.unit}" if parameter.unit else ""
                raise OutOfRange(
                    f"{label} of {value:g}{unit} is not allowed: {parameter.low:g} to {parameter.high:g}{unit}."
                )
            return value
        word = f"{argument.value:g}{argument.unit}" if isinstance(argument, Quantity) else argument
        if word == parameter.default:
            return word
        resolve = self._vocabulary.get(parameter.word or "")
        if resolve is None:
            return word
        try:
            return resolve(word)
        except PlanError as error:
            if error.exit_code is not ExitCode.CLARIFY or not any_of(word, said):
                raise
            return resolve(f"a {word}")

    def _unknown(self, name: str) -> str:
        if name in self._impossible:
            return f"This robot has nothing to do {name} with."
        near = nearest(name, self._skills)
        return f"There is no skill {name!r}{f'; did you mean {near}?' if near else '.'}"


def is_said(name: str, said: str) -> bool:
    """Whether a name stands in what was said, as a word."""
    if not name.isascii():
        return name in said
    return re.search(rf"\b{re.escape(name)}\b", said, re.I) is not None


def any_of(word: str, said: str) -> bool:
    """Whether any one of what a word fits was asked for: "a fruit", "one of the cups", 一个苹果."""
    name = re.escape(word.replace("_", " "))
    return (
        re.search(rf"\b(?:an?|some|any|one of \w+) {name}(?:e?s)?\b|[一任][个只本张块瓶些何]?{name}", said, re.I)
        is not None
        or _WHICHEVER.search(said) is not None
    )


_WHICHEVER: Final = re.compile(
    r"\b(?:whichever|either one|any of (?:them|those|these)|doesn't matter which|"
    r"don't (?:care|mind) which)\b|哪个都[行可]|随便",
    re.IGNORECASE,
)
"""Any one of them will do."""
