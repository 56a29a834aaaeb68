"""Finding somebody, going up to them, and standing before them as people like it.

A room is looked through from where most of it shows, all the way round, with the camera level: people are tall. Whoever
was seen lately is gone to directly. The last metre is driven slowly, and the robot stays an arm's length away.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from engine.perception.people import PersonSeen
from engine.perception.someone import Someone
from engine.robot.clearance import gaps
from engine.robot.floor_map import Room
from engine.robot.geometry import Point, Pose, wrap
from engine.robot.occupancy import Unreachable
from engine.skills.approach import outlines
from engine.skills.context import SkillContext
from engine.skills.drive import turn
from engine.skills.find import NO_WAY, by_distance, furniture_called
from engine.skills.hand import move_to
from engine.skills.outcome import Result, fail, ok
from engine.skills.search import nearest_place, places_in, room_at
from engine.skills.servo import gaze
from engine.skills.strewn import seen_from
from engine.skills.travel import go_to, way_to

APART: Final = 1.1
"""m from the robot's centre to the middle of somebody whom it talks with."""
NEARER: Final = 0.62
"""m where something is handed over."""
CALM: Final = 0.3
"""m/s on the last metre: whoever does not see the robot come must not be startled."""
FRESH_S: Final = 20.0
"""Somebody who was seen within this time is where they were, or near it."""
AT: Final = 1.8
"""m from a place within which somebody is at it."""
BY: Final = 1.4
"""m from the edge of a piece of furniture within which somebody is at it."""
_SIDES: Final = (0.0, 1.0, -1.0)
"""rad by which the arm turns the camera when it looks around."""
_LEVEL: Final = (2.0, 0.9)
"""m ahead and up, where the camera looks then."""
_CHEST: Final = 1.0  # m, where to look to see what somebody wears
_SEATED: Final = 0.8  # m, the same of one who sits
_TIMES, _BETWEEN_S = 4, 0.35  # looks at one person, and s between them, to see whether an arm moves
_ONE: Final = 0.6  # m within which two sightings are one person
_TURN: Final = 1.2  # rad/s
_STEPS: Final = 16  # directions around somebody that are tried
_MARGIN: Final = 0.1  # m that the hull keeps from things
_FAR: Final = 4.5  # m from one place to look from to the next

Seen = Callable[[PersonSeen], bool]


def fits(context: SkillContext, who: Someone) -> Seen:
    """Whether somebody seen is whom these words mean."""
    people = context.people

    def fit(person: PersonSeen) -> bool:
        return person.fits(who, people.about(person.name).gender if person.name else None)

    return fit


def may_be(context: SkillContext, who: Someone) -> Seen:
    """The same, but a name may be that of anybody who has none yet, does not look like somebody else, and has not said
    that they are."""
    looks = context.people.about(who.name)

    def fit(person: PersonSeen) -> bool:
        if not who.name:
            return fits(context, who)(person)
        unlike = looks.shirt not in (None, person.shirt) or looks.trousers not in (None, person.trousers)
        unlike = unlike or context.world.people.has_denied(person.number, who.name)
        return person.name == who.name or (person.name is None and not unlike)

    return fit


def seen_now(context: SkillContext, wanted: Seen, within: Callable[[PersonSeen], bool]) -> PersonSeen | None:
    """The nearest of those who are wanted, were seen just now, and are where they are to be."""
    now, pose = context.robot.state().t, context.pose
    here = [p for p in context.world.people.everybody if now - p.seen_at < FRESH_S and wanted(p) and within(p)]
    return min(here, key=lambda p: math.dist(p.position[:2], (pose.x, pose.y)), default=None)


