"""The people whom the robot knows by name: those of the house, and those who have told their names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from config.nearest import nearest
from config.schema import KnownPerson
from engine.errors import ExitCode
from engine.han import SIMPLER
from engine.perception.people import Looks
from engine.perception.someone import Someone, UnknownPerson, someone

NEAR: Final = 0.8
"""How alike the name of somebody who is known has to be, 0 to 1: many names differ by a letter."""


class People:
    """Looks people up by their names."""

    def __init__(self, people: Mapping[str, KnownPerson] | None = None) -> None:
        self._people = dict(people or {})
        self.on_added: Callable[[str, KnownPerson], object] = lambda name, person: None

    def known(self) -> Mapping[str, KnownPerson]:
        """All of them, by name."""
        return dict(self._people)

    def names(self) -> tuple[str, ...]:
        """Every word for somebody, their name before their other names."""
        return tuple(word for name, person in self._people.items() for word in (name, *person.aliases))

    def name(self, word: str) -> str:
        """Of whom people call ``word``; empty where nobody is called so."""
        key = _key(word)
        return next((n for n, p in self._people.items() if key in map(_key, (n, *p.aliases))), "")

    def about(self, name: str) -> KnownPerson:
        """What is known of somebody; nothing of a stranger."""
        return self._people.get(name) or KnownPerson()

    def who(self, words: str) -> Someone:
        """Whom these words mean: somebody who is known, a stranger's name, or a description. Raises
        :class:`UnknownPerson`."""
        if name := self.name(words):
            return Someone(name)
        found = someone(words)
        if found.name and (name := self.name(found.name)):
            return Someone(name)
        if found.name and (near := nearest(found.name, self._people, NEAR)):
            error = UnknownPerson(f"I don't know {found.name}. Do you mean {near}?")
            error.exit_code = ExitCode.CLARIFY
            raise error
        return found

    def is_stranger(self, who: Someone) -> bool:
        """Whether only a name is said, and nobody here is known to have it."""
        return bool(who.name) and who.name not in self._people

    def add(self, name: str, person: KnownPerson) -> None:
        """Know somebody from now on, or know better what they wear. ``on_added`` is told."""
        old = self._people.get(name)
        if old is not None:
            seen = person.model_dump(exclude_none=True, exclude_defaults=True)
            person = old.model_copy(update=seen)
        self._people[name] = person
        self.on_added(name, person)


def looks_of(people: People) -> dict[str, Looks]:
    """By what each of them is told apart."""
    return {name: Looks(one.shirt, one.trousers, one.tag) for name, one in people.known().items()}


def _key(word: str) -> str:
    return word.casefold().translate(SIMPLER).strip(" .,!?。，！？")
