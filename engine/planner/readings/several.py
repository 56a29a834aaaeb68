"""Several things in one breath: "put the ball, the red box and the cup on the table", "throw the blocks away".

What is to be done with all of them is done with one after the other, so a reading names each in a command of its own.
Several that are only counted ("the cups", "both boxes") are those that the house has.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from engine.perception.naming import KINDS
from engine.planner.readings.corrections import bare
from engine.planner.text.language import alternatives, load
from engine.skills.vocabulary import Vocabulary

_COUNTS: Final = {"two": 2, "three": 3, "four": 4, "2": 2, "3": 3, "4": 4}
MOST: Final = 8
"""Things that a list may have: more are a matter of cleaning up."""
_THE: Final = r"(?:(?:the|a|an|my|your|our|that|this|those|these|his|her|their) )?"
_AND: Final = r"(?:,? (?:and|plus|as well as|and also|and then|then) |, )"
_STARTS: Final = re.compile(r"^|[,;.] ?(?:and |then )*| (?:and then|and|then) ", re.IGNORECASE)
_ENDS: Final = re.compile(r"[,;.] ?| (?:and then|and|then) |$", re.IGNORECASE)
_THEM: Final = re.compile(
    r",? and (?P<verb>\w+) (?:them(?: both| all)?|both(?: of them)?|all(?: of)?(?: them)?|everything|those|these)"
    r"(?P<rest>(?: .*)?)",
    re.IGNORECASE,
)
""" "Get the cup and the ball and put them on the table"."""
_BOTH: Final = re.compile(r" (?:both(?: of)?|all(?: of)?|everything|each of)$", re.IGNORECASE)


class Several:
    """Knows the things of one house."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        self._vocabulary = vocabulary
        things = load("en")["things"]
        singular: Mapping[str, Iterable[str]] = things["one"]
        plural: Mapping[str, Iterable[str]] = things["many"]
        colours = _colours()
        self.thing = thing_of(vocabulary)
        """Finds what names a thing of this house."""
        thing = self.thing.pattern
        self._one_by_one = re.compile(rf"{thing}(?:{_AND}{thing})+", re.IGNORECASE)
        self._kinds = {word: kind for kind, words in plural.items() for word in words}
        self._every = {word: kind for kind, words in singular.items() for word in words}
        self._all = re.compile(
            rf"(?<!\w)(?:(?:all|both)(?: of)?(?: (?:the|my|your|our|those|these))?|the|those|these|my) "
            rf"(?P<count>(?:two|three|four|2|3|4) )?(?P<colour>(?:{colours}) )?"
            rf"(?P<many>{alternatives(self._kinds)})(?!\w)"
            rf"|(?<!\w)(?:every|each) (?P<hue>(?:{colours}) )?(?P<one>{alternatives(self._every)})(?!\w)",
            re.IGNORECASE,
        )

    def one_by_one(self, text: str) -> Iterator[str]:
        """What ``text`` asks for with one thing at a time, in every way that it may be cut; nothing where it is not
        about several."""
        plain = bare(text)
        listed = self._all.sub(self._by_name, plain)
        if listed != plain:
            yield listed
        if (found := self._one_by_one.search(listed)) is None:
            return
        things = self.thing.findall(found[0])
        if len(things) > MOST:
            return
        before, after = listed[: found.start()].rstrip(), listed[found.end() :]
        starts = [match.end() for match in _STARTS.finditer(before)]
        ends = [match.start() for match in _ENDS.finditer(after)]
        for start in reversed(starts):
            head, verb = before[:start], _BOTH.sub("", f" {before[start:]}").strip()
            if (them := _THEM.match(after)) is not None:
                for end in (match.start() for match in _ENDS.finditer(them["rest"])):
                    yield _each(head, them["verb"], things, them["rest"][:end], them["rest"][end:])
            for end in ends:
                yield _each(head, verb, things, after[:end], after[end:])

    def _by_name(self, found: re.Match[str]) -> str:
        """Those that the house has, by their names; unchanged where it does not say which."""
        kind = self._kinds[found["many"].casefold()] if found["many"] else self._every[found["one"].casefold()]
        known = self._vocabulary.inventory()
        names = self._vocabulary.fitting(f"{found['colour'] or found['hue'] or ''}{kind}")
        if not names or not set(names) <= set(known) or len(names) > MOST:
            return found[0]
        if found["count"] and _COUNTS[found["count"].strip().casefold()] != len(names):
            return found[0]
        return " and ".join(f"the {name}" for name in names)


def thing_of(vocabulary: Vocabulary) -> re.Pattern[str]:
    """What names one thing, with its article."""
    kinds: Mapping[str, Iterable[str]] = load("en")["things"]["one"]
    names = {*vocabulary.inventory(), *(word for words in kinds.values() for word in words), *KINDS}
    number = r"(?: \d+| (?:one|two|three|four|five|six)(?= ?(?:[,;.]|$)))?"
    thing = rf"(?<!\w){_THE}(?:(?:{_colours()}) )?(?:{alternatives(names)}){number}(?!\w)"
    return re.compile(thing, re.IGNORECASE)


def _colours() -> str:
    return alternatives(word for words in load("en")["things"]["colours"].values() for word in words)


def _each(head: str, verb: str, things: Iterable[str], rest: str, tail: str) -> str:
    steps = ", then ".join(f"{verb} {thing}{rest}" for thing in things)
    return f"{head} {steps}{tail}".strip()