async def look_around(
    context: SkillContext, found: Callable[[], bool] = lambda: False, *, gestures: bool = False
) -> Result | None:
    """Look all the way round with the camera level, until ``found()``; what kept it from that. ``gestures``: watch
    everybody who is seen for a while before that is asked, to tell what they do with their arms: in one picture that
    cuts off their head, the shoulder of an arm that hangs looks like one that is up."""
    watched: list[tuple[float, float]] = []
    if gestures:
        context.world.people.forget_gestures()  # as they were seen in passing
    for half in range(2):
        if half:
            turned = await turn(context, math.pi, _TURN)
            if turned.error:
                return fail(turned.error, f"I could not turn around: {turned.reason}.")
        for side in _SIDES:
            point = (_LEVEL[0] * math.cos(side), _LEVEL[0] * math.sin(side), _LEVEL[1])
            if not await move_to(context, gaze(context.robot.arm, point), speed=2.0):
                return fail("no_progress", "The arm stopped on the way to its looking pose.")
            began = context.robot.state().t
            await context.see()
            if not gestures and found():
                return None
            for person in context.world.people.everybody if gestures else ():
                x, y, _ = person.position
                if person.seen_at < began or any(math.dist((x, y), at) < _ONE for at in watched):
                    continue
                watched.append((x, y))
                await _watch(context, person)
            if gestures and found():
                return None
    return None


async def _watch(context: SkillContext, person: PersonSeen) -> None:
    """Look at the arms of somebody several times: one that moves waves."""
    x, y, _ = person.position
    pose = context.pose
    ahead, aside = x - pose.x, y - pose.y
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    point = (c * ahead + s * aside, c * aside - s * ahead, _SEATED if person.posture == "sitting" else _CHEST)
    await move_to(context, gaze(context.robot.arm, point), speed=2.0)
    for _ in range(_TIMES):
        state = context.robot.state()
        end = state.work_t + _BETWEEN_S
        while state.work_t < end:
            state = await context.robot.tick()
        await context.see()


async def find_somebody(
    context: SkillContext, who: Someone, where: str = "", *, named: bool = True
) -> PersonSeen | Result:
    """Somebody who is meant, or why nobody is found. ``where``: a room, a piece of furniture or a place by its name;
    else here, then where they mostly are, then through the rooms. ``named``: a stranger who is looked for by a name
    must have it; else whoever may be called so will do."""
    wanted = fits(context, who) if named else may_be(context, who)
    rooms = context.robot.floor_map.rooms
    room = next((room for room in rooms if room.name == where), None)
    if where and room is None:
        return await _find_at(context, who, wanted, where)
    order = [room] if room is not None else _order(context, who)
    gestures = who.gesture is not None

    def inside(person: PersonSeen) -> bool:
        return any(one.holds(*person.position[:2]) for one in order)

    def found() -> PersonSeen | None:
        return seen_now(context, wanted, inside)

    here = room_at(context.robot.floor_map, context.pose.x, context.pose.y)
    if not gestures and (person := found()) is not None:
        return person
    if here in order or not rooms:
        trouble = await look_around(context, lambda: found() is not None, gestures=gestures)
        if (person := found()) is not None or trouble is not None:
            return person or trouble or _nobody(context, who, [])
    shut: Result | None = None
    seen: list[str] = []
    for one in order:
        trouble = await look_through(context, one, lambda: found() is not None, gestures=gestures)
        if (person := found()) is not None:
            return person
        if trouble is None:
            seen.append(one.name)
        elif trouble.error_code in NO_WAY:
            shut = trouble
        else:
            return trouble
    return shut if shut is not None and not seen else _nobody(context, who, seen)


def _order(context: SkillContext, who: Someone) -> list[Room]:
    """The rooms in which somebody is looked for: where they were seen last, where they mostly are, then by distance."""
    floor = context.robot.floor_map
    usual = context.people.about(who.name).place if who.name else None
    last = [room_at(floor, *p.position[:2]) for p in context.world.people.everybody if fits(context, who)(p)]
    return sorted(by_distance(floor, context.pose), key=lambda room: (room not in last, room.name != usual))


async def look_through(
    context: SkillContext, room: Room, found: Callable[[], bool], *, gestures: bool = False
) -> Result | None:
    """Look around from as many places of a room as it takes to see all of it."""
    places = _viewpoints(context, room)
    enough = found if not gestures else lambda: False  # what arms do is not told in passing
    trouble: Result | None = None
    reached = False
    for x, y in places:
        pose = context.pose
        goal = Pose(x, y, math.atan2(y - pose.y, x - pose.x))
        went = await go_to(context, goal, f"a place in the {room.name} to look from", enough=enough)
        if enough():
            return None
        if not went.ok:
            trouble = went
            continue
        reached = True
        if (trouble := await look_around(context, found, gestures=gestures)) is not None or found():
            return trouble
    if not places:
        return fail("unreachable", f"I cannot get into the {room.name}.")
    return None if reached else trouble


