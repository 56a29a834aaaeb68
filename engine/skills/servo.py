"""Visual servoing: driving by what the camera sees, shared by the skills that follow something.

A loop sees, works out where the target is on the map, and drives by that until the next picture, one command in every
control tick. The map frame keeps a target's place valid while base and arm move under the camera. The robot never
drives blind: without a fresh sight of the target it brakes, stands, looks around for a while, and gives up in the end.

Between two pictures the target is taken to move on as it did, so that the robot keeps up with what walks.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from engine.errors import CameraError
from engine.perception.sighting import Part, Sight
from engine.robot.arm import ArmModel, Joints
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import ZERO, Point, Pose, Twist, wrap
from engine.robot.robot import RobotState
from engine.skills.context import SkillContext
from engine.skills.drive import why_held
from engine.skills.outcome import Result, fail

PICTURE_S: Final = 0.1
"""Robot time from one picture to the next, s; longer where seeing takes longer."""
FRESH_S: Final = 0.25
"""s after which a sight is too old to drive by."""
WHOLE_S: Final = 0.5
"""Robot time after which a picture is understood as a whole again, for the memory and for landmarks, s; pictures in
between are only searched for what is followed."""
LOST_S: Final = 5.0
"""s without a sight of the target after which it is given up."""

_SPEED = 0.6  # m/s towards the target
_BACKWARD = 0.25  # m/s away from it: the camera looks the other way
_TURN = 1.6  # rad/s
_SEARCH_TURN = 0.8  # rad/s
_ACCELERATION = 0.9  # m/s²; less than the envelope allows, so that the arm does not swing
_TURN_ACCELERATION = 4.0  # rad/s²
_BRAKING = 0.6  # m/s² counted on before the distance to keep
_GAIN = 1.8  # 1/s, of distance
_TURN_GAIN = 2.5  # 1/s
_KEPT = 0.03  # m off the distance to keep that do not matter
_FACED = 0.04  # rad
_STEERED = 0.9  # rad of bearing beyond which it turns before it goes
_STILL = 0.06  # m/s; a slower target stands, and the rest is noise

_FOLD = (-1.1, 1.85)
"""rad, shoulder and elbow of the folded arm: the camera stays above the hull wherever it looks."""
_LEAP = 0.8  # m from where a target is expected; what is seen farther off is something else
_GAZE_YAW = 1.2  # rad; the base turns towards what is further aside
_GAZE_PITCHES = (1.0, 2.5)  # rad: as far up as faces of people near by … steeply down
_GAZE_SPEED = 2.0  # rad/s
_GAZED = 0.15  # rad by which the camera may look past
_SWEEP = 1.9  # rad to each side when looking around
_TRACK_YAW = 0.6  # rad that the arm alone follows a target which the base need not approach


@dataclass(frozen=True, slots=True)
class Target:
    """What is followed. ``find`` gives its place in a sight, map frame; told where it should be, if that is known. It
    runs in a thread of its own."""

    name: str  # with its article: "the red box"
    find: Callable[[Sight, Point | None], Point | None]
    parts: Collection[Part]  # of the sight that ``find`` asks for


def nearest(points: Iterable[Point], near: Point | None, sight: Sight) -> Point | None:
    """The point that continues a target last expected at ``near``; the nearest to the robot where nothing is
    expected."""
    x, y = near[:2] if near is not None else (sight.picture.pose.x, sight.picture.pose.y)
    best = min(points, key=lambda point: math.dist(point[:2], (x, y)), default=None)
    if best is None or (near is not None and math.dist(best[:2], (x, y)) > _LEAP):
        return None
    return best


def tag_finder(number: int | None, floor: FloorMap) -> Callable[[Sight, Point | None], Point | None]:
    """Finds the tag of this number; with None, any that is not fixed to the house."""
    fixed = {landmark.id for landmark in floor.tags}

    def find(sight: Sight, near: Point | None) -> Point | None:
        fitting = (tag for tag in sight.tags if (tag.id == number if number is not None else tag.id not in fixed))
        return nearest((tag.position for tag in fitting), near, sight)

    return find


class Track:
    """Where a target is and how it moves, smoothed over its sightings (an alpha-beta filter)."""

    _PLACE, _MOTION = 0.6, 0.25  # parts of a surprise that go into place and velocity
    _JUMP = 0.6  # m; whoever jumps so far is somewhere else, and its motion is not known

    def __init__(self, t: float, point: Point) -> None:
        self.t = t  # robot time of the last sighting, s
        self.vx, self.vy = 0.0, 0.0  # m/s, map frame
        self._point = point

    def at(self, t: float) -> Point:
        """Where it should be at ``t``, not far from the last sighting, map frame, m."""
        x, y, z = self._point
        ahead = min(t - self.t, FRESH_S)
        return x + self.vx * ahead, y + self.vy * ahead, z

    def update(self, t: float, point: Point) -> None:
        """It was seen there."""
        x, y, z = self.at(t)
        dt, off = t - self.t, (point[0] - x, point[1] - y)
        if dt <= 0 or dt > 2 * FRESH_S or math.hypot(*off) > self._JUMP:
            self._point, self.vx, self.vy = point, 0.0, 0.0
        else:
            self._point = x + self._PLACE * off[0], y + self._PLACE * off[1], z + self._PLACE * (point[2] - z)
            self.vx += self._MOTION / dt * off[0]
            self.vy += self._MOTION / dt * off[1]
        self.t = max(t, self.t)


class Wheels:
    """Drives with smooth accelerations: one call of :meth:`go` in every tick."""

    def __init__(self, context: SkillContext) -> None:
        self._context = context
        self._sent = ZERO
        self._t = context.robot.state().t

    async def go(self, twist: Twist) -> RobotState:
        """Command a step towards ``twist`` and wait for the next tick."""
        now = self._context.robot.state().t
        dt = min(max(now - self._t, 0.0), 0.1) or 0.02
        self._t = now
        self._sent = _ramp(self._sent, twist, dt)
        self._context.drive(self._sent)
        return await self._context.robot.tick()

    async def stand(self) -> RobotState:
        """Brake gently until the base is at rest."""
        state = await self.go(ZERO)
        end = state.t + 2.0
        while (state.moving or not self._sent.is_zero) and state.t < end:
            state = await self.go(ZERO)
        return state


def _ramp(now: Twist, wanted: Twist, dt: float) -> Twist:
    dx, dy, dw = wanted.vx - now.vx, wanted.vy - now.vy, wanted.wz - now.wz
    part = min(1.0, _ACCELERATION * dt / max(math.hypot(dx, dy), 1e-9))
    turn = min(1.0, _TURN_ACCELERATION * dt / max(abs(dw), 1e-9))
    return Twist(now.vx + part * dx, now.vy + part * dy, now.wz + turn * dw)


def gaze(arm: ArmModel, point: Point) -> Joints:
    """The joints of the folded arm that turn the camera to ``point`` (base frame, m), as far as it goes."""
    shoulder, elbow = _FOLD
    yaw = math.atan2(point[1] - arm.shoulder[1], point[0] - arm.shoulder[0])
    yaw = max(-_GAZE_YAW, min(_GAZE_YAW, yaw))
    pitch = 1.8
    for _ in range(3):  # the camera moves a little when the wrist bends
        x, y, z = arm.camera((yaw, shoulder, elbow, pitch - shoulder - elbow, 0.0)).position
        pitch = math.pi / 2 + math.atan2(z - point[2], max(math.hypot(point[0] - x, point[1] - y), 0.05))
        pitch = max(_GAZE_PITCHES[0], min(_GAZE_PITCHES[1], pitch))
    return yaw, shoulder, elbow, pitch - shoulder - elbow, 0.0


def look_towards(context: SkillContext, point: Point) -> None:
    """Begin to turn the camera to ``point`` (map frame, m); the base stays as it is."""
    context.robot.move_arm(_gaze_at(context, point), context.epoch, speed=_GAZE_SPEED)


def is_gazed_at(context: SkillContext, point: Point) -> bool:
    """Whether the camera is turned to ``point`` (map frame, m)."""
    pose, joints = context.pose, context.robot.state().joints
    bearing = wrap(math.atan2(point[1] - pose.y, point[0] - pose.x) - pose.yaw)
    return abs(bearing) < _GAZE_YAW and abs(joints[0] - _gaze_at(context, point)[0]) < _GAZED


def _gaze_at(context: SkillContext, point: Point) -> Joints:
    pose = context.pose
    dx, dy = point[0] - pose.x, point[1] - pose.y
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return gaze(context.robot.arm, (c * dx + s * dy, c * dy - s * dx, point[2]))


async def follow(context: SkillContext, target: Target, *, keep: float | None) -> Result:
    """Follow ``target`` at a distance of ``keep`` m from the robot's centre, until interrupted; None: only look at it,
    with arm and base turning. Ends by itself with ``target_lost`` (``object_not_found`` when it was never seen) or
    when the robot halts. Raises ``CameraError``."""
    before = context.robot.state().joint_targets
    try:
        result = await _Pursuit(context, target, keep).run()
    except CameraError:
        context.drive(ZERO)
        raise
    context.robot.move_arm(before, context.epoch, speed=1.0)
    return result


class _Pursuit:
    """One run of :func:`follow`."""

    def __init__(self, context: SkillContext, target: Target, keep: float | None) -> None:
        self._context = context
        self._target = target
        self._keep = keep
        self._wheels = Wheels(context)
        self._track: Track | None = None
        self._begin = context.robot.state()
        self._stood_s = self._begin.paused_s  # when the target was last seen
        self._whole_at = -math.inf

    async def run(self) -> Result:
        while True:
            sight = await self._see()
            await self._take_in(sight)
            state = self._context.robot.state()
            if state.t - self._seen_at - (state.paused_s - self._stood_s) > LOST_S:
                return self._give_up(await self._wheels.stand())
            self._report(state)
            while state.t < sight.t + PICTURE_S - 1e-6 or state.t == sight.t:
                state = await self._wheels.go(self._twist(state))
                if state.halted:
                    code, reason = why_held(state)
                    return fail(code, f"I stopped following {self._target.name}: {reason}.")

    async def _see(self) -> Sight:
        """The newest picture, understood as far as it is needed."""
        if self._context.robot.state().t < self._whole_at + WHOLE_S - 1e-6:
            return await self._context.see(self._target.parts)
        sight = await self._context.see()
        self._whole_at = sight.t
        return sight

    @property
    def _seen_at(self) -> float:
        return self._track.t if self._track is not None else self._begin.t

    async def _take_in(self, sight: Sight) -> None:
        """What the newest picture says about the target, and where the camera shall look next."""
        track = self._track
        near = track.at(sight.t) if track is not None and sight.t - track.t < 4 * FRESH_S else None
        point = await asyncio.to_thread(self._target.find, sight, near)
        if point is not None:
            self._stood_s = self._context.robot.state().paused_s
        if point is not None and track is not None:
            track.update(sight.t, point)
        elif point is not None:
            self._track = Track(sight.t, point)
        if self._track is not None and sight.t - self._track.t <= FRESH_S:
            look_towards(self._context, self._track.at(sight.t + PICTURE_S))
        else:
            direction, height = self._search(sight.t)
            pose = self._context.pose
            far = (pose.x + 1.5 * math.cos(direction), pose.y + 1.5 * math.sin(direction), height)
            look_towards(self._context, far)

    def _twist(self, state: RobotState) -> Twist:
        """The velocity now."""
        track = self._track
        if track is not None and state.t - track.t <= FRESH_S:
            x, y, _ = track.at(state.t)
            if self._keep is None:
                return face(state.pose, (x, y))
            return chase(state.pose, (x, y), (track.vx, track.vy), self._keep)
        direction, _ = self._search(state.t)
        beyond = wrap(direction - state.pose.yaw)
        return Twist(wz=max(-_SEARCH_TURN, min(_SEARCH_TURN, _TURN_GAIN * beyond)))

    def _search(self, t: float) -> tuple[float, float]:
        """Where to look for what is out of sight: direction (map frame, rad) and height (m). First where it was, then
        to the side to which it went, then to the other."""
        pose, middle, side, height = self._begin.pose, self._begin.pose.yaw, 1.0, 0.0
        if self._track is not None:
            pose = self._context.pose
            x, y, height = self._track.at(t)
            middle = math.atan2(y - pose.y, x - pose.x)
            side = math.copysign(1.0, math.cos(middle) * self._track.vy - math.sin(middle) * self._track.vx)
        aside = np.interp((t - self._seen_at) / LOST_S, (0.1, 0.4, 0.5, 1.0), (0.0, _SWEEP, _SWEEP, -_SWEEP))
        return middle + side * float(aside), height

    def _report(self, state: RobotState) -> None:
        unseen = state.t - self._seen_at
        if self._track is not None and unseen <= FRESH_S:
            away = math.dist(self._track.at(state.t)[:2], (state.pose.x, state.pose.y))
            held = f"; {state.blocked}" if state.blocked else ""
            self._context.progress(None, f"{self._target.name}, {away:.2f} m away{held}")
        else:
            self._context.progress(None, f"looking for {self._target.name}, {LOST_S - unseen:.0f} s more")

    def _give_up(self, state: RobotState) -> Result:
        name, track = self._target.name, self._track
        if track is None:
            return fail("object_not_found", f"I looked around for {LOST_S:g} s and did not see {name}.")
        x, y, _ = track.at(track.t)
        ago = state.t - track.t
        where = place_of(self._context.robot.floor_map, x, y)
        message = f"I lost {name}: I last saw it {ago:.0f} s ago {where}."
        return fail("target_lost", message, x=round(x, 3), y=round(y, 3), seen_at=round(track.t, 3))


def chase(pose: Pose, spot: tuple[float, float], velocity: tuple[float, float], keep: float) -> Twist:
    """The velocity that brings the robot to ``keep`` m from ``spot`` and turns its front there; both move."""
    dx, dy = spot[0] - pose.x, spot[1] - pose.y
    away, bearing = math.hypot(dx, dy), wrap(math.atan2(dy, dx) - pose.yaw)
    wz = 0.0 if abs(bearing) < _FACED else max(-_TURN, min(_TURN, _TURN_GAIN * bearing))
    if abs(bearing) > _STEERED:
        return Twist(wz=wz)
    off = away - keep
    along = 0.0 if abs(off) < _KEPT else _GAIN * (off - math.copysign(_KEPT, off))
    along = math.copysign(min(abs(along), math.sqrt(2 * _BRAKING * abs(off))), along)
    if math.hypot(*velocity) > _STILL:
        along += (velocity[0] * dx + velocity[1] * dy) / max(away, 0.1)
    along = max(-_BACKWARD, min(_SPEED, along)) * math.cos(bearing)
    return Twist(along * math.cos(bearing), along * math.sin(bearing), wz)


def face(pose: Pose, spot: tuple[float, float]) -> Twist:
    """Turns on the spot as far as the arm alone cannot look at ``spot``."""
    bearing = wrap(math.atan2(spot[1] - pose.y, spot[0] - pose.x) - pose.yaw)
    beyond = max(0.0, abs(bearing) - _TRACK_YAW)
    return Twist(wz=math.copysign(min(_TURN, _TURN_GAIN * beyond), bearing))


def place_of(floor: FloorMap, x: float, y: float) -> str:
    """For people: ``in the kitchen, at x 1.20 m, y 3.00 m``."""
    room = next((f"in the {room.name}, " for room in floor.rooms if room.holds(x, y)), "")
    return f"{room}at x {x:.2f} m, y {y:.2f} m"
