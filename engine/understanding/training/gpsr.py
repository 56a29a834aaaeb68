"""Commands of RoboCup@Home's General Purpose Service Robot task (kyordhel/GPSRCmdGen, MIT), with meanings.

The grammar's alternatives are written out here as patterns whose marks say what the words in them are. A fixed third of
the patterns, chosen by a hash, is for development and never learnt from; names, places and things are the same in both.
"""

from __future__ import annotations

import hashlib
import random
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from engine.understanding.notation import Example, read

_Words = Mapping[str, Sequence[str]]

_RULES: Final = {
    "go": "go|navigate",
    "find": "find|locate|look for",
    "bring": "bring|give",
    "deliver": "bring|give|deliver",
    "take": "get|grasp|take|pick up",
    "place": "put|place",
    "carry": "bring|take",
    "guide": "guide|escort|take|lead|accompany",
    "speak": "tell|say",
    "serve": "serve|arrange|deliver|distribute|give|provide",
    "meet": "meet|contact|face|find|greet",
    "clean": "clean out|clean up|tidy up|neaten|order|clean",
    "takeout": "take out|dump",
    "garbage": "litter|garbage|trash|waste|debris|junk",
    "luggage": "bag|baggage|valise|suitcase|trolley",
    "taxi": "taxi|cab|uber",
    "door": "front entrance|back entrance|main entrance|rear entrance|front door|back door|main door|rear door",
    "property": "biggest|largest|smallest|heaviest|lightest|thinnest",
    "most": "left most|right most|leftmost|rightmost",
    "beside": "at the left of|at the right of|on top of|above|behind|under",
    "pose": "sitting|standing|lying down",
    "kind": "man|woman|boy|girl|male person|female person",
    "kinds": "men|women|boys|girls",
    "guests": "everyone|all the people|all the men|all the women|all the guests|all the elders|all the children",
    "refreshments": "drinks|snacks",
    "trait": "name|gender|pose",
    "will": "may|can|will",
}  # fmt: skip
"""The rules of the grammar that are a choice of words."""
_SPEECH: Final = (
    ("answer", "answer {topic: a question}"),
    ("answer", "[speak] {topic: something about yourself}"),
    ("answer", "[speak] {topic: the time}"),
    ("answer", "[speak] {topic: what day is today}"),
    ("answer", "[speak] {topic: what day is tomorrow}"),
    ("answer", "[speak] {topic: your team's name}"),
    ("answer", "[speak] {topic: your team's country}"),
    ("answer", "[speak] {topic: your team's affiliation}"),
    ("answer", "[speak] {topic: the day of the week}"),
    ("answer", "[speak] {topic: the day of the month}"),
    ("answer", "[speak] {topic: a joke}"),
)
"""What the robot is to say to somebody whom it found."""
_FOUND: Final = ("a [kind]", "a person [gesture]", "a person [pose]")
_WAVING: Final = "{person: the person [gesture]} in {place: the [room]}"
_SOURCE: Final = "from {source: the [placement]}"

