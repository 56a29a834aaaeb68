"""Whether a task was done, judged from physics: where everything is and was, which no skill can see.

A task lists conditions; each is a function here that finds fault with the :class:`Evidence` of a run, in words, or
finds none. The outcome that the robot reported is evidence like any other: where a task cannot be done, telling the
truth about it is what is asked for.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from config.schema import Place
from engine.robot.geometry import Pose, wrap
from engine.robot.sim.build import build
from engine.robot.sim.scene import Scene

MOVED = 0.06
"""A thing that lies further than this from where it was has been moved, m."""
LEVEL = 0.025
"""Tolerance of heights, m."""
_PALM = 0.08  # m around the middle of the grip


class Mistaken(ValueError):
    """A condition that cannot be judged: it names what is not there."""


@dataclass(frozen=True, slots=True)
class Sample:
    """The truth at one moment."""

    t: float  # robot time, s
    pose: Pose
    joints: tuple[float, ...]  # of the arm, rad
    qpos: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Done:
    """One action as it was reported."""

    name: str
    outcome: str
    error_code: str | None
    data: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Evidence:
    """All that is known of a run. The first sample is its beginning, the last its end, with everything at rest."""

    scene: Scene
    places: Mapping[str, Place]
    samples: Sequence[Sample]
    actions: Sequence[Done]
    result: str  # done, failed, clarify, … (the kind of the turn's result), or time limit
    words: str  # what the robot answered

    @cached_property
    def model(self) -> Any:
        return build(self.scene, pictures=False)

    @cached_property
    def data(self) -> Any:
        return mujoco.MjData(self.model)

    @property
    def start(self) -> Sample:
        return self.samples[0]

    @property
    def end(self) -> Sample:
        return self.samples[-1]

    def at(self, name: str, sample: Sample | None = None) -> tuple[float, float, float]:
        """Where a thing was, the middle of its bottom as it was built, or a person (on the floor); at the end without
        a sample."""
        qpos = (sample or self.end).qpos
        if name in self.scene.people:
            x, y = (float(qpos[self.model.joint(f"{name} {axis}").qposadr[0]]) for axis in "xy")
            return x, y, 0.0
        if name not in self.scene.objects:
            raise Mistaken(f"there is no thing called {name!r}")
        first = self.model.joint(name).qposadr[0]
        x, y, z = (float(v) for v in qpos[first : first + 3])
        return x, y, z

    def middle(self, name: str) -> tuple[float, float, float]:
        """Where the middle of a thing is at the end, however it lies."""
        if name not in self.scene.objects:
            raise Mistaken(f"there is no thing called {name!r}")
        x, y, z = self._posed(self.end).geom(name).xpos.tolist()
        return x, y, z

    def lowest(self, name: str) -> float:
        """Height of its lowest point at the end, m."""
        return self.middle(name)[2] - self._half_height(name)

    def highest(self, name: str) -> float:
        """Height of its highest point at the end, m."""
        return self.middle(name)[2] + self._half_height(name)

    def grip(self) -> tuple[float, float, float]:
        """The middle between the fingertips at the end, map frame."""
        x, y, z = self._posed(self.end).site("grip").xpos.tolist()
        return x, y, z

    def hull_contacts(self, sample: Sample) -> frozenset[str]:
        """What the hull touched, by name of the body."""
        data = self._posed(sample)
        mujoco.mj_collision(self.model, data)
        hull = self.model.geom("hull").id
        found = set()
        for contact in data.contact:
            if hull in contact.geom and contact.dist < 0:
                other = int(contact.geom[0] if contact.geom[1] == hull else contact.geom[1])
                found.add(self.model.body(int(self.model.geom_bodyid[other])).name)
        return frozenset(found - {"world"})

    def place(self, name: str) -> Pose:
        """A place by its name, or ``start``."""
        if name == "start":
            return self.start.pose
        for place in self.places.values():
            if name in (place.name, *place.aliases):
                return Pose(place.position.x, place.position.y, place.orientation.yaw)
        raise Mistaken(f"there is no place called {name!r}")

    def _posed(self, sample: Sample) -> Any:
        self.data.qpos[:] = sample.qpos[: self.model.nq]
        mujoco.mj_kinematics(self.model, self.data)
        return self.data

    def _half_height(self, name: str) -> float:
        """Half of the extent along the vertical of its main geom, as it lies at the end."""
        data = self._posed(self.end)
        geom = self.model.geom(name)
        up = data.geom(name).xmat.reshape(3, 3)[2]
        size = geom.size
        match int(geom.type[0]):
            case mujoco.mjtGeom.mjGEOM_SPHERE:
                return float(size[0])
            case mujoco.mjtGeom.mjGEOM_CYLINDER:
                return float(size[1] * abs(up[2]) + size[0] * math.sqrt(max(0.0, 1 - up[2] ** 2)))
            case _:
                return float(np.abs(up) @ size)


Condition = Callable[..., str | None]
CONDITIONS: dict[str, Condition] = {}


def condition(function: Condition) -> Condition:
    """Make a function usable in ``tasks.yaml`` under its name."""
    CONDITIONS[function.__name__] = function
    return function


def faults(conditions: Sequence[Mapping[str, Any]], evidence: Evidence) -> tuple[str, ...]:
    """What is wrong, one sentence a condition that does not hold. Each condition is ``{NAME: ARGUMENTS}``.

    Raises :class:`Mistaken` for a condition that does not exist or names what is not there.
    """
    found = []
    for entry in conditions:
        for name, arguments in entry.items():
            if name not in CONDITIONS:
                raise Mistaken(f"there is no condition called {name!r}")
            known = arguments if isinstance(arguments, dict) else {"value": arguments}
            if fault := CONDITIONS[name](evidence, **known):
                found.append(f"{name}: {fault}")
    return tuple(found)


# Things


@condition
def in_bin(run: Evidence, value: str | list[str]) -> str | None:
    """These things are in a bin."""
    out = [name for name in _names(value) if not _binned(run, name)]
    return f"not in the bin: {', '.join(out)}" if out else None


@condition
def all_in_bin(run: Evidence, value: str) -> str | None:
    """All things of a colour (``red``), or ``everything``, are in a bin."""
    meant = [name for name, loose in run.scene.objects.items() if value in ("everything", loose.colour)]
    if not meant:
        raise Mistaken(f"there is nothing {value} in {run.scene.name}")
    return in_bin(run, meant)


@condition
def none_in_bin(run: Evidence, value: str) -> str | None:
    """No thing but those of this colour is in a bin."""
    wrong = [name for name, loose in run.scene.objects.items() if loose.colour != value and _binned(run, name)]
    return f"in the bin too: {', '.join(wrong)}" if wrong else None


@condition
def lies_on(run: Evidence, thing: str, furniture: str) -> str | None:
    """A thing lies or stands on a piece of furniture."""
    if furniture not in run.scene.furniture:
        raise Mistaken(f"there is no piece of furniture called {furniture!r}")
    piece = run.scene.furniture[furniture]
    x, y, _ = run.middle(thing)
    height = run.lowest(thing)
    if not _within((x, y), piece.area):
        return f"the {thing} is at ({x:.2f}, {y:.2f}), not on the {furniture}"
    if abs(height - piece.size[2]) > LEVEL:
        return f"the {thing} is {height:.2f} m above the floor, the {furniture} {piece.size[2]:.2f} m"
    return None


@condition
def on_floor(run: Evidence, value: str | list[str]) -> str | None:
    """These things lie on the floor."""
    high = [f"{name} ({run.lowest(name):.2f} m)" for name in _names(value) if run.lowest(name) > LEVEL]
    return f"above the floor: {', '.join(high)}" if high else None


@condition
def in_room(run: Evidence, thing: str, room: str) -> str | None:
    """A thing is in a room."""
    x, y, _ = run.middle(thing)
    if room not in run.scene.rooms:
        raise Mistaken(f"there is no room called {room!r}")
    return None if run.scene.rooms[room].contains(x, y) else f"the {thing} is at ({x:.2f}, {y:.2f})"


@condition
def near(run: Evidence, thing: str, place: str, within: float) -> str | None:
    """A thing is within so many metres of a place."""
    x, y, _ = run.middle(thing)
    goal = run.place(place)
    away = math.hypot(x - goal.x, y - goal.y)
    return None if away <= within else f"the {thing} is {away:.2f} m from the {place}"


@condition
def no_higher(run: Evidence, furniture: str, than: float, kind: str | None = None) -> str | None:
    """Nothing on a piece of furniture (of a kind) reaches higher than so many metres above its top."""
    piece = run.scene.furniture[furniture]
    tall = []
    for name, loose in run.scene.objects.items():
        x, y, _ = run.middle(name)
        if kind in (None, loose.kind) and _within((x, y), piece.area) and run.lowest(name) > piece.size[2] - LEVEL:
            top = run.highest(name) - piece.size[2]
            if top > than:
                tall.append(f"{name} ({100 * top:.1f} cm)")
    return f"still higher than {100 * than:g} cm: {', '.join(tall)}" if tall else None


@condition
def untouched(run: Evidence, but: Sequence[str] = ()) -> str | None:
    """Everything but these things is where it was."""
    moved = []
    for name in run.scene.objects:
        away = math.dist(run.at(name, run.start), run.at(name))
        if name not in but and away > MOVED:
            moved.append(f"{name} by {away:.2f} m")
    return f"moved too: {', '.join(moved)}" if moved else None


@condition
def held(run: Evidence, value: str) -> str | None:
    """The gripper holds a thing, above whatever it stood on."""
    away = math.dist(run.middle(value), run.grip())
    return None if away < _PALM else f"the {value} is {away:.2f} m from the fingertips"


@condition
def aside(run: Evidence, things: Sequence[str], line: str, within: float) -> str | None:
    """No one of these things lies on a line of the floor, or nearer to it than so many metres."""
    points = run.scene.lines[line].points
    for name in things:
        x, y, _ = run.middle(name)
        away = min(_from_stretch((x, y), a, b) for a, b in pairwise(points))
        if away < within and not _binned(run, name):
            return f"the {name} is {away:.2f} m from the {line}"
    return None


# The robot


@condition
def robot_at(run: Evidence, place: str, within: float = 0.2, turned: float | None = None) -> str | None:
    """The robot stands within so many metres (and degrees) of a place; ``start`` is where it began."""
    goal, here = run.place(place), run.end.pose
    if (away := here.distance_to(goal)) > within:
        return f"{away:.2f} m from the {place}"
    if turned is not None and abs(off := math.degrees(wrap(here.yaw - goal.yaw))) > turned:
        return f"turned by {off:.0f}° at the {place}"
    return None


@condition
def robot_not_in(run: Evidence, value: str) -> str | None:
    """The robot has never been in a room: there was no way."""
    room = run.scene.rooms[value]
    return f"was in the {value}" if any(room.contains(s.pose.x, s.pose.y) for s in run.samples) else None


@condition
def robot_near(run: Evidence, thing: str, within: float) -> str | None:
    """The robot's middle is within so many metres of a thing at the end."""
    x, y, _ = run.at(thing)
    away = math.hypot(x - run.end.pose.x, y - run.end.pose.y)
    return None if away <= within else f"{away:.2f} m from the {thing}"


