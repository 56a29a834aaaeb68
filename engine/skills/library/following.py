"""Following and tracking by camera: coloured things, people, QR codes, what is in a box of the picture; and how far
away is what a pixel shows. Tags are followed by a program of their own, ``external/apriltag_follow.py``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Annotated, Final, cast

import numpy as np

from engine.events import Value
from engine.perception.depth import distance_at, thing_in_box
from engine.perception.naming import Wanted
from engine.perception.qr import find_qr
from engine.perception.sighting import EVERYTHING, Colour, Part, PixelBox, Sight, Sighting
from engine.robot.camera import floor_error
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Point, Pose, wrap
from engine.skills.context import SkillContext
from engine.skills.grasp import pick
from engine.skills.outcome import Result, fail, ok
from engine.skills.put import put_on_floor
from engine.skills.registry import Measure, Word, skill
from engine.skills.servo import Target, follow, nearest, tag_finder
from engine.skills.tape import LineDriver, Stopped, line_colour
from engine.skills.travel import go_to

Column = Annotated[float, Measure("", 0, 10_000)]
"""Of a pixel, from the picture's left edge."""
Row = Annotated[float, Measure("", 0, 10_000)]
"""Of a pixel, from the picture's upper edge."""
ThingColour = Annotated[str, Word("thing_colour")]

KEEP_THING = 0.6
"""m from the robot's middle to a small thing that is followed."""
KEEP_CODE = 1.0
_THINGS: Final[frozenset[Part]] = frozenset({"things", "people"})
"""Shoes and hands are no things, so that people have to be seen as well."""
MOST_CLEARED = 10
"""Things that one errand along a line puts aside."""


@skill(occupies=["base", "arm", "camera"], changes=["pose"], endless=True)
async def color_follow(context: SkillContext, color: ThingColour) -> Result:
    """Follow the nearest thing of a colour at a distance of 0.6 m, until told otherwise."""
    wanted = Wanted(colour=cast(Colour, color))
    return await follow(context, Target(f"the {color} thing", _things(wanted), _THINGS), keep=KEEP_THING)


@skill(occupies=["base", "arm", "camera"], changes=["pose"], endless=True)
async def qr_follow(context: SkillContext) -> Result:
    """Follow a QR code that somebody carries, at a distance of 1 m, until told otherwise."""

    def find(sight: Sight, near: Point | None) -> Point | None:
        return nearest((code.position for code in find_qr(sight.picture)), near, sight)

    return await follow(context, Target("the QR code", find, set()), keep=KEEP_CODE)


@skill(occupies=["base", "arm", "camera"], changes=["pose"], endless=True)
async def track(context: SkillContext, x1: Column, y1: Row, x2: Column, y2: Row) -> Result:
    """Keep what is in a box of the picture in view, turning arm and base but not driving, until told otherwise.

    x1, y1 is the upper left corner of the box in pixels, x2, y2 the lower right one.
    """
    sight = await context.see()
    box = round(min(x1, x2)), round(min(y1, y2)), round(max(x1, x2)), round(max(y1, y2))
    found = _in_box(sight, box, context.robot.floor_map)
    if found is None:
        seen = ", ".join(f"the {thing.name} at {thing.box}" for thing in sight.objects) or "nothing that I know"
        return fail("object_not_found", f"There is nothing in that box that I can track. I see {seen}.")
    return await follow(context, found, keep=None)


@skill(occupies=["camera"], changes=[], flat=True)
async def get_dist(context: SkillContext, x: Column, y: Row) -> Result:
    """Measure how far away from the camera is what a pixel of the picture shows.

    x is the column from the left, y the row from the top.
    """
    picture = (await context.see()).picture
    height, width = picture.depth.shape
    if x >= width or y >= height:
        return fail("object_not_found", f"The picture has {width}×{height} pixels; ({x:g}, {y:g}) is not in it.")
    away = distance_at(picture, x, y)
    if away is None:
        return fail("object_not_found", f"What pixel ({x:g}, {y:g}) shows is too far away to be measured.")
    ray = picture.lens.rays(np.array([[x, y]]))
    [place] = picture.on_map(picture.mount.out(ray * away / np.linalg.norm(ray)))
    at_x, at_y, at_z = (round(value, 3) for value in place.tolist())
    found = {"distance": round(away, 3), "x": at_x, "y": at_y, "z": at_z}
    if not picture.guessed:
        return ok(f"What pixel ({x:g}, {y:g}) shows is {away:.2f} m away.", **found)
    height = float(picture.mount.position[2])
    error = floor_error(height, math.sqrt(max(0.0, away**2 - height**2)))
    return ok(
        f"What pixel ({x:g}, {y:g}) shows is {away:.2f} m away if it lies on the floor, give or take {error:.2f} m.",
        **found,
        error=round(error, 3),
    )