_PATTERNS: Final = (
    # deliver
    ("pick_up put", "[take] {1.thing: the [object]} and [place] {2.thing: it} on {2.place: the [placement]}"),
    ("put", "[place] {thing: the [object]} on {place: the [placement]}"),
    ("bring", "[bring] {person: me} {thing: the [object]}"),
    ("bring", "[deliver] {thing: the [object]} to {person: me}"),
    ("bring", f"[deliver] {{thing: the [object]}} to {_WAVING}"),
    ("pick_up put", "[take] {1.thing: the [object]} from {1.source: the [placement]} and [place] {2.thing: it} on"
                    " {2.place: the [other]}"),
    ("pick_up bring", "[take] {1.thing: the [object]} from {1.source: the [placement]} and [deliver] {2.thing: it} to"
                      " {2.person: me}"),
    ("pick_up bring", "[take] {1.thing: the [object]} from {1.source: the [placement]} and [deliver] {2.thing: it} to"
                      " {2.person: [name]} at {2.place: the [beacon]}"),
    ("go find bring", "[go] to {1.place: the [placement]}, [find] {2.thing: the [object]}, and [deliver] {3.thing: it}"
                      " to {3.person: me}"),
    ("go find bring", "[go] to {1.place: the [placement]}, [find] {2.thing: the [object]}, and [deliver] {3.thing: it}"
                      " to {3.person: [name]} at {3.place: the [beacon]}"),
    ("go find put", "[go] to {1.place: the [placement]}, [find] {2.thing: the [object]}, and [place] {3.thing: it} on"
                    " {3.place: the [other]}"),
    ("bring", "[carry] {thing: the [object]} from {source: the [room]} to {place: the [placement]}"),
    ("bring", "[bring] {person: me} {thing: the [object]} from {source: the [placement]}"),
    ("bring", "[carry] {thing: my [luggage]} to {place: the [taxi]}"),
    # complex manipulation
    ("bring", "[carry] {thing: the [object]} to {place: the [placement]}"),
    ("bring", f"[bring] {{person: me}} {{thing: the [most] object}} {_SOURCE}"),
    ("bring", f"[bring] {{person: me}} {{thing: the object [beside] the [object]}} {_SOURCE}"),
    ("bring", f"[bring] {{person: me}} {{thing: the [property] object}} {_SOURCE}"),
    ("bring", f"[bring] {{person: me}} {{thing: the [property] [category]}} {_SOURCE}"),
    ("clean", "[clean] {place: the [room]}"),
    ("throw_away", "[takeout] {thing: the [garbage]}"),
    # find objects
    ("count", "tell me how many {thing: [objects]} there are on {place: the [placement]}"),
    ("count", "tell me how many {thing: [category]} there are on {place: the [placement]}"),
    ("find", "[find] {thing: the [object]} in {place: the [room]}"),
    ("find", "[find] {thing: the [category]} in {place: the [room]}"),
    ("find", "[find] {thing: three [category]} in {place: the [room]}"),
    ("describe", "tell me what's {thing: the [property] object} on {place: the [placement]}"),
    ("describe", "tell me what's {thing: the [property] [category]} on {place: the [placement]}"),
    ("describe", "tell me which are {thing: the three [property] objects} on {place: the [placement]}"),
    ("describe", "tell me which are {thing: the three [property] [category]} on {place: the [placement]}"),
    # find people
    ("describe", "tell me {topic: the [trait]} of {person: the person} at {place: the [beacon]}"),
    ("describe", "tell me {topic: the [trait]} of {person: the person} in {place: the [room]}"),
    ("count", "tell me how many {person: people} in {place: the [room]} are [pose]"),
    ("count", "tell me how many {person: people} in {place: the [room]} are [kinds]"),
    # follow
    ("follow", "follow {person: [name]} from {source: the [beacon]} to {place: the [room]}"),
    ("meet follow", "meet {1.person: [name]} at {1.place: the [beacon]} and follow {2.person: [pronoun]}"),
    ("meet follow", "meet {1.person: [name]} at {1.place: the [beacon]} and follow {2.person: [pronoun]} to {2.place:"
                    " the [room]}"),
    ("go meet follow", "[go] to {1.place: the [beacon]}, meet {2.person: [name]}, and follow {3.person: [pronoun]}"),
    ("meet follow go", "meet {1.person: [name]} at {1.place: the [beacon]}, follow {2.person: [pronoun]}, and [go] to"
                       " {3.place: the [room]}"),
    ("meet follow guide", "meet {1.person: [name]} at {1.place: the [beacon]}, follow {2.person: [pronoun]}, and"
                          " [guide] {3.person: [pronoun]} back"),
    ("follow", "follow {person: [name]}"),
    # guide
    ("guide", "[guide] {person: [name]} from {source: the [beacon]} to {place: the [spot]}"),
    ("meet guide", "meet {1.person: [name]} at {1.place: the [beacon]} and [guide] {2.person: [pronoun]} to {2.place:"
                   " the [spot]}"),
    ("go meet guide", "[go] to {1.place: the [beacon]}, meet {2.person: [name]}, and [guide] {3.person: [pronoun]} to"
                      " {3.place: the [spot]}"),
    ("guide fact", "[guide] {1.person: [name]} to {1.place: the [spot]}, you [will] find {2.person: [pronoun]} at"
                   " {2.place: the [beacon]}"),
    ("guide", "[guide] {person: [name]} to {place: the [beacon]}"),
    ("meet guide", "meet {1.person: [name]} and [guide] {2.person: [pronoun]}"),
    ("go meet guide", "[go] to {1.place: the [beacon]}, meet {2.person: [name]}, and [guide] {3.person: [pronoun]}"),
    # party host
    ("bring", "[serve] {thing: [refreshments]} to {person: [guests]} in {place: the [room]}"),
    ("meet introduce", "[meet] {1.person: [name]} at {1.place: the [door]} and introduce {2.person: [pronoun]} to"
                       " {2.person: [guests]} in {2.place: the [room]}"),
    ("meet ask", "[meet] {1.person: [name]} at {1.place: the [beacon]} and ask {2.person: [pronoun]} {2.text: to"
                 " leave}"),
    ("meet introduce", "[meet] {1.person: [name]} at {1.place: the [beacon]} and introduce {2.person: [pronoun]} to"
                       " {2.person: [someone]} at {2.place: the [spot]}"),
    ("meet guide", "[meet] {1.person: [name]} at {1.place: the [beacon]} and [guide] {2.person: [pronoun]} to"
                   " {2.place: [possessive] [taxi]}"),
)  # fmt: skip
"""The productions of the grammar: acts, and a sentence with marks. A word in square brackets is a rule or a list."""
_POLITE: Final = ("", "", "", "please ", "could you ", "robot please ", "could you please ", "robot, please ")
_SPOKEN_SHARE: Final = 0.2
"""How many of the commands are of those many productions."""
_PRONOUNS: Final = {"Female": ("her", "her"), "Male": ("him", "his"), "": ("them", "their")}
_PLURALS: Final = {"dish": "dishes", "knife": "knives", "cereal": "cereal boxes", "sprite": "sprites", "coke": "cokes"}