@condition
def stood_near(run: Evidence, thing: str, within: float, seconds: float) -> str | None:
    """At some time the robot stood still near a thing for so many seconds."""
    since: Sample | None = None
    longest = 0.0
    for sample in run.samples:
        x, y, _ = run.at(thing, sample)
        close = math.hypot(x - sample.pose.x, y - sample.pose.y) <= within
        if not close:
            since = None
        elif since is None or sample.pose.distance_to(since.pose) > 0.03:
            since = sample
        else:
            longest = max(longest, sample.t - since.t)
    return None if longest >= seconds else f"stood near the {thing} for {longest:.1f} s"


@condition
def followed(run: Evidence, target: str, within: float, part: float, way: float = 1.0) -> str | None:
    """For such a part of the time the robot was within so many metres of somebody who walked; and it drove."""
    near_by = 0
    for sample in run.samples:
        x, y, _ = run.at(target, sample)
        near_by += math.hypot(x - sample.pose.x, y - sample.pose.y) <= within
    kept = near_by / len(run.samples)
    if kept < part:
        return f"near the {target} for {100 * kept:.0f} % of the time"
    driven = sum(a.pose.distance_to(b.pose) for a, b in pairwise(run.samples))
    return None if driven >= way else f"drove {driven:.1f} m"


