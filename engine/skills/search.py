"""Looking through a room: where to stand and where to look next, until all of it has been seen.

The room's floor and the tops of its low tables are a grid of patches. Every picture marks the patches that it really
shows, with all of what may stand there: within range, not at the edge, not hidden behind something (the depth tells).
The next view is the one that promises the most unseen patches for the time it takes to get there. What several views
could not show is given up.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.looking import LOOK_POSES
from engine.robot.arm import Joints
from engine.robot.camera import Picture
from engine.robot.floor_map import FloorMap, Room
from engine.robot.geometry import Pose, wrap
from engine.robot.occupancy import distances
from engine.robot.robot import Footprint
from engine.skills.context import SkillContext
from engine.skills.drive import turn
from engine.skills.hand import move_to
from engine.skills.outcome import Result, fail, ok
from engine.skills.strewn import BESIDE, outline, strewn
from engine.skills.travel import SEEN_RANGE, go_to

LOOK: Final[Joints] = (0.0, -0.9, 1.2, 1.8, 0.0)
"""The arm while it looks around: a little higher than ``AHEAD``, to have things on low tables in the picture whole."""
PATCH: Final = 0.1
"""Edge of a patch, m."""
NEAR, FAR = 0.35, 1.6
"""From the base's centre, m: in between, patches are seen well enough to notice a small thing."""
TALL: Final = 0.15
"""m that a small thing rises at most. Of one that the upper edge cuts off nobody can tell that it is no leg or post."""
HALF_VIEW: Final = math.radians(25)
"""Of the wedge that a view is expected to show; pictures show a little more."""
HEADINGS: Final = 8
LOW: Final = 0.2
"""Tables up to this height are looked at from above, m."""
TRIES: Final = 2
"""Views that may fail to show a patch before it is given up."""
ENOUGH: Final = 0.97
"""Part of the room that must have been seen."""
BLOCKED: Final = 4
"""Places in a row that it cannot get to before it gives up."""
BRISK: Final = 10.0
"""Unseen patches per second that the next view of a room must promise, as long as other rooms have hardly been seen.
Of a room of 15 m², four fifths are seen at 20 to 30 a second, and the last fifth at 5: it takes as long as the rest."""
ON_TABLES: Final = 4.0
"""Patches of floor that a patch of a table counts for: that is where people put things."""
WORTHWHILE: Final = 6
"""Unseen patches that a view must promise: a corner that needs a view of its own hides nothing larger than a cup."""
_ELSEWHERE: Final = frozenset({"path_blocked", "unreachable", "door_closed", "no_progress"})
"""Why one place to look from may be left out."""
_STUCK: Final = fail("no_progress", "The arm stopped on the way to its looking pose.")
_EYE, _SKYLINE = 0.41, 3.3  # m: how high the camera is then, and where the picture's upper edge meets the floor
_TURN_SPEED = 1.5  # rad/s
_GRID = 0.25  # m between places to stand
_MARGIN = 0.06  # m that the robot keeps from things, beyond its circle
_DRIVE_COST, _TURN_COST, _VIEW_COST = 2.5, 0.7, 1.5  # s per metre and radian, and for a view


@dataclass(frozen=True, slots=True)
class Searched:
    """How a search ended: ``found`` when it was ended by what was looked for."""

    found: bool
    seen: float  # part of the room, 0…1
    pictures: int
    trouble: Result | None = None
    """Why it could not go on."""


