"""Draws commands from the grammar, and keeps how each came about: rules, productions, and what fills the placeholders.

Nothing reads the sentence again: what it means is looked up from its derivation (:mod:`tests.eval.gpsr.kinds`).
"""

from __future__ import annotations

import random
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from tests.eval.gpsr import grammar as g
from tests.eval.gpsr.lexicon import Gender, Lexicon, read_lexicon

ROOT: Final = "main"
POLITE: Final = "polite"
MEANT: Final = {"vbclean": "vbcleanup"}
"""Rules that the published grammar speaks of and does not define, and what it must mean by them."""
_TYPING_ERRORS: Final = {"op": "up"}
_OBJECTS: Final = ("object", "aobject", "kobject", "sobject")
_PRONOUNS: Final[dict[tuple[Gender, bool], str]] = {
    ("female", False): "her", ("female", True): "her", ("male", False): "him", ("male", True): "his",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Filled:
    """A placeholder with what was chosen for it; ``said`` is what the command calls it."""

    slot: g.Slot
    value: str
    said: str
    gender: Gender | None = None  # of a name


@dataclass(frozen=True, slots=True)
class Part:
    """A rule with the production that was drawn for it. Choices in parentheses are parts with the rule's name and a
    ``|``."""

    rule: str
    production: str
    children: tuple[Part | Filled | str, ...]

    def parts(self) -> Iterator[Part]:
        """This one and all below it, in the order of the words."""
        yield self
        for child in self.children:
            if isinstance(child, Part):
                yield from child.parts()

    def fills(self) -> Iterator[Filled]:
        """Everything that was filled, in the order of the words; what only the referee reads comes with it."""
        for child in self.children:
            if isinstance(child, Part):
                yield from child.fills()
            elif isinstance(child, Filled):
                yield child

    @property
    def text(self) -> str:
        words = (
            child.text if isinstance(child, Part) else child.said if isinstance(child, Filled) else child
            for child in self.children
        )
        return re.sub(r"\s+([,.])", r"\1", " ".join(filter(None, words)))


@dataclass(frozen=True, slots=True)
class Drawn:
    """One command as it was drawn."""

    category: str  # the rule below the root: fndppl, guide…
    tree: Part
    hidden: tuple[Filled, ...] = ()
    """What only the referee reads: the fillings of metas."""

    @property
    def text(self) -> str:
        return self.tree.text.rstrip(".")

    @property
    def path(self) -> tuple[str, ...]:
        """The rules that it came by."""
        return tuple(part.rule for part in self.tree.parts() if not part.rule.endswith("|"))

    def find(self, rule: str) -> Part | None:
        """The first part that is of a rule."""
        return next((part for part in self.tree.parts() if part.rule == rule), None)

    def has(self, rule: str) -> bool:
        return self.find(rule) is not None

    def word(self, rule: str) -> str:
        """What a rule came to in words."""
        part = self.find(rule)
        return part.text if part is not None else ""

    def filled(self, kind: str, number: int | None = None) -> Filled:
        """The first placeholder of a kind, or that of a number. Raises :class:`LookupError`."""
        kinds = _OBJECTS if kind == "object" else (kind,)
        for found in (*self.tree.fills(), *self.hidden):
            if found.slot.kind in kinds and number in (None, found.slot.number):
                return found
        raise LookupError(f"{self.text!r} has no {kind} {number or ''}")

    def fill(self, kind: str, number: int | None = None) -> str:
        return self.filled(kind, number).value


class Generator:
    """Draws from the grammar and the words of a folder."""

    def __init__(self, rules: g.Grammar, lexicon: Lexicon) -> None:
        self.rules = {**rules, **{name: rules[other] for name, other in MEANT.items() if other in rules}}
        self.lexicon = lexicon
        if lost := sorted(g.missing(self.rules)):
            raise g.GrammarError(f"rules without a production: {', '.join(lost)}")

    @property
    def categories(self) -> tuple[str, ...]:
        """The rules below the root."""
        return tuple(part.name for option in self.rules[ROOT] for part in option.parts if isinstance(part, g.Rule))

    def draw(self, category: str, chance: random.Random) -> Drawn:
        """A command of a category; half of them are said politely."""
        drawing = _Drawing(self, chance)
        polite = drawing.expand(POLITE) if POLITE in self.rules and chance.random() < 0.5 else None
        tree = drawing.expand(category)
        root = Part(ROOT, f"${category}", (polite, tree) if polite is not None else (tree,))
        return Drawn(category, root, tuple(drawing.hidden))


def generator(folder: Path) -> Generator:
    """That of a folder with the grammar's text files and the world's XML files. Raises :class:`OSError`."""
    files = sorted(folder.glob("*.txt"))
    if not files:
        raise FileNotFoundError(f"there is no grammar in {folder}")
    return Generator(g.read_grammar(files), read_lexicon(folder))


def categories_of(count: int, categories: Sequence[str], chance: random.Random) -> list[str]:
    """As many categories as commands are wanted: each as often as the others, in random order."""
    found: list[str] = []
    while len(found) < count:
        found += chance.sample(categories, len(categories))
    return found[:count]


@dataclass
class _Drawing:
    """One command in the making."""

    generator: Generator
    chance: random.Random
    hidden: list[Filled] = field(default_factory=list)
    _bound: dict[tuple[str, int], Filled] = field(default_factory=dict)
    _taken: set[str] = field(default_factory=set)
    _person: Filled | None = None

    def expand(self, rule: str) -> Part:
        option = self.chance.choice(self.generator.rules[rule])
        return Part(rule, str(option), self._sequence(rule, option))

    def _sequence(self, rule: str, sequence: g.Sequence) -> tuple[Part | Filled | str, ...]:
        return tuple(self._one(rule, part) for part in sequence.parts)

    def _one(self, rule: str, part: g.Text | g.Rule | g.Slot | g.Choice) -> Part | Filled | str:
        match part:
            case g.Text(words):
                return _TYPING_ERRORS.get(words, words)
            case g.Rule(name):
                return self.expand(name)
            case g.Choice(options):
                option = self.chance.choice(options)
                return Part(f"{rule}|", str(option), self._sequence(rule, option))
            case g.Slot():
                return self._slot(rule, part)

    def _slot(self, rule: str, slot: g.Slot) -> Filled:
        filled = self._fill(slot)
        if slot.meta is not None:
            for child in self._sequence(rule, slot.meta):
                if isinstance(child, Filled):
                    self.hidden.append(child)
        return filled

    def _fill(self, slot: g.Slot) -> Filled:
        if slot.kind == "void":
            return Filled(slot, "", "")
        if slot.kind == "pron":
            gender: Gender = self._person.gender or "female" if self._person else "female"
            word = _PRONOUNS[gender, slot.possessive]
            return Filled(slot, word, word, gender)
        kind = "object" if slot.kind in _OBJECTS else slot.kind
        known = self._bound.get((kind, slot.number)) if slot.number is not None else None
        if known is None:
            known = self._choose(slot)
            if slot.number is not None:
                self._bound[kind, slot.number] = known
        filled = Filled(slot, known.value, known.said, known.gender)
        if slot.kind == "name":
            self._person = filled
        return filled

    def _choose(self, slot: g.Slot) -> Filled:
        lexicon = self.generator.lexicon
        if slot.kind == "name":
            free = [one for one in lexicon.names if one[0] not in self._taken] or list(lexicon.names)
            name, gender = self.chance.choice(free)
            self._taken.add(name)
            return Filled(slot, name, name, gender)
        options = self._options(slot.kind)
        value = self.chance.choice([word for word in options if word not in self._taken] or options)
        self._taken |= {value, lexicon.room_of(value)}
        said = lexicon.category_of(value) if slot.vague and slot.kind in _OBJECTS else value
        return Filled(slot, value, said)

    def _options(self, kind: str) -> list[str]:
        lexicon = self.generator.lexicon
        match kind:
            case "room":
                return list(lexicon.rooms)
            case "beacon":
                return [one.name for one in lexicon.locations if one.is_beacon]
            case "placement":
                return [one.name for one in lexicon.locations if one.is_placement]
            case "category":
                return list(lexicon.categories)
            case "gesture":
                return list(lexicon.gestures)
            case "question":
                return list(lexicon.questions)
            case "kobject":
                return [ware.name for ware in lexicon.wares if ware.known]
            case "aobject":
                return [ware.name for ware in lexicon.wares if not ware.known and not ware.special]
            case "object":
                return [ware.name for ware in lexicon.wares if not ware.special]
        raise g.GrammarError(f"nothing fills {{{kind}}}")