@condition
def passed(run: Evidence, places: Sequence[str], within: float = 0.25) -> str | None:
    """The robot was at these places, in this order."""
    samples = iter(run.samples)
    for name in places:
        goal = run.place(name)
        if not any(sample.pose.distance_to(goal) <= within for sample in samples):
            return f"was not at the {name} in its turn"
    return None


@condition
def at_end_of(run: Evidence, line: str, within: float) -> str | None:
    """The robot's middle is near the last point of a line."""
    x, y = run.scene.lines[line].points[-1]
    away = math.hypot(x - run.end.pose.x, y - run.end.pose.y)
    return None if away <= within else f"{away:.2f} m from the end of the {line}"


@condition
def kept_to(run: Evidence, line: str, within: float, part: float) -> str | None:
    """For such a part of a line's length the robot's middle passed within so many metres of it."""
    points = run.scene.lines[line].points
    marks = [
        (a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1]))
        for a, b in pairwise(points)
        for f in np.linspace(0, 1, max(2, math.ceil(math.dist(a, b) / 0.1)))
    ]
    driven = np.array([(s.pose.x, s.pose.y) for s in run.samples])
    reached = sum(bool(np.hypot(*(driven - mark).T).min() <= within) for mark in marks) / len(marks)
    return None if reached >= part else f"drove along {100 * reached:.0f} % of the {line}"


