"""Who was seen where and when: the robot's memory of people.

People walk, so that a place alone tells nobody, and clothes alone tell nobody either where two are dressed alike. A
sighting is somebody remembered if the clothes fit and the way there can have been walked since. A known person gets
their name by their tag, by having said it, or by what they wear where nobody else who is known could wear that.

Thread-safe: the loop that runs skills writes, the console reads frozen facts.
"""

from __future__ import annotations

import math
import threading
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from engine.perception.gestures import LASTS_S, gesture_of
from engine.perception.sighting import Colour, Sight, Sighting
from engine.perception.someone import Gender, Someone
from engine.robot.camera import Picture
from engine.robot.company import Gesture, Posture

FASTEST: Final = 1.5
"""m/s that people walk."""
LONGEST_S: Final = 60.0
"""Robot time after which somebody may be anywhere, s."""
PLAIN: Final = 3.0
"""m within which somebody who is in the picture is certain to be noticed."""
MOST: Final = 50
"""People who are remembered: beyond that whoever was seen longest ago is forgotten, those with a name last."""
REACH: Final[Mapping[Posture | None, float]] = {None: 0.3, "standing": 0.3, "sitting": 0.5, "lying": 0.9}
"""m around somebody within which what looks like a thing may be a shoe, a leg or a hand."""
_GATE = 0.6  # m that the same person, standing, may seem to be elsewhere
_UNTOLD_S = 1.0  # s that somebody is known for by their way alone, where nothing of their clothes shows
_STAYED = 0.5  # m within which a posture that does not show now is still the one that did
_ONE_PLACE = 0.3  # m within which there is room for one body, the robot's or somebody's
_SHADES: Final = (frozenset(("white", "grey")), frozenset(("grey", "black")))
"""Colours that light and shadow make of one another."""
_MOST_VOTES = 20  # pictures that count for a colour
_BEHIND = 0.5  # m by which the picture must look past where somebody was
_EDGE = 6  # pixels at the picture's edge where somebody may be cut off and not be noticed


@dataclass(frozen=True, slots=True)
class Looks:
    """What a known person wears; None leaves open."""

    shirt: Colour | None = None
    trousers: Colour | None = None
    tag: int | None = None  # of the family 36h11, on their clothes


@dataclass(frozen=True, slots=True)
class PersonSeen:
    """One remembered person, as they were seen last. What did not show in any picture is None."""

    number: int  # unique in the session
    name: str | None
    shirt: Colour | None
    trousers: Colour | None
    posture: Posture | None
    gesture: Gesture | None
    position: tuple[float, float, float]  # of the middle of what showed of them, map frame, m
    sigma: float  # m, of a horizontal position
    height: float  # m, of as much as was seen of them at once
    seen_at: float  # robot time, s
    tag: int | None = None
    gone: bool = False  # the robot has looked there since, and they were not there any more

    def fits(self, who: Someone, gender: Gender | None) -> bool:
        """Whether this may be who is meant, by what shows; ``gender`` is what is known of it, which does not show."""
        return who.fits(
            name=self.name,
            gender=gender,
            posture=self.posture,
            gesture=self.gesture,
            shirt=self.shirt,
            trousers=self.trousers,
        )

    def distance_to(self, x: float, y: float) -> float:
        """On the floor, m."""
        return math.hypot(self.position[0] - x, self.position[1] - y)

    def may_be_part(self, colour: Colour, at: tuple[float, float], t: float) -> bool:
        """Whether what was seen low there at ``t`` (robot time, s) may be one of their shoes or legs."""
        worn = {self.trousers, "black"}
        alike = self.trousers is None or colour in worn or any({colour, one} in _SHADES for one in worn)
        return (
            alike
            and not self.gone
            and abs(t - self.seen_at) < LONGEST_S
            and self.distance_to(*at) < REACH[self.posture]
        )

    def is_stale(self, now: float) -> bool:
        """Whether they may be elsewhere at ``now`` (robot time, s)."""
        return self.gone or now - self.seen_at > LONGEST_S


