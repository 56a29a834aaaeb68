"""Whether what a command wants has come true: where people, things and the robot are, and who has heard what.

Judged from the physics of the run and from sentences of the robot with those who were near enough to hear them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from engine.robot.company import News
from engine.robot.sim.clutter import _away
from tests.eval import checker
from tests.eval.checker import Evidence, Sample
from tests.eval.gpsr.acts import Called, has
from tests.eval.gpsr.goal import MustBe, Truth

EARSHOT: Final = 3.0
"""m within which people hear the robot."""
BESIDE: Final = 1.5
"""m from somebody within which a thing that was laid down for them counts as given."""
TOGETHER: Final = 2.2
"""m between the robot and somebody whom it guides or follows, where they have arrived."""
LOST: Final = 3.0
"""m from somebody beyond which they are not followed any more."""
NEAR: Final = 2.0
"""m from somebody who walks about within which they are followed."""
WALKED: Final = 4.0
"""m that somebody must have walked who is followed for a minute."""
FIND_S: Final = 10.0
"""In which the robot may find whom it is to follow."""
KEPT: Final = 0.85
"""Part of the way that somebody must have been followed."""
AT: Final = 1.5
"""m from a place within which somebody has arrived there."""
BUMP: Final = 0.1
"""m/s of the robot when it touches somebody."""


@dataclass(frozen=True, slots=True)
class Spoken:
    """A sentence of the robot."""

    t: float  # robot time, s
    text: str
    near: tuple[str, ...]  # people who heard it, the nearest first


@dataclass(frozen=True, slots=True)
class Run:
    """All that is known of how a command was performed."""

    evidence: Evidence
    plans: Sequence[Sequence[Called]] = ()  # as they were made
    started: Sequence[Called] = ()  # actions that began
    spoken: Sequence[Spoken] = ()
    asked: Sequence[str] = ()  # what the robot wanted to know
    news: Sequence[News] = ()  # what people tell that they heard and did

    def person(self, name: str, sample: Sample | None = None) -> tuple[float, float]:
        x, y, _ = self.evidence.at(name, sample)
        return x, y

    def heard_by(self, name: str) -> list[str]:
        """What somebody has heard of the robot: as they tell themselves, and because they were near."""
        told = [news.text for news in self.news if news.who == name and news.does == "hears"]
        return [*told, *(spoken.text for spoken in self.spoken if name in spoken.near)]

    def apart(self, name: str, sample: Sample) -> float:
        """From the robot's middle to somebody, m."""
        x, y = self.person(name, sample)
        return math.hypot(x - sample.pose.x, y - sample.pose.y)


def who_hears(evidence: Evidence, sample: Sample) -> tuple[str, ...]:
    """Who is near enough to hear the robot, the nearest first."""
    away = {
        name: math.dist(evidence.at(name, sample)[:2], (sample.pose.x, sample.pose.y)) for name in evidence.scene.people
    }
    return tuple(sorted((name for name, distance in away.items() if distance <= EARSHOT), key=away.__getitem__))


def untrue(truths: Sequence[MustBe], run: Run) -> tuple[str, ...]:
    """What has not come true, a sentence each."""
    return tuple(fault for truth in truths if (fault := _JUDGES[truth.what](run, truth)))


def contacts(run: Run) -> tuple[str, ...]:
    """Whom the robot has run into: touched while it moved faster than :data:`BUMP`."""
    found: list[str] = []
    for before, now in pairwise(run.evidence.samples):
        speed = before.pose.distance_to(now.pose) / max(1e-6, now.t - before.t)
        if speed > BUMP and min((run.apart(name, now) for name in run.evidence.scene.people), default=9.0) < 0.6:
            touched = run.evidence.hull_contacts(now) & run.evidence.scene.people.keys()
            found += [name for name in sorted(touched) if name not in found[-1:]]
    return tuple(found)


def _on(run: Run, truth: MustBe) -> str:
    faults = [checker.lies_on(run.evidence, thing, truth.place) for thing in truth.things]
    return _enough(truth, faults)


def _given(run: Run, truth: MustBe) -> str:
    return _enough(truth, [_not_given(run, truth.who, thing) for thing in truth.things])


def _not_given(run: Run, who: str, thing: str) -> str | None:
    x, y, _ = run.evidence.middle(thing)
    away = math.dist((x, y), run.person(who))
    if checker.held(run.evidence, thing) is None:
        return f"the robot still holds the {thing}"
    if math.dist(run.evidence.at(thing, run.evidence.start), run.evidence.at(thing)) < checker.MOVED:
        return f"the {thing} is where it was"
    return f"the {thing} is {away:.1f} m from {_called(run, who)}" if away > BESIDE else None


def _binned(run: Run, truth: MustBe) -> str:
    return _enough(truth, [checker.in_bin(run.evidence, thing) for thing in truth.things])


def _put_away(run: Run, truth: MustBe) -> str:
    def lies_about(thing: str) -> str | None:
        if checker.in_bin(run.evidence, thing) is None or run.evidence.lowest(thing) > 2 * checker.LEVEL:
            return None
        return f"the {thing} lies on the floor"

    return _enough(truth, [lies_about(thing) for thing in truth.things])