def examples(folder: Path, count: int, chance: random.Random) -> tuple[list[Example], list[Example]]:
    """``count`` different commands, to learn from and for development, each list evenly over its productions."""
    words, people = _words(folder), _people(folder)
    found: tuple[dict[str, Example], dict[str, Example]] = ({}, {})
    spoken = list(_spoken())
    for _ in range(count * 20):
        acts, pattern = chance.choice(spoken if chance.random() < _SPOKEN_SHARE else _PATTERNS)
        example = read(f"{acts} | {_said(pattern, words, people, chance)}")
        found[_is_kept(pattern)].setdefault(example.text, example)
        if sum(map(len, found)) >= count:
            break
    return list(found[0].values()), list(found[1].values())


def _is_kept(pattern: str) -> bool:
    """Whether a production is for development."""
    return hashlib.sha256(pattern.encode()).digest()[0] % 3 == 0


def _spoken() -> Iterator[tuple[str, str]]:
    """The productions in which something is said to somebody: each with everything that can be said."""
    for acts, speech in _SPEECH:
        yield f"find {acts}", f"[find] {{1.person: [found]}} in {{1.place: the [room]}} and {_second(speech, 2)}"
        led = "[go] to {1.place: the [room]}, [find] {2.person: [found]}, and "
        yield f"go find {acts}", led + _second(speech, 3)
        yield _addressed(speech)


def _second(speech: str, number: int) -> str:
    return speech.replace("{topic", f"{{{number}.topic")


def _addressed(speech: str) -> tuple[str, str]:
    """What is said to somebody who is described: an answer to a question, or something that is told."""
    if speech.startswith("answer"):
        return "answer", f"{speech} to {{person: the person [gesture] in the [room]}}"
    return "tell", f"[speak] {speech.removeprefix('[speak] ')} to {_WAVING}"


def _said(pattern: str, words: _Words, people: Sequence[tuple[str, str]], chance: random.Random) -> str:
    """One sentence of a pattern, with its marks."""
    name, gender = chance.choice(people)
    someone = chance.choice([other for other, _ in people if other != name])
    pronoun, possessive = chance.choice((_PRONOUNS[gender], _PRONOUNS[""]))
    own = {"name": name, "someone": someone, "pronoun": pronoun, "possessive": possessive}
    own["found"] = chance.choice(_FOUND)
    taken: set[str] = set()

    def fill(found: re.Match[str]) -> str:
        if found[1] in own:
            return own[found[1]]
        options = [word for word in words[found[1]] if word not in taken] or list(words[found[1]])
        word = chance.choice(options)
        taken.add(word)
        return word

    text = pattern
    while "[" in text:
        text = re.sub(r"\[(\w+)\]", fill, text)
    return _typed(chance.choice(_POLITE) + text, chance)


def _typed(text: str, chance: random.Random) -> str:
    """As it is typed, or as a recogniser writes it."""
    if chance.random() < 0.5:
        return text if chance.random() < 0.6 else f"{text[0].upper()}{text[1:]}"
    mark = "?" if text.startswith("could") and chance.random() < 0.6 else "."
    return f"{text[0].upper()}{text[1:]}{mark}"


def _words(folder: Path) -> _Words:
    """The words of each rule and list."""
    locations = ElementTree.parse(folder / "Locations.xml").getroot()  # noqa: S314 our own copy
    objects = ElementTree.parse(folder / "Objects.xml").getroot()  # noqa: S314
    gestures = ElementTree.parse(folder / "Gestures.xml").getroot()  # noqa: S314
    placements = _named(locations, ".//location[@isPlacement='true']")
    beacons = _named(locations, ".//location[@isBeacon='true']")
    return {
        **{rule: options.split("|") for rule, options in _RULES.items()},
        "room": _named(locations, "room"),
        "placement": placements, "other": placements, "beacon": beacons, "spot": beacons,
        "category": _named(objects, "category"),
        "object": _named(objects, ".//object"),
        "objects": [_plural(name) for name in _named(objects, ".//object")],
        "gesture": _named(gestures, "gesture"),
    }  # fmt: skip


def _plural(name: str) -> str:
    return _PLURALS.get(name, name if name.endswith("s") else f"{name}s")


def _people(folder: Path) -> list[tuple[str, str]]:
    """Names, each with its gender."""
    names = ElementTree.parse(folder / "Names.xml").getroot()  # noqa: S314
    return [(name.text or "", name.attrib["gender"]) for name in names.findall("name")]


def _named(tree: ElementTree.Element, path: str) -> list[str]:
    return [found.attrib["name"] for found in tree.findall(path)]