@dataclass(slots=True)
class _Record:
    person: PersonSeen
    said: str | None = None  # the name that they have told
    denied: set[str] = field(default_factory=set)  # names that they have said not to have
    lately: list[tuple[float, Sighting]] = field(default_factory=list)  # what they did in the last moments
    shirts: Counter[Colour] = field(default_factory=Counter)  # in how many pictures it was which
    trousers: Counter[Colour] = field(default_factory=Counter)

    def wear(self, seen: Looks) -> None:
        """One more picture of their clothes. One may show a colour wrong: most of them count."""
        for votes, colour in ((self.shirts, seen.shirt), (self.trousers, seen.trousers)):
            if colour is not None:
                votes[colour] = min(votes[colour] + 1, _MOST_VOTES)
        self.person = replace(self.person, shirt=most_voted(self.shirts), trousers=most_voted(self.trousers))


@dataclass(frozen=True, slots=True)
class Answer:
    """What somebody has answered."""

    who: str  # as they are called
    question: str
    answer: str


class PeopleMemory:
    """Everybody seen so far. ``known`` are those who live here, by name, and what they wear."""

    def __init__(self, known: Mapping[str, Looks] | None = None) -> None:
        self._lock = threading.Lock()
        self._known = dict(known or {})
        self._records: dict[int, _Record] = {}
        self._numbers = 0
        self._last_answer: Answer | None = None
        self.met: tuple[str, int] = ("", 0)
        """Whom the robot has gone up to last: the words for them, and their number."""

    def heard(self, answer: Answer) -> None:
        """Somebody has answered."""
        self._last_answer = answer

    @property
    def last_answer(self) -> Answer | None:
        """What was answered last."""
        return self._last_answer

    def know(self, known: Mapping[str, Looks]) -> None:
        """These are the known people from now on."""
        with self._lock:
            self._known = dict(known)
            for record in self._records.values():
                self._rename(record)

    @property
    def everybody(self) -> tuple[PersonSeen, ...]:
        """All who are remembered, the newest sighting first."""
        with self._lock:
            people = [record.person for record in self._records.values()]
        return tuple(sorted(people, key=lambda person: -person.seen_at))

    def of_number(self, number: int) -> PersonSeen | None:
        """The one of this number; None where they have been forgotten."""
        with self._lock:
            record = self._records.get(number)
        return record.person if record is not None else None

    def find(
        self, fits: Callable[[PersonSeen], bool], near: tuple[float, float] | None = None
    ) -> tuple[PersonSeen, ...]:
        """Those who fit: the nearest first where ``near`` is given, else the newest; whoever has gone comes last."""
        found = [person for person in self.everybody if fits(person)]
        return tuple(sorted(found, key=lambda person: (person.gone, person.distance_to(*near) if near else 0.0)))

    def name_them(self, number: int, name: str) -> None:
        """They have said who they are: nobody else has that name."""
        with self._lock:
            for other, record in self._records.items():
                if other == number:
                    record.said = name
                elif name in (record.said, record.person.name):
                    record.said = None
            for record in self._records.values():
                self._rename(record)

    def deny(self, number: int, name: str) -> None:
        """They have said that this is not their name."""
        with self._lock:
            if number in self._records:
                self._records[number].denied.add(name)

    def has_denied(self, number: int, name: str) -> bool:
        """Whether they have said so."""
        with self._lock:
            return number in self._records and name in self._records[number].denied

    def forget(self, number: int) -> None:
        """They are not there."""
        with self._lock:
            self._records.pop(number, None)

    def forget_gestures(self) -> None:
        """What they do with their arms is looked at anew."""
        with self._lock:
            for record in self._records.values():
                record.lately.clear()
                record.person = replace(record.person, gesture=None)

    def clear(self) -> None:
        """Begin anew; those who live here stay known."""
        with self._lock:
            self._records.clear()

    def update(self, sight: Sight) -> tuple[PersonSeen, ...]:
        """Take in what was seen; gives the people in the picture in the order of ``sight.objects``."""
        people = [thing for thing in sight.objects if thing.kind == "person"]
        with self._lock:
            matches = self._matches(people, sight.t)
            seen: list[_Record] = []
            for index, sighting in enumerate(people):
                record = self._remember(matches.get(index), sighting, sight.t)
                seen.append(record)
            for record in seen:  # by name only when all of them are in: two who are dressed alike have none
                self._rename(record)
            numbers = [record.person.number for record in seen]
            self._leave({*self._missing(sight.picture, numbers), *self._displaced(sight.picture, numbers)})
            self._forget_some()
            return tuple(record.person for record in seen)

    def _matches(self, people: Sequence[Sighting], t: float) -> dict[int, _Record]:
        """Who of those remembered each of these is: the surest pairs first, each of both once."""
        pairs = sorted(
            (cost, index, number)
            for index, sighting in enumerate(people)
            for number, record in self._records.items()
            if (cost := self._cost(record, sighting, t)) is not None
        )
        found: dict[int, _Record] = {}
        taken: set[int] = set()
        for _, index, number in pairs:
            if index not in found and number not in taken:
                found[index] = self._records[number]
                taken.add(number)
        return found

    def _cost(self, record: _Record, sighting: Sighting, t: float) -> tuple[int, float] | None:
        """How unlikely the two are one, less first; None when they cannot be."""
        person, wears = record.person, _worn(sighting)
        if person.tag is not None and sighting.tag is not None:
            return (0, 0.0) if person.tag == sighting.tag else None
        away = person.distance_to(*sighting.position[:2])
        worn = Looks(person.shirt, person.trousers)
        if not _may_be(worn, wears) and not (away < _ONE_PLACE and _may_be(worn, wears, in_shadow=True)):
            return None
        within = away < self._gate(person, sighting, t)
        if not within and (person.name is None or self._by_clothes(wears) != person.name):
            return None
        return (1 if within else 2), away

    @staticmethod
    def _gate(person: PersonSeen, sighting: Sighting, t: float) -> float:
        """How far they can have gone, m. Who sits or lies stays, until the robot has seen that they are gone."""
        since = max(0.0, t - person.seen_at)
        if since > LONGEST_S:
            return math.inf
        if person.posture in ("sitting", "lying") and not person.gone:
            since = 0.0
        if _worn(sighting) == Looks():  # anybody may look like that
            since = min(since, _UNTOLD_S)
        return _GATE + 3 * math.hypot(person.sigma, sighting.sigma) + FASTEST * since

    def _remember(self, record: _Record | None, sighting: Sighting, t: float) -> _Record:
        known = record.person if record is not None else None
        if known is None:
            self._numbers += 1
        figure, wears = sighting.figure, _worn(sighting)
        stayed = known is not None and known.distance_to(*sighting.position[:2]) < _STAYED
        posture = figure.posture if figure is not None else None
        person = PersonSeen(
            number=known.number if known is not None else self._numbers,
            name=known.name if known is not None else None,
            shirt=wears.shirt,
            trousers=wears.trousers,
            posture=posture or (known.posture if known is not None and stayed else None),
            gesture=None,
            position=sighting.position,
            sigma=sighting.sigma,
            height=_height(known if stayed else None, sighting, posture),
            seen_at=t,
            tag=sighting.tag if sighting.tag is not None or known is None else known.tag,
        )
        record = record or _Record(person)
        record.lately = [(at, seen) for at, seen in record.lately if 0 <= t - at <= LASTS_S] + [(t, sighting)]
        record.person = replace(person, gesture=gesture_of([seen for _, seen in record.lately]))
        record.wear(wears)
        self._records[person.number] = record
        return record

    def _rename(self, record: _Record) -> None:
        """Give them the name that is theirs now, or none."""
        person = record.person
        by_tag = [name for name, looks in self._known.items() if looks.tag is not None and looks.tag == person.tag]
        name = record.said or (by_tag[0] if len(by_tag) == 1 else None)
        if name is None:
            worn = Looks(person.shirt, person.trousers)
            name = self._by_clothes(worn)
            others = [other for other in self._records.values() if other is not record]
            if name is not None and any(self._as_well(other, name, person) for other in others):
                name = None
        record.person = replace(person, name=name)

    def _as_well(self, other: _Record, name: str, person: PersonSeen) -> bool:
        """Whether somebody else has that name, or as much right to it: seen at the same time, dressed the same."""
        known = self._known[name].tag
        if other.said == name or (known is not None and other.person.tag == known):
            return True
        at_once = other.person.seen_at == person.seen_at
        return at_once and self._by_clothes(Looks(other.person.shirt, other.person.trousers)) == name

    def _by_clothes(self, worn: Looks) -> str | None:
        """Who alone could wear this, of those who are known."""
        if worn.shirt is None:
            return None
        fitting = [name for name, looks in self._known.items() if _may_be(looks, worn)]
        return fitting[0] if len(fitting) == 1 else None

    def _missing(self, picture: Picture, seen: Collection[int]) -> list[int]:
        """Those whom the picture should plainly show, and does not: it looks past where they were."""
        rest = [record.person for number, record in self._records.items() if number not in seen]
        if not rest or picture.guessed:
            return []
        return [person.number for person in rest if not person.gone and _looks_past(picture, person)]

    def _displaced(self, picture: Picture, seen: Collection[int]) -> list[int]:
        """Those who were where the robot stands now, or where somebody else has just been seen."""
        taken = [(picture.pose.x, picture.pose.y), *(self._records[number].person.position[:2] for number in seen)]
        rest = [record.person for number, record in self._records.items() if number not in seen]
        return [
            person.number
            for person in rest
            if not person.gone and any(person.distance_to(*at) < _ONE_PLACE for at in taken)
        ]

    def _leave(self, numbers: Collection[int]) -> None:
        """They are not where they were; whoever has a name is remembered all the same."""
        for number in numbers:
            record = self._records[number]
            if record.person.name is None:
                del self._records[number]
            else:
                record.person = replace(record.person, gone=True, posture=None, gesture=None)

    def _forget_some(self) -> None:
        order = sorted(self._records.values(), key=lambda r: (r.person.name is None, -r.person.seen_at))
        for record in order[MOST:]:
            del self._records[record.person.number]


