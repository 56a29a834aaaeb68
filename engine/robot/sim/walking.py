"""How the people of a scene walk: round their path, behind the robot, ahead of it, or out of its way.

Each of these says at every moment to which point somebody walks now, and how fast; :mod:`engine.robot.sim.person` moves
them there. Nobody walks through a wall: a path and a way ahead are those of the scene, and who follows walks where the
robot has been, or straight where nothing stands.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from itertools import pairwise
from typing import Final, NamedTuple, Protocol

from engine.robot.geometry import Pose, wrap
from engine.robot.sim.free_floor import FreeFloor, ahead, direction
from engine.robot.sim.scene_parts import Person, Point

BERTH: Final = 0.5
"""How near to the robot's middle somebody walks on, m."""
BEHIND: Final = 1.0
"""m between the robot and who follows it."""
FOLLOW_SPEED: Final = 0.8
"""m/s at most."""
WAITS_AT: Final = 2.0
"""m behind which the robot is waited for by who walks ahead of it."""
ASIDE: Final = 0.6
"""m that somebody steps out of the way."""

_ARRIVED = 0.05  # m from a point of a path
_AHEAD = math.radians(75)  # to either side: where somebody looks while walking
_CRUMB, _CRUMBS = 0.1, 1000  # m between points of the trail, and how many of them are kept
_JUMP = 0.5  # m that no robot drives in a step: it was put somewhere else
_SHORT_CUT, _SHORT_CUT_S, _WIDE = 2.0, 0.4, 0.3  # m, s between two looks for one, m of room that it needs
_NARROW = 0.1  # m of room that somebody needs at least
_FEW = 40  # points of the trail that are looked at for a short cut
_ASIDE_SPEED = 0.5  # m/s
_PASSED = 1.3  # m from the robot at which it has passed
_GOES_ROUND_S = 3.0  # that somebody waits for a robot in the way before they go round it
_PATIENCE_S = 12.0  # that who has stepped aside waits for it


class Walk(NamedTuple):
    """What somebody does with their legs now."""

    to: Point
    speed: float  # m/s
    sideways: bool = False  # without turning there


class Way(Protocol):
    """Where somebody walks."""

    def next(self, here: Pose, robot: Pose, t: float) -> Walk | None:
        """What to do now; None is to stand. ``t`` is robot time, s."""
        ...


class Rounds:
    """Round the points of a path for ever."""

    def __init__(self, person: Person) -> None:
        self._path, self._speed = person.path, person.speed
        self._towards = 1 % len(self._path)

    def rejoin(self, here: Point) -> bool:
        """Go on from somewhere on the path; False where that is not on it."""
        path = self._path
        detours = [
            math.dist(before, here) + math.dist(here, end) - math.dist(before, end)
            for before, end in pairwise((path[-1], *path))
        ]
        self._towards = detours.index(min(detours))
        return min(detours) < 0.1

    def next(self, here: Pose, robot: Pose, t: float) -> Walk | None:
        if len(self._path) == 1 or self._speed == 0 or in_the_way(here, robot):
            return None
        if math.dist((here.x, here.y), self._path[self._towards]) < _ARRIVED:
            self._towards = (self._towards + 1) % len(self._path)
        return Walk(self._path[self._towards], self._speed)


class Trail:
    """Where the robot has been, as points 0.1 m apart, the newest last; each has a number that stays."""

    def __init__(self) -> None:
        self._points: deque[Point] = deque(maxlen=_CRUMBS)
        self._end = 0  # the number of the next one
        self._last: Point | None = None

    @property
    def end(self) -> int:
        """One more than the number of the newest point."""
        return self._end

    @property
    def begin(self) -> int:
        """The number of the oldest point that is kept."""
        return self._end - len(self._points)

    def add(self, here: Point) -> None:
        """The robot is here now."""
        if self._last is not None:
            way = math.hypot(here[0] - self._last[0], here[1] - self._last[1])
            if way < _CRUMB:
                return
            if way > _JUMP:
                self._points.clear()
        self._points.append(here)
        self._last, self._end = here, self._end + 1

    def __getitem__(self, number: int) -> Point:
        return self._points[number - self.begin]