def _viewpoints(context: SkillContext, room: Room) -> list[tuple[float, float]]:
    """Where to look from: the place nearest to the middle of each part of the room."""
    stands = places_in(room, context.robot.floor_map, context.robot.footprint, context.pose)
    if not len(stands):
        return []
    across = max(1, math.ceil((room.x_max - room.x_min) / _FAR)), max(1, math.ceil((room.y_max - room.y_min) / _FAR))
    found: list[tuple[float, float]] = []
    for i in range(across[0]):
        for j in range(across[1]):
            x = room.x_min + (i + 0.5) * (room.x_max - room.x_min) / across[0]
            y = room.y_min + (j + 0.5) * (room.y_max - room.y_min) / across[1]
            found.append(nearest_place(stands, (x, y)))
    pose = context.pose
    return sorted(dict.fromkeys(found), key=lambda at: math.dist(at, (pose.x, pose.y)))


async def _find_at(context: SkillContext, who: Someone, wanted: Seen, where: str) -> PersonSeen | Result:
    """Somebody at a piece of furniture or a place: the one next to it. Whoever has a name may have stepped aside, and
    be elsewhere in that room."""
    at, began = place_called(context, where), context.robot.state().t
    if at is None:
        return fail("unknown_place", f"I don't know where the {where} is.")
    piece = furniture_called(context, where)

    def away(person: PersonSeen) -> float:
        x, y, _ = person.position
        return piece.away(x, y) if piece is not None else math.dist((x, y), at[:2])

    def found() -> PersonSeen | None:
        now = context.robot.state().t
        limit = BY if piece is not None else AT
        fresh = [p for p in context.world.people.everybody if wanted(p) and now - p.seen_at < FRESH_S]
        return min((p for p in fresh if away(p) < limit), key=away, default=None)

    room = room_at(context.robot.floor_map, at[0], at[1])
    if not room.holds(context.pose.x, context.pose.y) or math.dist((context.pose.x, context.pose.y), at[:2]) > 2.5:
        went = await _go_in_sight(context, at, where)
        if not went.ok:
            return went
    gestures = who.gesture is not None
    trouble = await look_around(context, lambda: found() is not None, gestures=gestures)
    if found() is None and trouble is None:
        trouble = await look_through(context, room, lambda: found() is not None, gestures=gestures)
    aside = [p for p in context.world.people.everybody if wanted(p) and p.seen_at >= began and not p.gone]
    aside = [p for p in aside if who.name and room.holds(*p.position[:2])]
    if (person := found() or min(aside, key=away, default=None)) is not None:
        return person
    return trouble or fail("object_not_found", f"I looked at the {where} and saw {_no(who)} there.")


def place_called(context: SkillContext, name: str) -> Point | None:
    """The middle of a piece of furniture, or a place of the map, by its name."""
    piece = furniture_called(context, name)
    if piece is not None:
        return (piece.x_min + piece.x_max) / 2, (piece.y_min + piece.y_max) / 2, 0.0
    pose = context.places.pose_of(name)
    return (pose.x, pose.y, 0.0) if pose is not None else None


async def _go_in_sight(context: SkillContext, at: Point, name: str) -> Result:
    """To the place of this name, or to where in its room the robot stands nearest to it but not at it."""
    room = room_at(context.robot.floor_map, at[0], at[1])
    stands = places_in(room, context.robot.floor_map, context.robot.footprint, context.pose)
    if not len(stands):
        return fail("unreachable", f"I cannot get to the {name}.")
    x, y = nearest_place(stands, at[:2], away=1.9)
    return await go_to(context, Pose(x, y, math.atan2(at[1] - y, at[0] - x)), f"the {name}")