def _worn(sighting: Sighting) -> Looks:
    """What shows of their clothes."""
    figure = sighting.figure
    return Looks(figure.shirt, figure.trousers) if figure is not None else Looks(sighting.colour)


def most_voted(votes: Counter[Colour]) -> Colour | None:
    """The colour that most pictures have shown; None where none has."""
    return votes.most_common(1)[0][0] if votes else None


def _may_be(one: Looks, other: Looks, *, in_shadow: bool = False) -> bool:
    """Whether nothing that shows of both differs, or no more than a shadow makes it differ."""
    pairs = ((one.shirt, other.shirt), (one.trousers, other.trousers))
    return all(a is None or b is None or a == b or (in_shadow and {a, b} in _SHADES) for a, b in pairs)


def _height(known: PersonSeen | None, sighting: Sighting, posture: Posture | None) -> float:
    """A picture that cuts somebody off tells less than one that did not, as long as they have not sat down."""
    same = known is not None and not sighting.complete and posture in (None, known.posture)
    return max(known.height, sighting.size[1]) if known is not None and same else sighting.size[1]


def _looks_past(picture: Picture, person: PersonSeen) -> bool:
    """Whether the picture shows what is behind all of where they were, near enough to notice them."""
    x, y, z = person.position
    around = person.height / 4 if person.posture != "lying" else 0.0
    points = picture.from_map(np.array([(x, y, z - around), (x, y, z), (x, y, z + around)]))
    away = picture.mount.into(points)[:, 2]
    if not (away.min() > 0.3 and away.max() < PLAIN):
        return False
    pixels = picture.pixels(points)
    height, width = picture.depth.shape
    inside = (pixels > _EDGE).all() and (pixels[:, 0] < width - _EDGE).all() and (pixels[:, 1] < height - _EDGE).all()
    if not inside:
        return False
    shown = picture.depth[pixels[:, 1].astype(int), pixels[:, 0].astype(int)]
    return bool((np.isfinite(shown) & (shown > away + _BEHIND + person.sigma)).all())
