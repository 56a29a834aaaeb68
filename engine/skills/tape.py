"""Driving along a tape on the floor.

The camera looks ahead and down. In every picture the tape is traced from where the trail ended so far, step by step, in
the direction of travel; the trail is kept on the map, so that the robot also knows the part that is under its hull. It
ends where the picture shows bare floor beyond the last step. What stands on the tape, or so near to it that the hull
would hit it, stops the robot before.
"""

from __future__ import annotations

import asyncio
import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from engine.errors import CameraError
from engine.perception.line import tape_points
from engine.perception.sighting import Colour, Sight, Sighting
from engine.robot.camera import Picture
from engine.robot.geometry import ZERO, Point, Pose, Twist, wrap
from engine.robot.robot import RobotState
from engine.skills.context import SkillContext
from engine.skills.drive import Stall, why_held
from engine.skills.outcome import ErrorCode
from engine.skills.servo import FRESH_S, LOST_S, PICTURE_S, Wheels, look_towards

Spot = tuple[float, float]
"""On the floor, map frame, m."""

STOP_BEFORE: Final = 0.42
"""m from the base's centre to a thing on the line at which the robot stops."""

_PLAIN = ("white", "grey", "black")  # half a house looks like tapes of these
_STEP = 0.04  # m from one point of the trail to the next
_BRIDGE = 0.16  # m of tape that may be hidden or worn off
_STEER = math.cos(math.radians(75))  # of the sharpest bend at one step
_TRACED = 0.8  # m around the robot in which the trail is final; farther points are traced anew in every picture
_FARTHEST = 1.4  # m; beyond, a pixel of the floor is longer than a step
_FEWEST = 8  # pixels that are a tape
_SURE = 3  # pictures that must show the end
_SPEED = 0.3  # m/s
_BRAKING = 0.5  # m/s²
_LOOKAHEAD = 0.2  # m along the trail to the point that is aimed at
_LOOK_AHEAD = 0.65  # m from the base's centre to the floor in the middle of the picture
_GLANCE_S = 0.5  # until the camera looks down
_TURN, _TURN_GAIN = 1.4, 3.0  # rad/s, 1/s
_ARRIVED = 0.02  # m
_ROOM = 0.02  # m between hull and thing that are too few


class Trail:
    """The tape as far as it has been seen: points a step apart, in the direction of travel."""

    def __init__(self, start: Spot, direction: float) -> None:
        self._points: list[Spot] = [start]
        self._directions = [direction]
        self._done = 0
        self._bare = 0
        self.ended = False
        """The last point is the end of the tape."""

    @property
    def length(self) -> float:
        """From its beginning to where the robot is, m."""
        return _length(self._points[: self._done + 1])

    @property
    def remaining(self) -> float:
        """From where the robot is to the last point that is known, m."""
        return _length(self._points[self._done :])

    @property
    def traced(self) -> float:
        """Of all of it, m."""
        return _length(self._points)

    def ahead(self) -> tuple[Spot, ...]:
        """The part before the robot."""
        return tuple(self._points[self._done :])

    def advance(self, pose: Pose) -> None:
        """The robot is at ``pose`` now; it never goes back along the trail."""
        gaps = [math.dist(point, (pose.x, pose.y)) for point in self._points[self._done : self._done + 8]]
        self._done += int(np.argmin(gaps))

    def aim(self, way: float) -> Spot:
        """The point ``way`` m further along, straight on beyond the end."""
        steps, rest = divmod(way, _STEP)
        index = self._done + int(steps)
        if index < len(self._points):
            return self._points[index]
        beyond = (index - len(self._points) + 1) * _STEP + rest
        (x, y), direction = self._points[-1], self._directions[-1]
        return x + beyond * math.cos(direction), y + beyond * math.sin(direction)

    @property
    def direction(self) -> float:
        """Of the tape where the robot is, map frame, rad."""
        return self._directions[self._done]

    @property
    def end_direction(self) -> float:
        """Of the tape at the last point that is known, map frame, rad."""
        return self._directions[-1]

    def look(self, picture: Picture, tape: NDArray[np.float64]) -> None:
        """Trace the tape onwards; ``tape`` are the points of it that the picture shows."""
        if self.ended:
            return
        here = (picture.pose.x, picture.pose.y)
        while len(self._points) > self._done + 2 and math.dist(self._points[-1], here) > _TRACED:
            self._points.pop()
            self._directions.pop()
        tape = tape[np.hypot(tape[:, 0] - here[0], tape[:, 1] - here[1]) < _FARTHEST]
        grown = self.extend(tape)
        bare = not grown and shows_floor(picture, self._beyond(0.06)) and shows_floor(picture, self._beyond(_BRIDGE))
        self._bare = self._bare + 1 if bare else 0
        self.ended = self._bare >= _SURE

    def extend(self, tape: NDArray[np.float64]) -> int:
        """Add the points that follow; how many."""
        before = len(self._points)
        while (step := self._next(tape)) is not None:
            tail = self._points[-2] if len(self._points) > 1 else self._points[-1]
            self._directions.append(math.atan2(step[1] - tail[1], step[0] - tail[0]))
            self._points.append(step)
        return len(self._points) - before

    def _next(self, tape: NDArray[np.float64]) -> Spot | None:
        (x, y), direction = self._points[-1], self._directions[-1]
        off = tape - (x, y)
        way = np.hypot(off[:, 0], off[:, 1])
        along = off @ (math.cos(direction), math.sin(direction))
        front = (along > _STEER * way) & (way > _STEP / 2)
        for reach in (1.5 * _STEP, 2.5 * _STEP, _BRIDGE):
            near = front & (way < reach)
            if np.count_nonzero(near) >= 2:
                new_x, new_y = tape[near].mean(axis=0).tolist()
                return new_x, new_y
        return None

    def _beyond(self, way: float) -> Spot:
        (x, y), direction = self._points[-1], self._directions[-1]
        return x + way * math.cos(direction), y + way * math.sin(direction)


