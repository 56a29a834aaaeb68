"""Clauses that go round about: "your next stop is the hall", "having put it down, …", "keep it up for three seconds".

Each clause of a request is put as plainly as there is a way to: where somebody is to be, what is to be where, how long
to wait, in which order. The clauses that need no other words stay as they are. As with all readings, whoever asks for
them knows whether they make a command.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from engine.planner.readings.corrections import QUOTES, bare
from engine.planner.readings.destinations import Destinations
from engine.planner.readings.rewording import Rewordings
from engine.planner.readings.verb_forms import ordered
from engine.planner.text.language import alternatives, load
from engine.skills.vocabulary import Vocabulary

_COUNT: Final = {"once": 1, "twice": 2, "thrice": 3, "two": 2, "three": 3, "four": 4, "five": 5, "six": 6}
_COMES_HERE: Final = frozenset({"come", "come over", "come here", "come home"})
"""After something else, or before it: back to whoever speaks."""


class Roundabout:
    """Knows the places of one house."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        sections = load("en")
        polite = alternatives((*sections["fillers"], *sections["hesitations"]))
        self._polite = re.compile(rf"(?:(?:{polite}) )+(?=\w)", re.IGNORECASE)
        self._destinations = Destinations(vocabulary)
        rewordings = Rewordings("en", {})
        self._clauses = rewordings.rules("clauses", frame="<opened>{}", keeps="{first}")
        self._padding = rewordings.rules("padding")
        self._requests = rewordings.rules("requests")
        self._cut, self._times, self._trailing = map(rewordings.pattern, ("cut", "times", "trailing"))
        self._gerund, self._having = rewordings.pattern("gerund"), rewordings.pattern("having")
        self._another, self._wherever = rewordings.pattern("another"), rewordings.pattern("wherever")
        self._done, self._by_doing = rewordings.pattern("done"), rewordings.pattern("by_doing")
        self._while = rewordings.pattern("while_behind"), rewordings.pattern("while_before")
        self._at = rewordings.pattern("at")

    def of(self, text: str) -> Iterator[str]:
        """``text`` in plainer clauses, the smallest change first; nothing where there is nothing to change."""
        plain = bare(text)
        if not plain or QUOTES.search(plain):
            return
        found = [plain]
        if (short := self._shortened(plain)) != plain:
            found.append(short)
            plain = short
        if (joined := self._done.sub(", then ", plain)) != plain:
            found.append(joined.removeprefix(", then "))
        for way in (self._whole, self._clause_by_clause, self._without_ends):
            for before in tuple(found):
                found += [after for after in way(before) if after and after not in found]
        yield from found[1:]

    def _shortened(self, text: str) -> str:
        """Without what only counts the steps or urges, and with steps in the place of purposes."""
        for rule in self._padding:
            text = rule.everywhere(text)
        return text.strip()

    def _whole(self, text: str) -> Iterator[str]:
        """What concerns more than one clause."""
        yield from self._destinations.routes(text)
        if (found := next(filter(None, (way.match(text) for way in self._while)), None)) is not None:
            steps = (found["one"], ordered(found["two"]))
            yield ", then ".join(reversed(steps) if self._at.match(found["two"]) else steps)
        yield from (plain for rule in self._requests if (plain := rule.everywhere(text)) != text)
        if (shorter := self._by_doing.sub("", text)) != text:
            yield ordered(shorter)

    def _clause_by_clause(self, text: str) -> Iterator[str]:
        """With every clause as plain as it gets."""
        parts = self._cut.split(text)
        plainer: list[str] = []
        for at, part in enumerate(parts):
            plainer.append(part if at % 2 else self._plainer(part, first=at == 0, last=at == len(parts) - 1))
        count = self._times.fullmatch(parts[-1]) if len(parts) > 2 else None
        if count is not None:
            times = _COUNT.get((count["word"] or count["number"]).casefold()) or int(count["number"])
            yield "".join(plainer[:-2]) + ", then again" * (times - 1)
        yield "".join(plainer)

    def _plainer(self, clause: str, *, first: bool, last: bool) -> str:
        bare_clause = self._polite.sub("", clause, count=1) if self._polite.match(clause) else clause
        for way in dict.fromkeys((clause, bare_clause)):
            if (plain := self._plainest(way, first=first, last=last)) != way:
                return plain
        return bare_clause

    def _plainest(self, clause: str, *, first: bool, last: bool) -> str:
        if clause.casefold() in _COMES_HERE and not (first and last):
            return "come back"
        if first and not last and (place := self._destinations.stay(clause)):
            return place
        if (request := self._gerund.sub(r"\g<first>", clause)) != clause:
            clause = ordered(request)
        elif (done := self._having.sub("", clause)) != clause and first and not last:
            clause = ordered(done)
        if journey := self._destinations.journey(clause):
            return journey
        clause = self._wherever.sub("", self._another.sub("a ", clause))
        return next((plain for rule in self._clauses if (plain := rule.at_start(clause)) != clause), clause)

    def _without_ends(self, text: str) -> Iterator[str]:
        """Without what clauses may end in."""
        parts = self._cut.split(text)
        shorter = [part if at % 2 else self._trailing.sub("", part) or part for at, part in enumerate(parts)]
        if (plain := "".join(shorter)) != text:
            yield plain
