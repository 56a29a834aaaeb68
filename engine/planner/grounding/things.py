"""Whether a thing of a plan has a ground.

It was named in the newest words, or is "it" or "the red one" after what was named before, or is the only one of its
kind that was seen, or was seen where whatever there is was asked for.
"""

from __future__ import annotations

from engine.errors import PlanError
from engine.planner.grounding.colours import COLOURS
from engine.planner.grounding.grounds import Grounds
from engine.planner.grounding.mentions import Thing
from engine.planner.grounding.questions import WHICH_THING, Question, as_it_stands, which_one
from engine.planner.grounding.statement import Statement
from engine.planner.grounding.vagueness import vague
from engine.skills.vocabulary import Vocabulary


def about_thing(grounds: Grounds, value: str) -> Question | None:
    """What to ask about a thing; None where it has a ground."""
    thing, newest, vocabulary = Thing.of(value), grounds.newest, grounds.vocabulary
    if any(_names(statement, thing, vocabulary) for statement in (newest, *grounds.known)):
        return None
    names_something = _has_kinds(newest) or bool(_house_names(newest, vocabulary))
    if not names_something and _was_named_before(grounds, thing):
        return None
    if question := _which_of_house(newest, value, vocabulary):
        return question
    if any(thing.fits(mention, any_colour=True) for mention in newest.mentions):
        return _which_of_kind(grounds, thing)
    is_open = grounds.asks_for_whatever() or not (names_something or vague(newest.text))
    if is_open and any(_names(statement, thing, vocabulary) for statement in grounds.seen):
        return None
    return WHICH_THING


def _was_named_before(grounds: Grounds, thing: Thing) -> bool:
    """Whether it is what the user spoke of last before the newest words: "it", or "the red one" after "the box"."""
    before = (statement for statement in reversed(grounds.said[:-1]) if _is_about_things(statement, grounds.vocabulary))
    if (last := next(before, None)) is None:
        return False
    if colours := _colours(grounds.newest):
        return thing.colour in colours and any(thing.fits(mention, any_colour=True) for mention in last.mentions)
    return _names(last, thing, grounds.vocabulary)


def _which_of_kind(grounds: Grounds, thing: Thing) -> Question | None:
    """What to ask where only its kind was said ("the box"); None where one alone of that kind was seen or named."""
    visible = (mention for statement in (*grounds.seen, *grounds.said[:-1]) for mention in statement.mentions)
    colours = {mention.colour for mention in visible if mention.colour and thing.fits(mention, any_colour=True)}
    if not _colours(grounds.newest) and colours == {thing.colour}:
        return None
    return which_one(thing.noun, colours) if len(colours) > 1 else WHICH_THING


def _which_of_house(statement: Statement, value: str, vocabulary: Vocabulary) -> Question | None:
    """The question that a word has which means several things of this house."""
    for name in _house_names(statement, vocabulary):
        try:
            vocabulary.object(name)
        except PlanError as error:
            if error.code == "ambiguous" and value in vocabulary.fitting(name):
                return as_it_stands(error.message)
    return None


def _names(statement: Statement, thing: Thing, vocabulary: Vocabulary) -> bool:
    """Whether this thing is named: by what it looks like, or by a name that it has in this house."""
    if any(thing.fits(mention) for mention in statement.mentions):
        return True
    for name in _house_names(statement, vocabulary):
        fitting = vocabulary.fitting(name)
        if thing.value in fitting and (len(fitting) == 1 or statement.asks_for_any(name)):
            return True
    return False


def _house_names(statement: Statement, vocabulary: Vocabulary) -> tuple[str, ...]:
    """The names of things of this house in a statement, and parts of them ("the teddy"); colours alone are none."""
    known = dict.fromkeys((*vocabulary.things(), *vocabulary.thing_words()))
    return tuple(word for word in known if word not in COLOURS and statement.says(word))


def _is_about_things(statement: Statement, vocabulary: Vocabulary) -> bool:
    return _has_kinds(statement) or bool(_colours(statement)) or bool(_house_names(statement, vocabulary))


def _has_kinds(statement: Statement) -> bool:
    return any(mention.has_kind for mention in statement.mentions)


def _colours(statement: Statement) -> set[str]:
    return {mention.colour for mention in statement.mentions if mention.colour}