class Survey:
    """What has been seen of a room, and the best view to take next."""

    def __init__(self, room: Room, floor: FloorMap, hull: Footprint, now: Pose) -> None:
        """``now`` is where the robot stands: it looks from places that it can get to."""
        self._patches = _patches(room, floor)
        self._reach = _reach(self._patches[:, 2])
        self._worth = np.where(self._patches[:, 2] > 0.0, ON_TABLES, 1.0)
        self._open = np.ones(len(self._patches), dtype=np.bool_)  # not seen yet and not given up
        self._missed = np.zeros(len(self._patches), dtype=np.int64)
        self._stands = places_in(room, floor, hull, now)
        self._seen = 0
        self._taken: set[tuple[float, float, float]] = set()  # views; none is asked for twice

    @property
    def seen(self) -> float:
        """Part of the patches that a picture has shown."""
        return self._seen / max(1, len(self._patches))

    @property
    def done(self) -> bool:
        return not self._open.any() or self._seen >= ENOUGH * len(self._patches)

    def next_view(self, now: Pose, least: float = 0.0) -> Pose | None:
        """Where to look from next; None when no view promises more than ``least`` unseen patches per second."""
        if self.done or not len(self._stands):
            return None
        best, view = least, None
        unseen, reach, worth = self._patches[self._open], self._reach[self._open], self._worth[self._open]
        headings = np.arange(HEADINGS) * (2 * math.pi / HEADINGS)
        for x, y in self._stands.tolist():
            dx, dy = unseen[:, 0] - x, unseen[:, 1] - y
            way = np.hypot(dx, dy)
            near = (way > NEAR) & (way < reach)
            if worth[near].sum() <= best * _VIEW_COST:  # no view from here can be better
                continue
            bearing, value = np.arctan2(dy[near], dx[near]), worth[near]
            apart = math.hypot(x - now.x, y - now.y)
            for heading in headings.tolist():
                count = float(value[np.abs((bearing - heading + math.pi) % (2 * math.pi) - math.pi) < HALF_VIEW].sum())
                if count < WORTHWHILE or (x, y, heading) in self._taken:
                    continue
                cost = _VIEW_COST + _DRIVE_COST * apart + _TURN_COST * abs(wrap(heading - now.yaw))
                if count / cost > best:
                    best, view = count / cost, (x, y, heading)
        if view is None:
            return None
        self._taken.add(view)
        return Pose(view[0], view[1], wrap(view[2]))

    def bar(self, obstacles: NDArray[np.float64], clearance: float) -> None:
        """Nobody can stand within ``clearance`` of these points (map frame, shape (n, 2), m)."""
        if len(obstacles):
            apart = np.hypot(*(self._stands[:, None] - obstacles[None]).transpose(2, 0, 1)).min(axis=1)
            self._stands = self._stands[apart >= clearance]

    def mark(self, picture: Picture) -> None:
        """Take in what a picture showed, and what it should have shown and did not."""
        points = picture.from_map(self._patches)
        way = np.hypot(points[:, 0], points[:, 1])
        bearing = np.abs(np.arctan2(points[:, 1], points[:, 0]))
        wanted = self._open & (way > NEAR) & (way < self._reach)
        shown = _shown(picture, points) & wanted
        self._open &= ~shown
        self._seen += int(shown.sum())
        self._missed += wanted & ~shown & (bearing < HALF_VIEW)
        self._open &= self._missed < TRIES


async def search(
    context: SkillContext,
    room: Room,
    found: Callable[[], bool] = lambda: False,
    survey: Survey | None = None,
    *,
    least: float = 0.0,
) -> Searched:
    """Look through ``room`` until all is seen or ``found()``; what is seen is in the memory then. ``survey``: go on
    with one that was begun. ``least``: leave the room once its views promise no more unseen patches per second."""
    robot = context.robot
    survey = survey or Survey(room, robot.floor_map, robot.footprint, context.pose)
    pictures = blocked = 0
    if survey.seen == 0.0:  # what lies right before the hull is in no view from here
        if not await move_to(context, LOOK_POSES["DOWN"].joints):
            return Searched(False, 0.0, 0, _STUCK)
        await context.see()
        pictures = 1
    while not found() and (pose := _next(context, room, survey, least)) is not None:
        on_the_way = context.saying(f"looking through the {room.name}, {survey.seen:.0%} seen", survey.seen)
        trouble = await _stand(on_the_way, pose, room.name)
        if trouble is not None:
            blocked += 1
            if trouble.error_code not in _ELSEWHERE or blocked > BLOCKED:
                return Searched(False, survey.seen, pictures, trouble)
            survey.bar(robot.scan().on_map(context.pose, SEEN_RANGE), robot.footprint.radius + _MARGIN)
            continue
        if not await move_to(context, LOOK):
            return Searched(False, survey.seen, pictures, _STUCK)
        survey.mark((await context.see()).picture)
        pictures, blocked = pictures + 1, 0
    return Searched(found(), survey.seen, pictures)


def _next(context: SkillContext, room: Room, survey: Survey, least: float) -> Pose | None:
    survey.bar(outline(strewn(context)), context.robot.footprint.radius + BESIDE)
    inside = room.holds(context.pose.x, context.pose.y)  # the way into a room is not held against its first view
    return survey.next_view(context.pose, least if inside else 0.0)


async def _stand(context: SkillContext, pose: Pose, room: str) -> Result | None:
    """Stand at ``pose``; why not, if that fails."""
    now = context.pose
    if now.distance_to(pose) > 0.06:
        result = await go_to(context, pose, f"a place in the {room} to look from")
        return None if result.ok else result
    turned = await turn(context, wrap(pose.yaw - now.yaw), _TURN_SPEED)
    return fail(turned.error, f"I could not turn around: {turned.reason}.") if turned.error else None