def _no(who: Someone) -> str:
    return f"nobody called {who.name}" if who.name else f"no {who}"


def _nobody(context: SkillContext, who: Someone, rooms: list[str]) -> Result:
    where = f"in the {' and the '.join(rooms)}" if rooms else "around"
    return fail("object_not_found", f"I looked {where} and saw {_no(who)}.")


async def go_up_to(context: SkillContext, person: PersonSeen, *, apart: float = APART) -> Result:
    """Stand before somebody, facing them, ``apart`` m from their middle, or as near as there is room."""
    x, y, _ = person.position
    pose = context.pose
    away = math.dist((pose.x, pose.y), (x, y))
    if abs(away - apart) < 0.2:
        return await face(context, person)
    trouble: Result | None = None
    for distance in (apart, apart + 0.25, apart + 0.5):
        for goal in _stands(context, (x, y), distance):
            half_way = away > distance + 1.0
            if half_way:
                went = await go_to(context, _before(context, goal, 1.0), called(person))
                if not went.ok and went.error_code not in NO_WAY:
                    return went
            went = await go_to(context, goal, called(person), speed=CALM)
            if went.ok:
                return await face(context, person)
            if went.error_code not in (*NO_WAY, "no_progress"):
                return went
            trouble = went
            if math.dist((context.pose.x, context.pose.y), (x, y)) < apart + 0.6:
                return await face(context, person)
            break
    return trouble or fail("unreachable", f"There is no place to stand before {called(person)}.")


def _before(context: SkillContext, goal: Pose, short: float) -> Pose:
    """A pose on the way to ``goal``, ``short`` m before it."""
    way = way_to(context, goal)
    if isinstance(way, Unreachable):
        return goal
    left = short
    for (ax, ay), (bx, by) in reversed(list(zip(way.points, way.points[1:], strict=False))):
        length = math.dist((ax, ay), (bx, by))
        if length >= left:
            part = left / length if length else 0.0
            x, y = bx + (ax - bx) * part, by + (ay - by) * part
            return Pose(x, y, math.atan2(by - ay, bx - ax))
        left -= length
    return context.pose


def _stands(context: SkillContext, spot: tuple[float, float], distance: float) -> list[Pose]:
    """Places around somebody where the hull has room, facing them, the nearest by bearing first."""
    robot, pose = context.robot, context.pose
    towards = math.atan2(pose.y - spot[1], pose.x - spot[0])
    hard = outlines(robot.floor_map, (*spot, 0.0), around=distance + 0.5)
    found = []
    for i in range(_STEPS):
        angle = towards + (i + 1) // 2 * (-1) ** i * 2 * math.pi / _STEPS
        x, y = spot[0] + distance * math.cos(angle), spot[1] + distance * math.sin(angle)
        stand = Pose(x, y, wrap(angle + math.pi))
        if robot.floor_map.rooms and not any(room.holds(x, y) for room in robot.floor_map.rooms):
            continue
        if len(hard) and gaps(seen_from(stand, hard), robot.footprint).min() < _MARGIN:
            continue
        if not isinstance(way_to(context, stand), Unreachable):
            found.append(stand)
        if len(found) == 3:
            break
    return found


async def face(context: SkillContext, person: PersonSeen) -> Result:
    """Turn to somebody, and look at them."""
    await face_point(context, person.position)
    return ok(f"I am with {called(person)}.", x=context.pose.x, y=context.pose.y)


async def face_point(context: SkillContext, point: Point) -> None:
    """Turn the base and the camera to a point of the map."""
    pose = context.pose
    aside = wrap(math.atan2(point[1] - pose.y, point[0] - pose.x) - pose.yaw)
    if abs(aside) > 0.15:
        await turn(context, aside, _TURN)
    pose = context.pose
    away = math.dist((pose.x, pose.y), point[:2])
    await move_to(context, gaze(context.robot.arm, (max(away, 0.4), 0.0, max(point[2], _CHEST))), speed=2.0)


def called(person: PersonSeen) -> str:
    """``William``, or ``the person in red``."""
    return person.name or (f"the person in {person.shirt}" if person.shirt else "the person")