def _length(points: list[Spot]) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(points))


def begin(tape: NDArray[np.float64], pose: Pose) -> Trail | None:
    """The trail from the tape's nearest point onwards, to the side on which more of it lies ahead of the robot."""
    if len(tape) < _FEWEST:
        return None
    off = tape - (pose.x, pose.y)
    first = tape[np.hypot(off[:, 0], off[:, 1]).argmin()]
    near = tape[np.hypot(*(tape - first).T) < 1.5 * _STEP]
    _, _, axes = np.linalg.svd(near - near.mean(axis=0))
    axis = math.atan2(axes[0, 1], axes[0, 0])
    start = (float(first[0]), float(first[1]))
    trails = []
    for direction in (axis, wrap(axis + math.pi)):
        trail = Trail(start, direction)
        trail.extend(tape)
        trails.append((trail.traced + 0.3 * math.cos(direction - pose.yaw), trail))
    return max(trails, key=lambda scored: scored[0])[1]


def shows_floor(picture: Picture, spot: Spot) -> bool:
    """Whether the picture shows the floor there: inside of it, and nothing in front."""
    [point] = points = picture.from_map(np.array([(*spot, 0.0)]))
    if math.hypot(point[0], point[1]) > _FARTHEST:
        return False
    depth = picture.mount.into(points)[0, 2]
    column, row = picture.pixels(points)[0]
    height, width = picture.depth.shape
    if not (2 <= column < width - 2 and 2 <= row < height - 2):  # also when not a number
        return False
    return abs(float(picture.depth[int(row), int(column)]) - float(depth)) < 0.03 + 0.03 * float(depth)


async def line_colour(context: SkillContext) -> Colour | None:
    """The colour of the tape of which the robot sees most; None when it sees none. Raises ``CameraError``."""
    look_towards(context, _ahead(context.pose, context.pose.yaw))
    await context.sleep(_GLANCE_S)
    picture = (await context.see()).picture
    colours: list[Colour] = [colour for colour in get_args(Colour) if colour not in _PLAIN]
    seen = {colour: len(tape_points(picture, colour)) for colour in colours}
    most = max(seen, key=lambda colour: seen[colour])
    return most if seen[most] >= _FEWEST else None


def _ahead(pose: Pose, direction: float) -> Point:
    """The floor before a robot that looks in this direction (map frame)."""
    return pose.x + _LOOK_AHEAD * math.cos(direction), pose.y + _LOOK_AHEAD * math.sin(direction), 0.0


@dataclass(frozen=True, slots=True)
class Stopped:
    """Why the robot stands."""

    why: Literal["end", "thing", "held", "lost", "unseen"]
    thing: Sighting | None = None
    error: ErrorCode | None = None  # of ``held``
    reason: str = ""