class Following:
    """Behind the robot, on its trail."""

    def __init__(self, trail: Trail, floor: FreeFloor) -> None:
        self._trail, self._floor = trail, floor
        self._next: int | None = None  # the number of the point of the trail that is walked to; None: none can be
        self._looked = -math.inf

    def next(self, here: Pose, robot: Pose, t: float) -> Walk | None:
        trail, at = self._trail, (here.x, here.y)
        if t - self._looked > _SHORT_CUT_S or (self._next is not None and self._next < trail.begin):
            self._looked = t
            self._next = self._farthest(at)
        if self._next is None or in_the_way(here, robot):
            return None
        while self._next < trail.end and math.dist(at, trail[self._next]) < 1.5 * _CRUMB:
            self._next += 1
        apart = math.dist(at, (robot.x, robot.y))
        if apart <= BEHIND or self._next >= trail.end:
            return None
        way = math.dist(at, trail[self._next]) + _CRUMB * (trail.end - self._next)
        return Walk(trail[self._next], min(FOLLOW_SPEED, max(0.1, 1.5 * (max(apart, way) - BEHIND))))

    def _farthest(self, at: Point) -> int | None:
        """The newest point of the trail that can be walked to straight: near by, or farther in the beginning."""
        trail, chosen = self._trail, self._next
        if chosen is not None and chosen >= trail.begin:
            ahead_of = range(chosen + 1, min(chosen + _FEW, trail.end))
            reached = self._reached(at, ahead_of, _SHORT_CUT, _WIDE)
            return reached[-1] if reached else chosen
        recent = range(max(trail.begin, trail.end - 4 * _FEW), trail.end)
        reached = self._reached(at, recent, 2 * _SHORT_CUT, _WIDE) or self._reached(at, recent, math.inf, _NARROW)
        return reached[-1] if reached else None

    def _reached(self, at: Point, numbers: range, within: float, margin: float) -> list[int]:
        near = [number for number in numbers if math.dist(at, self._trail[number]) < within]
        free = self._floor.can_walk(at, [self._trail[number] for number in near], margin) if near else ()
        return [number for number, is_free in zip(near, free, strict=True) if is_free]


class Leading:
    """Along some points, once, waiting for a robot that stays behind, and round one that stays in the way."""

    def __init__(self, points: Sequence[Point], speed: float, floor: FreeFloor) -> None:
        self._points, self._speed, self._floor = deque(points), speed, floor
        self._stopped_t = math.inf  # since when the robot is in the way
        self._round: SteppingAside | None = None

    @property
    def ended(self) -> bool:
        return not self._points

    def next(self, here: Pose, robot: Pose, t: float) -> Walk | None:
        at = (here.x, here.y)
        if self._points and math.dist(at, self._points[0]) < _ARRIVED:
            self._points.popleft()
        if not self._points or math.dist(at, (robot.x, robot.y)) > WAITS_AT:
            return None
        if self._round is not None and (step := self._round.next(here, robot, t)) is not None:
            return step
        self._round = None
        if not in_the_way(here, robot):
            self._stopped_t = math.inf
            return Walk(self._points[0], self._speed)
        self._stopped_t = min(self._stopped_t, t)
        if t - self._stopped_t > _GOES_ROUND_S:
            self._round, self._stopped_t = SteppingAside(here, robot, self._floor, t), math.inf
        return None


class SteppingAside:
    """To the side that is free, and on with what they did before once the robot has passed."""

    def __init__(self, here: Pose, robot: Pose, floor: FreeFloor, t: float) -> None:
        at, line = (here.x, here.y), direction((robot.x, robot.y), (here.x, here.y))
        ends = {side: ahead(at, line + side, ASIDE) for side in (math.pi / 2, -math.pi / 2)}
        is_free = floor.can_walk(at, list(ends.values()), 0.25)
        free = [side for side, can in zip(ends, is_free, strict=True) if can]
        # The robot wants to go on ahead: who already stands a little to one side of that goes to this side.
        off = wrap(line - robot.yaw)
        free.sort(key=lambda side: side * off < 0)
        self.to = ends[free[0]] if free else None
        self._until = t + _PATIENCE_S
        self._nearest = math.inf

    def next(self, here: Pose, robot: Pose, t: float) -> Walk | None:
        if self.to is None or math.dist((here.x, here.y), self.to) < 0.02:
            return None
        return Walk(self.to, _ASIDE_SPEED, sideways=True)

    def passed(self, here: Pose, robot: Pose, t: float) -> bool:
        """Whether the robot is past, or seems not to come."""
        apart = here.distance_to(robot)
        self._nearest = min(self._nearest, apart)
        behind = abs(wrap(direction((robot.x, robot.y), (here.x, here.y)) - robot.yaw)) > math.pi / 2
        return t > self._until or (behind and apart > max(_PASSED, self._nearest + 0.3))


def in_the_way(here: Pose, robot: Pose) -> bool:
    """Whether the robot is right before somebody."""
    there = (robot.x, robot.y)
    near = abs(here.x - robot.x) < BERTH and abs(here.y - robot.y) < BERTH
    return (
        near and here.distance_to(robot) < BERTH and abs(wrap(direction((here.x, here.y), there) - here.yaw)) < _AHEAD
    )
