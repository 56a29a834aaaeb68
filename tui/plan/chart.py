"""What moves on the map, as characters over the plan: where the robot came from, what its lidar sees, the way ahead,
what was seen, the robot and its hand, and the cursor of whoever points at something.

A character has one colour, so whatever matters more hides what matters less, in that order. Walls that the lidar sees
are lit and stay walls; what it sees where the map has nothing is drawn in dots.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Final

from msgspec import Struct

from tui.plan.floor import Cell, Frame, ahead, arrow, person_sign, thing_sign, way

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.perception.memory import Thing
    from engine.perception.people import PersonSeen
    from engine.robot.floor_map import FloorMap
    from engine.robot.robot import RobotState, Scan

Overlay = dict[tuple[int, int], Cell]
"""By row and column."""
Spot = tuple[float, float]
"""Map frame, m."""

TRAIL: Final = "·"
AGES: Final = (10.0, 60.0, 300.0)
"""s after which a thing that was seen fades by a step."""
_HULL: Final = (0.30, 0.24)
"""m along and across: how large the robot is drawn where there is room to."""
_REACH: Final = 0.30
"""m from the robot's centre to where its hand is drawn when the arm leans out."""
_OUT: Final = math.radians(50)
"""Pitch of the hand from which the arm leans out: 0 is up."""
_NEAR: Final = 0.15
"""m from what is on the map within which a ray ended there: the robot does not know better where it stands."""
_GAP: Final = 1.0
"""m between two neighbouring rays' ends from which there may be nothing between them."""
_FOLDED: Final = 0.3
"""rad by which every joint of a folded arm may differ from it."""


class Moving(Struct, frozen=True):
    """All of it at one moment."""

    robot: RobotState | None = None
    path: Sequence[Spot] = ()  # all of the planned way; what is left of it is drawn
    trail: Sequence[Spot] = ()
    seen: Sequence[Spot] = ()  # walls and furniture that the lidar sees, in the order of its rays
    loose: Sequence[Spot] = ()  # what it sees where the map has nothing
    things: Sequence[Thing] = ()
    people: Sequence[PersonSeen] = ()
    held: Thing | None = None
    now: float = 0.0  # robot time, s
    cursor: Spot | None = None
    goal: Spot | None = None  # where it would go from there, where that is elsewhere


def overlay(moving: Moving, frame: Frame, plan: Sequence[Sequence[Cell]]) -> Overlay:
    """The cells that differ from the plan."""
    cells: Overlay = {}
    for row, column in way(moving.trail, frame):
        if plan[row][column].char == " ":
            cells[row, column] = Cell(TRAIL, "trail", plan[row][column].ground)
    cells |= _lit(moving.seen, moving.loose, frame, plan)
    pose = moving.robot.pose if moving.robot is not None else None
    path = moving.path if pose is None else ahead(moving.path, pose.x, pose.y)
    for (row, column), char in way(path, frame).items():
        if plan[row][column].ink != "place":
            cells[row, column] = Cell(char, "path", plan[row][column].ground)
    for thing in reversed(moving.things):  # the newest comes last, and over the others
        if (at := frame.cell(*thing.position[:2])) is not None:
            sign, fade = thing_sign(thing, moving.now), faded(moving.now - thing.seen_at)
            cells[at] = Cell(sign, "thing", plan[at[0]][at[1]].ground, thing.colour, fade)
    for person in reversed(moving.people):
        if (at := frame.cell(*person.position[:2])) is not None:
            sign, fade = person_sign(person, moving.now), faded(moving.now - person.seen_at)
            cells[at] = Cell(sign, "thing", plan[at[0]][at[1]].ground, person.shirt or "grey", fade)
    if moving.robot is not None:
        _put_robot(cells, moving.robot, moving.held, frame, plan)
    for spot in (moving.goal, moving.cursor):
        if spot is not None and (at := frame.cell(*spot)) is not None:
            under = cells.get(at, plan[at[0]][at[1]])
            cells[at] = Cell("+" if under.char == " " else under.char, "cursor", "floor")
    return cells


def hits(scan: Scan, robot: RobotState, floor: FloorMap) -> tuple[tuple[Spot, ...], tuple[Spot, ...]]:
    """Where the rays of a scan ended, map frame: on what is on the map, and elsewhere."""
    import numpy as np  # here and not above: the first paint does not wait for it

    reached: NDArray[np.bool_] = np.isfinite(scan.ranges)
    angles = scan.angles[reached] + robot.pose.yaw
    x = robot.pose.x + scan.ranges[reached] * np.cos(angles)
    y = robot.pose.y + scan.ranges[reached] * np.sin(angles)
    column = np.floor((x - floor.origin[0]) / floor.resolution).astype(int)
    row = np.floor((y - floor.origin[1]) / floor.resolution).astype(int)
    near = math.ceil(_NEAR / floor.resolution)
    padded = np.pad(floor.occupied, near)
    known = np.zeros(len(x), dtype=np.bool_)
    for right in range(2 * near + 1):
        for up in range(2 * near + 1):
            rows, columns = row + up, column + right
            inside = (rows >= 0) & (rows < padded.shape[0]) & (columns >= 0) & (columns < padded.shape[1])
            known[inside] |= padded[rows[inside], columns[inside]]
    spots = list(zip(x.tolist(), y.tolist(), strict=True))
    return (
        tuple(spot for spot, is_known in zip(spots, known, strict=True) if is_known),
        tuple(spot for spot, is_known in zip(spots, known, strict=True) if not is_known),
    )


