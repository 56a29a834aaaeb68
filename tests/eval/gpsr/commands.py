"""Commands of the grammar with their meanings, drawn by a seed: the sentence, the house that it needs, and its goal."""

from __future__ import annotations

import random
from typing import Final

from tests.eval.gpsr import kinds_of_people, kinds_of_things
from tests.eval.gpsr.draw import Drawn, Generator, categories_of
from tests.eval.gpsr.goal import Command
from tests.eval.gpsr.lexicon import Language
from tests.eval.gpsr.making import Kind, Making, Undrawable

KINDS: Final = {**kinds_of_things.KINDS, **kinds_of_people.KINDS}
_TRIES: Final = 100


class UnknownKind(LookupError):
    """A command whose production nobody has said the meaning of."""


def commands(
    generator: Generator, count: int, seed: int, *, language: Language = "en", category: str | None = None
) -> list[Command]:
    """``count`` commands, each category as often as the others. Raises :class:`UnknownKind`."""
    wanted = categories_of(count, [category] if category else generator.categories, random.Random(seed))
    return [_command(generator, seed, number, name, language) for number, name in enumerate(wanted)]


def _command(generator: Generator, seed: int, number: int, category: str, language: Language) -> Command:
    chance = random.Random(f"{seed} {number}")
    for _ in range(_TRIES):
        drawn = generator.draw(category, chance)
        kind, production = kind_of(drawn)
        try:
            order = kind(Making(drawn, generator.lexicon, language, chance))
        except Undrawable:
            continue
        text = order.chinese if language == "zh" else drawn.text
        return Command(seed, number, category, production, drawn.path, language, text, order.needs, order.goal)
    raise UnknownKind(f"no command of {category} makes sense")


def kind_of(drawn: Drawn) -> tuple[Kind, str]:
    """What a derivation means, and the production that says so. Raises :class:`UnknownKind`."""
    for part in drawn.tree.parts():
        if (kind := KINDS.get((part.rule, part.production))) is not None:
            return kind, f"${part.rule} = {part.production}"
    raise UnknownKind(f"nobody has said what {drawn.text!r} means ({' > '.join(drawn.path)})")