@condition
def collisions(run: Evidence, value: int) -> str | None:
    """The hull touched something no more often than so many times."""
    touched: list[str] = []
    before: frozenset[str] = frozenset()
    for sample in run.samples:
        now = run.hull_contacts(sample)
        touched += sorted(now - before)
        before = now
    return None if len(touched) <= value else f"{len(touched)}: {', '.join(touched)}"


@condition
def arm_moved(run: Evidence, value: float) -> str | None:
    """Some joint of the arm was used over so many radians."""
    joints = np.array([sample.joints for sample in run.samples])
    most = float(np.ptp(joints, axis=0).max())
    return None if most >= value else f"no joint of the arm moved by more than {most:.2f} rad"


@condition
def turned(run: Evidence, value: float) -> str | None:
    """The base turned by so many degrees in all, either way."""
    pairs = pairwise(run.samples)
    total = math.degrees(sum(abs(wrap(b.pose.yaw - a.pose.yaw)) for a, b in pairs))
    return None if total >= value else f"turned by {total:.0f}°"


# What was reported


@condition
def reported(run: Evidence, value: str) -> str | None:
    """The kind of the result: ``done``, ``failed``…"""
    return None if run.result == value else f"the result is {run.result}: {run.words}"


@condition
def failed_with(run: Evidence, value: str | list[str]) -> str | None:
    """The last action failed, with one of these error codes."""
    last = run.actions[-1] if run.actions else None
    if last is None or last.outcome != "failed":
        return f"no action failed; the result is {run.result}: {run.words}"
    return None if last.error_code in _names(value) else f"the error code is {last.error_code}: {run.words}"


@condition
def says(run: Evidence, value: str) -> str | None:
    """The answer matches a pattern."""
    return None if re.search(value, run.words, re.IGNORECASE) else f"said {run.words!r}"


@condition
def located(run: Evidence, thing: str, within: float) -> str | None:
    """An action reported x and y of where the thing really is."""
    x, y, _ = run.at(thing)
    for done in run.actions:
        if "x" in done.data and "y" in done.data:
            away = math.hypot(float(done.data["x"]) - x, float(done.data["y"]) - y)
            return None if away <= within else f"told a place {away:.2f} m from the {thing}"
    return f"no action told a position: {run.words}"


def _names(value: str | list[str]) -> list[str]:
    return [value] if isinstance(value, str) else list(value)


def _binned(run: Evidence, name: str) -> bool:
    x, y, z = run.middle(name)
    return any(
        piece.kind == "bin" and _within((x, y), piece.area) and z < piece.size[2]
        for piece in run.scene.furniture.values()
    )


def _within(point: tuple[float, float], area: tuple[float, float, float, float]) -> bool:
    return area[0] <= point[0] <= area[2] and area[1] <= point[1] <= area[3]


def _from_stretch(point: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    """From a straight stretch, m."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    part = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / (dx * dx + dy * dy)
    part = min(1.0, max(0.0, part))
    return math.hypot(point[0] - a[0] - part * dx, point[1] - a[1] - part * dy)
