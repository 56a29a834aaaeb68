"""Behind one person among several.

They are known by what they wear and by where they went, from the camera; the lidar keeps hold of their legs between the
pictures. What stands in the way, on the map or not, is gone round.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import Callable
from typing import Final

import numpy as np

from engine.perception.people import PersonSeen
from engine.perception.sighting import Part, Sight, Sighting
from engine.robot.geometry import Pose, Twist
from engine.robot.occupancy import Unreachable, distances
from engine.robot.robot import RobotState
from engine.skills.context import SkillContext
from engine.skills.drive import why_held
from engine.skills.legs import Legs
from engine.skills.meeting import look_around, look_through
from engine.skills.outcome import Result, fail, ok
from engine.skills.outfit import Glimpses, Outfit, clothes_of
from engine.skills.search import nearest_place, places_in, room_at
from engine.skills.servo import PICTURE_S, WHOLE_S, Wheels, chase, face, is_gazed_at, look_towards, place_of
from engine.skills.travel import NOTHING_SEEN, SEEN_RANGE, back_off, go_to, way_to
from engine.skills.walkers import Walker

KEEP: Final = 1.2
"""m from somebody who is followed: people like it so."""
LOST_S: Final = 2.5
"""s in which the camera has not seen somebody who is followed, after which the robot looks for them."""
STOOD_S: Final = 3.0
"""s that somebody stands where they wanted to be followed to, until that counts as being there."""
_PEOPLE: Final[frozenset[Part]] = frozenset({"people"})
_SAME: Final = 1.0  # m from where somebody is expected; who is seen farther off is somebody else
_AIM: Final = 0.7  # m ahead on the way round
_ROUTE_S: Final = 0.5  # s between two looks for a way round
_HERE: Final = 0.4  # m from their legs, within which what is seen is they
_ALONE: Final = 1.0  # m around somebody in which there is nobody else
_STILL: Final = 0.15  # m/s
_UNSEEN_S: Final = 0.5  # s without the lidar, after which nobody knows whether they stand
_WAIST: Final = 0.75  # m, where the camera looks: shirt and landmarks are in the picture
_HELD_S: Final = 0.8  # s that something is in the way until the robot goes round
_ROUND_S: Final = 4.0  # s for which it does
_THEIRS: Final = 0.6  # m around somebody that the lidar sees of them
_SEARCHES: Final = 3  # times that somebody who is lost is looked for
_DOUBTS: Final = 2  # pictures that show somebody else, until it is
_GLANCES_S: Final = 8.0  # s for which everybody whom the lidar sees is looked at, one after the other
_GLANCE_S: Final = 1.5  # s at most for one of them, after the camera has turned there
_ESCAPES: Final = 3  # times that the robot backs off from what holds it where it is
_FREED: Final = 0.3  # m that it has got on, so that it is held anew
_THERE: Final = 0.3  # m from where they were seen last, from where as much shows
_NARROW: Final = 0.05  # m that the robot keeps from things on its straight way


class Pursuit:
    """Behind one person, until they have arrived where they wanted to be followed to."""

    def __init__(self, context: SkillContext, person: PersonSeen, name: str, outfit: Outfit) -> None:
        self._context = context
        self._name = name
        self._outfit = outfit
        self._legs = Legs(context.robot, person.position[:2])
        self._picture: asyncio.Task[Sight] | None = None
        self._picture_at = self._whole_at = -math.inf
        self._wheels = Wheels(context)
        self._aim: tuple[float, float] | None = None  # on the way round
        self._routed_at = -math.inf
        self._held_since, self._round_until = math.inf, -math.inf  # by something that is not on the map
        self._is_stuck = False  # held on the way round as well
        self._stuck_at: Pose | None = None
        self._escapes = 0  # from there
        self._seen_t = context.robot.state().t  # by the camera
        robot = context.robot
        self._doubts = 0  # pictures in a row in which it was somebody else
        self._glimpses = Glimpses()
        self._searching = False
        self._free = distances(robot.floor_map.occupied, robot.floor_map.resolution, 1.0)

    async def run(self, there: Callable[[tuple[float, float]], bool], stands: float = STOOD_S) -> Result:
        """``there``: whether a point is where they wanted to be followed to, once they stand there for ``stands`` s."""
        context, stood_since = self._context, math.inf
        searches = 0
        try:
            while True:
                state = context.robot.state()
                self._legs.update()
                await self._look(state, self._legs.expected)
                if state.t - self._seen_t > LOST_S:  # legs alone may be somebody else's by now
                    searches += 1
                    if searches > _SEARCHES or not await self._search():
                        return self._lost()
                    continue
                if state.t - self._seen_t < 0.3:
                    searches = 0
                here = self._legs.expected
                is_seen = self._legs.unseen_s < _UNSEEN_S
                has_arrived = there(here) and is_seen and self._legs.speed < _STILL and self._legs.away < KEEP + 0.6
                stood_since = min(stood_since, state.t) if has_arrived else math.inf
                if state.t - stood_since > stands:
                    await self._wheels.stand()
                    return ok(f"I followed {self._name}{_where(context, here)}.", x=here[0], y=here[1])
                context.progress(None, f"{self._name}, {self._legs.away:.1f} m away")
                state = await self._wheels.go(self._twist(state))
                if state.halted:
                    code, reason = why_held(state)
                    return fail(code, f"I stopped following {self._name}: {reason}.")
                if self._is_stuck and not await self._get_free(state.pose):
                    return fail("path_blocked", f"I cannot get any nearer to {self._name}: {why_held(state)[1]}.")
        finally:
            if self._picture is not None:
                self._picture.cancel()
                with contextlib.suppress(asyncio.CancelledError, Exception):
                    await self._picture

    async def _get_free(self, pose: Pose) -> bool:
        """Back off from what holds the robot; whether that is worth another try."""
        if self._stuck_at is None or pose.distance_to(self._stuck_at) > _FREED:
            self._stuck_at, self._escapes = pose, 0
        self._escapes += 1
        await self._wheels.stand()
        if self._escapes > _ESCAPES:
            return False
        await back_off(self._context)
        self._wheels, self._is_stuck = Wheels(self._context), False
        return True

    async def _look(self, state: RobotState, spot: tuple[float, float]) -> None:
        """Have a picture that shows ``spot`` understood beside the driving, and take it in when it is."""
        if self._picture is None and state.t >= self._picture_at + PICTURE_S:
            look_towards(self._context, (*spot, _WAIST))
            self._picture_at = state.t
            whole = state.t >= self._whole_at + WHOLE_S  # for landmarks, and for what lies about
            self._whole_at = state.t if whole else self._whole_at
            self._picture = asyncio.create_task(self._context.see() if whole else self._context.see(_PEOPLE))
        if self._picture is None:
            return
        if not self._picture.done():  # at full speed time stands still until somebody ticks
            await asyncio.wait([self._picture], timeout=0.02)
        if self._picture.done():
            sight, self._picture = self._picture.result(), None
            self._take_in(sight)

    def _take_in(self, sight: Sight) -> None:
        """The one who is followed among all who are seen, or nobody."""
        people, at = [p for p in sight.objects if p.kind == "person"], self._legs.expected
        self._learn(people)
        fits = self._outfit.fits_surely if self._searching else self._outfit.fits
        near = [p for p in people if fits(clothes_of(p))]
        if self._searching:
            for person in people:
                if clothes_of(person).shirt is not None:
                    self._glimpses.add((person.position[0], person.position[1]), fits=person in near)
        best = min(near, key=lambda p: math.dist(p.position[:2], at), default=None)
        if best is not None and self._is_they((best.position[0], best.position[1]), at, sight.t):
            self._seen_t, self._doubts = sight.t, 0
            self._legs.moved_to((best.position[0], best.position[1]))
        for person in people:
            if self._outfit.excludes(clothes_of(person)):
                self._exclude((person.position[0], person.position[1]))

    def _is_they(self, spot: tuple[float, float], at: tuple[float, float], t: float) -> bool:
        """Whether whoever fits is near where they should be, or, where they are looked for, fits in most pictures."""
        if math.dist(spot, at) <= _SAME + min(2.0, 1.2 * max(0.0, t - self._seen_t)):
            return True
        return self._searching and self._glimpses.tell(spot)

    def _exclude(self, at: tuple[float, float]) -> None:
        """Somebody else is there. One picture may show colours wrong: whom the lidar holds is let go after two."""
        if math.dist(at, self._legs.expected) > _HERE:
            self._legs.is_somebody_else(at)
            return
        self._doubts += 1
        if self._doubts >= _DOUBTS:
            self._legs.is_somebody_else(at)
            self._doubts = 0

    def _learn(self, people: list[Sighting]) -> None:
        """What they wear, by what is seen where their legs are while nobody else is near."""
        at, others = self._legs.expected, self._legs.others
        near = [p for p in people if math.dist(p.position[:2], at) < _ALONE]
        if len(near) != 1 or math.dist(near[0].position[:2], at) > _HERE or self._legs.unseen_s > 0.3:
            return
        if not (np.hypot(others[:, 0] - at[0], others[:, 1] - at[1]) < _ALONE).any():
            self._outfit.learn(near[0])

    def _twist(self, state: RobotState) -> Twist:
        spot = self._legs.expected
        velocity = (0.0, 0.0) if self._legs.speed < _STILL else self._legs.velocity
        self._held_since = min(self._held_since, state.t) if state.blocked else math.inf
        if state.t - self._held_since > _HELD_S:
            self._is_stuck = state.t < self._round_until
            self._round_until, self._held_since = state.t + _ROUND_S, math.inf
        obstructed = state.t < self._round_until or len(self._legs.others) > 0
        if state.t >= self._round_until and self._is_clear(state.pose, spot):
            self._aim = None
            return chase(state.pose, spot, velocity, KEEP)
        if self._aim is None or state.t > self._routed_at + _ROUTE_S:
            self._aim, self._routed_at = self._way_round(state.pose, spot, around=obstructed), state.t
        if self._aim is None or self._legs.away < KEEP:
            return chase(state.pose, spot, velocity, KEEP)
        return chase(state.pose, self._aim, (0.0, 0.0), 0.0)

    def _is_clear(self, pose: Pose, spot: tuple[float, float]) -> bool:
        """Whether the hull can go straight on until it is near enough."""
        floor, away = self._context.robot.floor_map, math.dist((pose.x, pose.y), spot)
        way = max(0.0, away - KEEP)
        steps = max(2, math.ceil(way / floor.resolution))
        part = np.linspace(0.0, way / away if away else 0.0, steps)
        xs, ys = pose.x + part * (spot[0] - pose.x), pose.y + part * (spot[1] - pose.y)
        rows, columns = self._free.shape
        row = np.clip(((ys - floor.origin[1]) / floor.resolution).astype(int), 0, rows - 1)
        column = np.clip(((xs - floor.origin[0]) / floor.resolution).astype(int), 0, columns - 1)
        clearance = self._context.robot.footprint.width / 2 + _NARROW
        if not (self._free[row[1:], column[1:]] > clearance).all():
            return False
        line = np.column_stack((xs, ys))
        others = self._legs.others
        others = others[np.hypot(others[:, 0] - pose.x, others[:, 1] - pose.y) < SEEN_RANGE]
        apart = np.hypot(*(others[:, None] - line[None]).transpose(2, 0, 1))
        return not len(others) or bool(apart.min() > clearance)

    def _way_round(self, pose: Pose, spot: tuple[float, float], *, around: bool) -> tuple[float, float] | None:
        """A point on the way there; ``around`` what the lidar sees, but for them."""
        goal = Pose(*spot, math.atan2(spot[1] - pose.y, spot[0] - pose.x))
        seen = NOTHING_SEEN
        if around:
            points = self._context.robot.scan().on_map(pose, SEEN_RANGE)
            seen = points[np.hypot(points[:, 0] - spot[0], points[:, 1] - spot[1]) > _THEIRS]
        way = way_to(self._context, goal, seen)
        if isinstance(way, Unreachable):
            return None
        left = _AIM
        for (ax, ay), (bx, by) in zip(way.points, way.points[1:], strict=False):
            length = math.dist((ax, ay), (bx, by))
            if length >= left and length > 0:
                return ax + (bx - ax) * left / length, ay + (by - ay) * left / length
            left -= length
        return way.points[-1]

    async def _search(self) -> bool:
        """Look at everybody whom the lidar sees, then go where they were last and look around; whether they are seen
        again."""
        context = self._context
        await self._wheels.stand()
        context.progress(None, f"looking for {self._name}")
        self._searching, self._glimpses = True, Glimpses()
        try:
            if await self._glance_round():
                return True
        finally:
            self._searching = False
        return await self._look_about()

    async def _glance_round(self) -> bool:
        """Turn to everybody whom the lidar sees, the likeliest first, and to where they should be; the robot stays
        where it is."""
        state = self._context.robot.state()
        end, since = state.work_t + _GLANCES_S, self._seen_t
        at_whom: Walker | None = None
        turned_t = math.inf
        while state.work_t < end:
            candidates = self._legs.candidates()
            if at_whom is None or at_whom not in candidates:
                at_whom, turned_t = next(iter(candidates), None), math.inf
            spot = at_whom.expected(state.t) if at_whom is not None else self._legs.expected
            if turned_t == math.inf and is_gazed_at(self._context, (*spot, _WAIST)):
                turned_t = state.t
            state = await self._wheels.go(face(state.pose, spot))
            if state.halted:
                return False
            self._legs.update()
            await self._look(state, spot)
            if self._seen_t > since:
                return True
            if at_whom is not None and state.t > turned_t + _GLANCE_S:  # what shows no clothes is no person
                self._legs.is_somebody_else(spot)
        return False

    async def _look_about(self) -> bool:
        """Go to where they were seen last, as more shows from there of the way they went, and look around; then through
        the room."""
        context, legs = self._context, self._legs
        await self._wheels.stand()
        began, pose, (x, y) = context.robot.state().t, context.pose, legs.at
        found: list[PersonSeen] = []

        def seen() -> bool:
            found[:] = self._outfit.worn_since(began, context.world.people.everybody)
            return bool(found)

        if math.dist((x, y), (pose.x, pose.y)) > _THERE:
            await self._go_near(x, y)
        await look_around(context, seen)
        if not found:
            await look_through(context, room_at(context.robot.floor_map, x, y), seen)
        if not found:
            return False
        person = min(found, key=lambda p: math.dist(p.position[:2], (x, y)))
        self._legs = Legs(context.robot, person.position[:2])
        self._seen_t = context.robot.state().t
        self._wheels = Wheels(context)
        return True

    async def _go_near(self, x: float, y: float) -> None:
        """To this point, or to the place nearest to it where there is room for the robot."""
        context, pose = self._context, self._context.pose
        floor, direction = context.robot.floor_map, math.atan2(y - pose.y, x - pose.x)
        went = await go_to(context, Pose(x, y, direction), "where they stayed")
        if went.error_code != "unreachable":
            return
        stands = places_in(room_at(floor, x, y), floor, context.robot.footprint, pose)
        if len(stands):
            await go_to(context, Pose(*nearest_place(stands, (x, y)), direction), "where they stayed")

    def _lost(self) -> Result:
        x, y = self._legs.at
        ago = self._context.robot.state().t - self._seen_t
        where = place_of(self._context.robot.floor_map, x, y)
        message = f"I lost {self._name}: I last saw them {ago:.0f} s ago {where}."
        return fail("target_lost", message, x=round(x, 3), y=round(y, 3))


def _where(context: SkillContext, at: tuple[float, float]) -> str:
    room = next((room.name for room in context.robot.floor_map.rooms if room.holds(*at)), "")
    return f" to the {room}" if room else ""