def faded(age: float) -> int:
    """How many steps something that was seen ``age`` s ago has faded."""
    return sum(age > limit for limit in AGES)


def posture(robot: RobotState) -> str:
    """What the arm does: ``folded``, ``up`` or ``out``."""
    from engine.robot.arm import ARM_INITIAL

    if all(abs(is_ - folded) < _FOLDED for is_, folded in zip(robot.joints, ARM_INITIAL, strict=True)):
        return "folded"
    _, shoulder, elbow, wrist, _ = robot.joints
    return "out" if abs(shoulder + elbow + wrist) > _OUT else "up"


def _lit(seen: Sequence[Spot], loose: Sequence[Spot], frame: Frame, plan: Sequence[Sequence[Cell]]) -> Overlay:
    """Strokes and blocks that the lidar sees in its colour; dots on free floor."""
    cells: Overlay = {}
    for spot in _joined(seen, frame.cell_width):
        if (at := frame.cell(*spot)) is None or at in cells:
            continue
        under = plan[at[0]][at[1]]
        if under.ground == "wall" and under.char == " ":
            cells[at] = Cell(" ", "wall", "seen")
        elif under.ink in ("wall", "furniture") and under.char != " ":
            cells[at] = Cell(under.char, "seen", under.ground)
    for (row, column), char in way(loose, frame, joined=False).items():
        if plan[row][column].char == " ":
            cells[row, column] = Cell(char, "scan", plan[row][column].ground)
    return cells


def _joined(spots: Sequence[Spot], step: float) -> Iterable[Spot]:
    """The spots, and those between neighbours: far away the rays of a lidar are wider apart than characters."""
    for (x, y), (next_x, next_y) in zip(spots, (*spots[1:], *spots[:1]), strict=True):
        apart = math.hypot(next_x - x, next_y - y)
        count = max(1, math.ceil(apart / step)) if apart < _GAP else 1
        for number in range(count):
            yield x + (next_x - x) * number / count, y + (next_y - y) * number / count


def _put_robot(
    cells: Overlay, robot: RobotState, held: Thing | None, frame: Frame, plan: Sequence[Sequence[Cell]]
) -> None:
    pose = robot.pose
    at = frame.cell(pose.x, pose.y)
    if at is None:
        _point_to(cells, pose.x, pose.y, frame)
        return
    for row, column in _hull(robot, frame):
        cells[row, column] = Cell(" ", "robot", "robot")
    bearing = pose.yaw + robot.joints[0]
    how = posture(robot)
    if how != "folded" or held is not None:
        reach = _REACH if how == "out" else 0.0 if frame.cell_width < _REACH / 4 else frame.cell_width
        hand = frame.cell(pose.x + reach * math.cos(bearing), pose.y + reach * math.sin(bearing))
        if hand is not None and hand != at:
            ground = cells[hand].ground if hand in cells else plan[hand[0]][hand[1]].ground
            sign = "◆" if held is not None else "◇"
            cells[hand] = Cell(sign, "thing" if held else "hand", ground, held.colour if held else "")
    cells[at] = Cell(arrow(pose.yaw), "robot", "floor")


def _point_to(cells: Overlay, x: float, y: float, frame: Frame) -> None:
    """At the edge of the picture, where the robot is beyond it: one row above the last, which may be the cursor's."""
    if not (math.isfinite(x) and math.isfinite(y)):
        return
    column, row = frame.at(x, y)
    right = (column - frame.columns / 2) / frame.columns
    down = (row - frame.rows / 2) / frame.rows
    sign = ("▶" if right > 0 else "◀") if abs(right) >= abs(down) else ("▼" if down > 0 else "▲")
    at = max(0, min(frame.rows - 2, int(row))), max(0, min(frame.columns - 1, int(column)))
    cells[at] = Cell(sign, "robot", "floor")


def _hull(robot: RobotState, frame: Frame) -> Iterable[tuple[int, int]]:
    """Cells whose middle lies within the robot, where it is larger than one of them."""
    pose, (length, width) = robot.pose, _HULL
    if frame.cell_width > width / 2:
        return
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    middle, centre = frame.at(pose.x, pose.y)
    far = math.ceil(length / frame.cell_width)
    for row in range(max(0, int(centre) - far), min(frame.rows, int(centre) + far + 1)):
        for column in range(max(0, int(middle) - far), min(frame.columns, int(middle) + far + 1)):
            x = (column + 0.5 - middle) * frame.cell_width
            y = (centre - row - 0.5) * frame.cell_height
            if abs(c * x + s * y) <= length / 2 and abs(c * y - s * x) <= width / 2:
                yield row, column