def _things(wanted: Wanted) -> Callable[[Sight, Point | None], Point | None]:
    def find(sight: Sight, near: Point | None) -> Point | None:
        fitting = (thing for thing in sight.objects if wanted.fits(thing.kind, thing.colour, thing.tag))
        return nearest((thing.position for thing in fitting), near, sight)

    return find


def _in_box(sight: Sight, box: PixelBox, floor: FloorMap) -> Target | None:
    """What a box of the picture shows: the tag in it, else the thing that it means."""
    left, top, right, bottom = box
    for tag in sight.tags:
        column, row = tag.corners.mean(axis=0)
        if left <= column < right and top <= row < bottom:
            return Target(f"tag {tag.id}", tag_finder(tag.id, floor), {"tags"})
    thing = thing_in_box(sight, *box)
    if thing is None:
        return None
    parts = _THINGS if thing.tag is None else EVERYTHING
    return Target(f"the {thing.name}", _things(Wanted(thing.kind, thing.colour, thing.tag)), parts)


@skill(occupies=["base", "arm", "camera"], changes=["pose"], flat=True)
async def follow_line(context: SkillContext, color: ThingColour = "") -> Result:
    """Drive along a line on the floor to its end; stops before what stands on it.

    Without a colour it takes the line that it sees most of.
    """
    colour = cast(Colour | None, color or await line_colour(context))
    if colour is None:
        return fail("object_not_found", "I see no line on the floor; tell me its colour.")
    driver = LineDriver(context, colour)
    return _ended(driver, colour, await driver.run())


@skill(occupies=["base", "arm", "camera"], lasting=True)
async def follow_line_clear(context: SkillContext, color: ThingColour = "") -> Result:
    """Drive along a line on the floor to its end, and put aside what stands on it.

    Without a colour it takes the line that it sees most of.
    """
    colour = cast(Colour | None, color or await line_colour(context))
    if colour is None:
        return fail("object_not_found", "I see no line on the floor; tell me its colour.")
    driver, cleared = LineDriver(context, colour), list[str]()
    while True:
        stopped = await driver.run()
        if stopped.why != "thing" or stopped.thing is None or len(cleared) >= MOST_CLEARED:
            return _ended(driver, colour, stopped, cleared)
        where = context.pose
        trouble = await _aside(context, stopped.thing, Pose(where.x, where.y, driver.direction))
        if not trouble.ok:
            return fail(
                trouble.error_code or "path_blocked",
                f"The {stopped.thing.name} on the {colour} line is still in my way after {driver.length:.1f} m. "
                f"{trouble.message}",
                length=round(driver.length, 2), cleared=len(cleared),
            )  # fmt: skip
        cleared.append(stopped.thing.name)


async def _aside(context: SkillContext, thing: Sighting, on_the_line: Pose) -> Result:
    """Pick up what stands on the line, put it beside, and stand on the line again."""
    x, y, _ = thing.position
    known = min(context.world.things, key=lambda other: other.distance_to(x, y), default=None)
    if known is None:
        return fail("object_not_found", f"I do not see the {thing.name} any more.")
    taken = await pick(context, known)
    if not taken.ok:
        return taken
    put = fail("no_room", f"There is no room beside the line for the {thing.name}.")
    for side in (math.pi / 2, -math.pi / 2):
        beside = Pose(on_the_line.x, on_the_line.y, wrap(on_the_line.yaw + side))
        put = await go_to(context, beside, "the line")
        if put.ok:
            put = await put_on_floor(context)
        if put.ok or put.error_code != "no_room":
            break
    return await go_to(context, on_the_line, "the line") if put.ok else put


def enumerated(names: Sequence[str]) -> str:
    """``the red box, the cup and the ball``."""
    *most, last = (f"the {name}" for name in names)
    return f"{', '.join(most)} and {last}" if most else last


def _ended(driver: LineDriver, colour: str, stopped: Stopped, cleared: Sequence[str] = ()) -> Result:
    """The result for people."""
    length = round(driver.length, 2)
    aside = f" I put aside {enumerated(cleared)}." if cleared else ""
    line, way = f"the {colour} line", f"{driver.length:.1f} m"
    data: dict[str, Value] = {"length": length}
    if cleared:
        data["cleared"] = len(cleared)
    match stopped.why:
        case "end":
            return ok(f"I followed {line} to its end, {way}.{aside}", **data)
        case "thing" if stopped.thing is not None:
            message = f"After {way} of {line} a {stopped.thing.name} stands in my way.{aside}"
            return fail("path_blocked", message, thing=stopped.thing.name, **data)
        case "unseen":
            return fail("object_not_found", f"I looked around and saw no {colour} line on the floor.", **data)
        case "lost":
            return fail("target_lost", f"I lost {line} after {way}: the tape does not go on where I can see.", **data)
    return fail(stopped.error or "no_progress", f"I stopped after {way} of {line}: {stopped.reason}.{aside}", **data)