class LineDriver:
    """Drives along the tape of one colour; after a stop :meth:`run` goes on where it was."""

    def __init__(self, context: SkillContext, colour: Colour) -> None:
        self._context = context
        self._colour: Colour = colour
        self.trail: Trail | None = None

    @property
    def length(self) -> float:
        """m of the tape that it has driven along."""
        return self.trail.length if self.trail is not None else 0.0

    @property
    def direction(self) -> float:
        """Of the tape where the robot is, map frame, rad."""
        return self.trail.direction if self.trail is not None else self._context.pose.yaw

    async def run(self) -> Stopped:
        """Drive to the end, or until it can say why not. Raises ``CameraError``."""
        wheels = Wheels(self._context)
        try:
            stopped = await self._run(wheels)
        except CameraError:
            self._context.drive(ZERO)
            raise
        await wheels.stand()
        return stopped

    async def _run(self, wheels: Wheels) -> Stopped:
        context = self._context
        start = state = context.robot.state()
        look_towards(context, _ahead(start.pose, start.pose.yaw))
        while state.t < start.t + _GLANCE_S:
            state = await wheels.go(ZERO)
        moved, stall = 0.0, Stall(state.t, 0.0, 0.005)
        while True:
            sight = await context.see()
            tape = await asyncio.to_thread(tape_points, sight.picture, self._colour)
            if self.trail is None:
                self.trail = begin(tape, context.pose)
            if self.trail is None:
                if state.work_t - start.work_t > LOST_S:
                    return Stopped("unseen")
                state = await self._search(wheels, sight, start)
                continue
            trail = self.trail
            trail.advance(context.pose)
            trail.look(sight.picture, tape)
            if (thing := self._in_the_way(sight)) is not None:
                return Stopped("thing", thing)
            look_towards(context, (*trail.aim(_LOOK_AHEAD), 0.0))
            while state.t < sight.t + PICTURE_S - 1e-6 or state.t == sight.t:
                if self._passed(state.pose):
                    return Stopped("end" if trail.ended else "lost")
                before = state.pose
                state = await wheels.go(self._twist(state, sight))
                trail.advance(state.pose)
                moved += before.distance_to(state.pose) + 0.2 * abs(wrap(state.pose.yaw - before.yaw))
                if state.halted or stall.update(state.t, -moved):
                    code, reason = why_held(state)
                    return Stopped("held", error=code, reason=reason)
            self._report()

    def _passed(self, pose: Pose) -> bool:
        """Whether the base's centre is at the end of what is known of the tape, or beyond."""
        assert self.trail is not None
        (x, y), direction = self.trail.ahead()[-1], self.trail.end_direction
        return (pose.x - x) * math.cos(direction) + (pose.y - y) * math.sin(direction) > -_ARRIVED

    def _twist(self, state: RobotState, sight: Sight) -> Twist:
        """The velocity now: towards a point a little ahead on the trail, the front along it."""
        assert self.trail is not None
        if state.t - sight.t > FRESH_S:
            return ZERO
        pose = state.pose
        x, y = self.trail.aim(_LOOKAHEAD)
        bearing = wrap(math.atan2(y - pose.y, x - pose.x) - pose.yaw)
        wz = max(-_TURN, min(_TURN, _TURN_GAIN * bearing))
        along = min(_SPEED, math.sqrt(2 * _BRAKING * max(self.trail.remaining, 0.001)))
        along *= max(0.0, math.cos(bearing)) ** 2 if abs(bearing) < 1.2 else 0.0
        return Twist(along * math.cos(bearing), along * math.sin(bearing), wz)

    def _in_the_way(self, sight: Sight) -> Sighting | None:
        """The nearest thing that the hull would soon hit."""
        assert self.trail is not None
        pose, hull = sight.picture.pose, self._context.robot.footprint
        way = np.array([*self.trail.ahead(), *(self.trail.aim(self.trail.remaining + 0.04 * n) for n in range(4))])
        for thing in sight.objects:
            x, y, _ = thing.position
            if thing.surface > 0.05 or math.hypot(x - pose.x, y - pose.y) > STOP_BEFORE + thing.size[0] / 2:
                continue
            gap = float(np.hypot(way[:, 0] - x, way[:, 1] - y).min())
            if gap < hull.width / 2 + thing.size[0] / 2 + _ROOM:
                return thing
        return None

    async def _search(self, wheels: Wheels, sight: Sight, start: RobotState) -> RobotState:
        """Look around for the tape until the next picture."""
        state = self._context.robot.state()
        aside = np.interp((state.t - start.t) / LOST_S, (0.1, 0.4, 0.5, 1.0), (0.0, 1.6, 1.6, -1.6))
        direction = start.pose.yaw + float(aside)
        look_towards(self._context, _ahead(start.pose, direction))
        self._context.progress(None, f"looking for a {self._colour} line")
        while state.t < sight.t + PICTURE_S - 1e-6 or state.t == sight.t:
            wz = max(-0.8, min(0.8, 2 * wrap(direction - state.pose.yaw)))
            state = await wheels.go(Twist(wz=wz))
        return state

    def _report(self) -> None:
        assert self.trail is not None
        fraction = self.length / (self.length + self.trail.remaining) if self.trail.ended else None
        self._context.progress(fraction, f"{self.length:.1f} m of the {self._colour} line", path=self.trail.ahead())