def room_at(floor: FloorMap, x: float, y: float) -> Room:
    """The room at a place; a map without rooms is one room."""
    found = next((room for room in floor.rooms if room.holds(x, y)), None)
    if found is not None:
        return found
    rows, columns = floor.occupied.shape
    x0, y0 = floor.origin
    return Room("room", x0, y0, x0 + columns * floor.resolution, y0 + rows * floor.resolution)


def nothing_more(searched: Searched, room: str) -> Result:
    """The result of a search that was to see everything."""
    if searched.trouble is not None:
        return searched.trouble
    return ok(f"I have seen {searched.seen:.0%} of the {room}.", seen=round(searched.seen, 3))


def _shown(picture: Picture, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points of the base frame the picture shows: inside of it with what stands there, and nothing in front."""
    depth = picture.mount.into(points)[:, 2]
    pixels, above = picture.pixels(points), picture.pixels(points + np.array((0.0, 0.0, TALL)))
    height, width = picture.depth.shape
    with np.errstate(invalid="ignore"):
        inside = (pixels[:, 0] > 2) & (pixels[:, 0] < width - 2) & (above[:, 1] > 2) & (pixels[:, 1] < height - 2)
    shown = np.zeros(len(points), dtype=np.bool_)
    columns, rows = pixels[inside].astype(int).T
    shown[inside] = np.abs(picture.depth[rows, columns] - depth[inside]) < 0.08 + 0.05 * depth[inside]
    return shown


def _reach(heights: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far away a patch may be, by its height, to be seen with what stands on it, m."""
    return np.minimum(FAR, _SKYLINE * (1 - (heights + TALL) / _EYE))


def _patches(room: Room, floor: FloorMap) -> NDArray[np.float64]:
    """The middles of all patches of floor and low tables, map frame, shape (n, 3)."""
    xs = np.arange(room.x_min + PATCH / 2, room.x_max, PATCH)
    ys = np.arange(room.y_min + PATCH / 2, room.y_max, PATCH)
    found = []
    for x in xs:
        for y in ys:
            table = next((f for f in floor.furniture if 0 < f.height <= LOW and f.holds(x, y)), None)
            if table is not None and table.kind != "bin":
                found.append((x, y, table.height))
            elif not _occupied(floor, x, y):
                found.append((x, y, 0.0))
    return np.array(found, dtype=np.float64).reshape(-1, 3)


def places_in(room: Room, floor: FloorMap, hull: Footprint, now: Pose) -> NDArray[np.float64]:
    """Where in the room the robot can get to, stand and turn, shape (n, 2)."""
    import cv2  # slow to import, and not every program that knows the skills searches

    clearance = hull.radius + _MARGIN
    open_ = distances(floor.occupied, floor.resolution, clearance + 0.1) >= clearance
    _, areas = cv2.connectedComponents(open_.astype(np.uint8), connectivity=4)
    rows, columns = np.nonzero(open_)
    if not len(rows):
        return np.empty((0, 2))
    row, column = _cell(floor, now.x, now.y)
    nearest = np.hypot(rows - row, columns - column).argmin()  # it may stand closer to something than it would go
    area = areas[rows[nearest], columns[nearest]]
    found = [
        (x, y)
        for x in np.arange(room.x_min + clearance, room.x_max - clearance + 1e-9, _GRID)
        for y in np.arange(room.y_min + clearance, room.y_max - clearance + 1e-9, _GRID)
        if areas[_cell(floor, x, y)] == area
    ]
    return np.array(found, dtype=np.float64).reshape(-1, 2)


def nearest_place(places: NDArray[np.float64], at: tuple[float, float], away: float = 0.0) -> tuple[float, float]:
    """The one of these places (shape (n, 2), n > 0) that is nearest to ``away`` m from a point."""
    distance = np.hypot(places[:, 0] - at[0], places[:, 1] - at[1])
    x, y = places[np.abs(distance - away).argmin()]
    return float(x), float(y)


def _occupied(floor: FloorMap, x: float, y: float) -> bool:
    return bool(floor.occupied[_cell(floor, x, y)])


def _cell(floor: FloorMap, x: float, y: float) -> tuple[int, int]:
    rows, columns = floor.occupied.shape
    row = math.floor((y - floor.origin[1]) / floor.resolution)
    column = math.floor((x - floor.origin[0]) / floor.resolution)
    return max(0, min(rows - 1, row)), max(0, min(columns - 1, column))