def _enough(truth: MustBe, faults: Sequence[str | None]) -> str:
    good = sum(fault is None for fault in faults)
    return "" if good >= truth.count else "; ".join(filter(None, faults))


def _arrived(run: Run, truth: MustBe) -> str:
    """Somebody is at a place at the end, and the robot is with them."""
    away = _from_place(run, run.person(truth.who), truth.place)
    if away > AT:
        return f"{_called(run, truth.who)} is {away:.1f} m from the {truth.place}"
    apart = run.apart(truth.who, run.evidence.end)
    return f"the robot is {apart:.1f} m from {_called(run, truth.who)}" if apart > TOGETHER else ""


def _robot_in(run: Run, truth: MustBe) -> str:
    pose = run.evidence.end.pose
    away = _from_place(run, (pose.x, pose.y), truth.place)
    return f"the robot is {away:.1f} m from the {truth.place}" if away > 0.8 else ""


def _from_place(run: Run, at: tuple[float, float], name: str) -> float:
    """From a room, or from where a place is, m; 0 within."""
    scene = run.evidence.scene
    if name in scene.rooms:
        room = scene.rooms[name]
        return _away(at, (room.x[0], room.y[0], room.x[1], room.y[1]))
    near = [math.dist(at, scene.places[name].at)] if name in scene.places else []
    near += [_away(at, scene.furniture[name].area)] if name in scene.furniture else []
    return min(near)


def _found(run: Run, truth: MustBe) -> str:
    """The robot came near the things, or has told where they are."""
    told = [
        (float(done.data["x"]), float(done.data["y"]))
        for done in run.evidence.actions
        if {"x", "y"} <= done.data.keys()
    ]
    faults: list[str | None] = []
    for thing in truth.things:
        x, y, _ = run.evidence.at(thing)
        near = min(math.hypot(x - sample.pose.x, y - sample.pose.y) for sample in run.evidence.samples)
        placed = min((math.dist((x, y), at) for at in told), default=math.inf)
        faults.append(
            None if near < AT or placed < 0.3 else f"the robot came no nearer to the {thing} than {near:.1f} m"
        )
    return _enough(truth, faults)


def _accompanied(run: Run, truth: MustBe) -> str:
    """From when somebody began to walk to where they lead, the robot kept near them."""
    name, samples = truth.who, run.evidence.samples
    begun = run.person(name, run.evidence.start)
    goal = run.evidence.scene.people[name].leads[-1]
    walked = [s for s in samples if math.dist(run.person(name, s), begun) > 0.3]
    if not walked:
        return f"{_called(run, name)} never walked"
    at_end = next((i for i, s in enumerate(walked) if math.dist(run.person(name, s), goal) < 0.5), None)
    if at_end is None:
        return f"{_called(run, name)} did not get where they lead"
    way = walked[: at_end + 1]
    kept = sum(run.apart(name, sample) <= LOST for sample in way) / len(way)
    if kept < KEPT:
        return f"near {_called(run, name)} for {100 * kept:.0f} % of the way"
    last = min(run.apart(name, s) for s in samples if way[-1].t <= s.t <= way[-1].t + 15.0)
    return f"{last:.1f} m from {_called(run, name)} at the end of the way" if last > TOGETHER else ""


def _heard(run: Run, truth: MustBe) -> str:
    heard = run.heard_by(truth.who)
    if any(not word or has(text, word) for text in heard for word in truth.words):
        return ""
    words = "|".join(filter(None, truth.words)) or "anything"
    return f"{_called(run, truth.who)} has not heard {words}"


def _found_person(run: Run, truth: MustBe) -> str:
    near = min(run.apart(truth.who, sample) for sample in run.evidence.samples)
    return f"the robot came no nearer to {_called(run, truth.who)} than {near:.1f} m" if near > TOGETHER else ""


def _kept(run: Run, truth: MustBe) -> str:
    """Somebody who walks about was followed for so many seconds; the first of them are for finding them."""
    begun = run.evidence.start.t
    samples = [s for s in run.evidence.samples if FIND_S <= s.t - begun <= truth.count]
    if not samples or samples[-1].t - begun < 0.9 * truth.count:
        return f"it was over after {run.evidence.end.t - begun:.0f} s"
    walked = sum(math.dist(run.person(truth.who, a), run.person(truth.who, b)) for a, b in pairwise(samples))
    if walked < WALKED:
        return f"{_called(run, truth.who)} walked {walked:.1f} m: the robot stood in their way"
    kept = sum(run.apart(truth.who, sample) <= NEAR for sample in samples) / len(samples)
    if kept < KEPT:
        return f"near {_called(run, truth.who)} for {100 * kept:.0f} % of the time"
    last = run.apart(truth.who, samples[-1])
    return f"{last:.1f} m from {_called(run, truth.who)} at the end" if last > NEAR else ""


def _called(run: Run, who: str) -> str:
    return run.evidence.scene.people[who].called or who


_JUDGES: Final[Mapping[Truth, Callable[[Run, MustBe], str]]] = {
    "on": _on,
    "given": _given,
    "binned": _binned,
    "put away": _put_away,
    "arrived": _arrived,
    "robot in": _robot_in,
    "found": _found,
    "accompanied": _accompanied,
    "heard": _heard,
    "found person": _found_person,
    "kept": _kept,
}
