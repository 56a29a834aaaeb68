"""Whole errands: bringing things, tidying, and asking when something is not clear. They are made of what the other
files do one by one: look for it, pick it up, drive, put it down; each step can fail, and says so."""

from __future__ import annotations

from collections import Counter
from collections.abc import Awaitable, Callable, Sequence
from typing import Annotated, Final

from engine.perception.memory import Thing
from engine.perception.naming import Wanted, wanted
from engine.perception.people import PersonSeen
from engine.robot.floor_map import Furniture, Room
from engine.skills.context import SkillContext
from engine.skills.find import (
    NO_WAY,
    by_distance,
    find,
    furniture_called,
    listing,
    nearest_bin,
    room_called,
    things_in,
    whereabouts,
)
from engine.skills.grasp import lost, pick
from engine.skills.hand import grip_again, still_held
from engine.skills.library.manipulation import fetch
from engine.skills.library.navigation import PlaceName
from engine.skills.library.searching import ObjectName, RoomName
from engine.skills.meeting import called, go_up_to, look_around, seen_now
from engine.skills.outcome import ErrorCode, Result, fail, ok
from engine.skills.places import ZERO_SYMBOL
from engine.skills.put import HIGHEST, put_in, put_on, put_on_floor
from engine.skills.registry import Word, skill
from engine.skills.search import room_at, search
from engine.skills.travel import go_to

ATTEMPTS: Final = 2
"""How often one thing is tried before it is left where it is."""
ROUNDS: Final = 3
"""How often a room is looked through: what fell down on the way, or was hidden, is found in the next round."""

RIGHT_HERE: Final = 1.5
"""m from where the task was given, within which somebody has at hand what is put there."""
NEAR_HERE: Final = 3.0
"""m within which the robot brings it to them instead."""

_HOPELESS: Final[frozenset[ErrorCode]] = frozenset({"robot_lost", "robot_halted", "camera_lost", "cancelled"})
"""Failures after which nothing else can be tried."""

PutAway = Callable[[], Awaitable[Result]]


@skill(occupies=["base", "arm", "camera"], changes=["pose", "things"])
async def carry(
    context: SkillContext, object: ObjectName, place: PlaceName, source: Annotated[str, Word("surface")] = ""
) -> Result:
    """Bring something to a place: find it (on or in ``source`` first if that is given), pick it up, drive there, put it
    down: on the piece of furniture that the place is at, where the arm reaches, else on the floor."""
    goal, name = context.places.pose(place), context.places.name(place)
    if goal is None:
        return fail("unknown_place", "I have not been told to remember a place yet.")
    held, elsewhere = context.world.held, ""
    if held is None or wanted(object).is_choice or not wanted(object).fits(held.kind, held.colour, held.tag):
        rooms = _rooms_of(context, source)
        picked = await fetch(context, wanted(object), rooms)
        if picked.error_code == "object_not_found" and rooms is not None:  # people err about where they left things
            others = tuple(room for room in by_distance(context.robot.floor_map, context.pose) if room not in rooms)
            context.progress(None, f"no {object} in the {source}, looking elsewhere")
            found = await find(context, wanted(object), rooms=others)
            if isinstance(found, Thing):
                where = whereabouts(found, context.robot.floor_map)
                elsewhere = f" It was not where you said but {where}."
                picked = await fetch(context, wanted(object), others)
        if not picked.ok:
            return picked
        if (held := context.world.held) is None:
            return fail("dropped", f"I have lost the {object}.")
    await grip_again(context)
    piece = furniture_called(context, name.removeprefix("the "))
    went = await go_to(context, goal, name)
    if not still_held(context):
        return lost(context, held)
    if not went.ok and (piece is None or went.error_code not in NO_WAY):  # furniture can be stood at elsewhere
        return fail(went.error_code or "path_blocked", f"{went.message} I still hold the {held.name}.")
    if (
        place == ZERO_SYMBOL
        and (waiting := await who_waits(context)) is not None
        and (await go_up_to(context, waiting)).ok
    ):
        name = called(waiting)
    put = await _put_down(context, piece)
    return ok(f"I brought the {held.name} to {name}.{elsewhere}") if put.ok else put


async def who_waits(context: SkillContext) -> PersonSeen | None:
    """Whoever asked for something may have stepped aside for the robot: the nearest of those who are near, where nobody
    is right here. Somebody else may be in the picture, and they behind it: then it looks all round."""
    pose = context.pose

    def away(person: PersonSeen) -> float:
        return person.distance_to(pose.x, pose.y)

    def nearest() -> PersonSeen | None:
        return seen_now(context, lambda person: True, lambda person: away(person) < NEAR_HERE)

    if not any(away(person) < NEAR_HERE for person in context.world.people.everybody):
        return None
    if (person := nearest()) is None or away(person) > RIGHT_HERE:
        await look_around(context, lambda: (seen := nearest()) is not None and away(seen) < RIGHT_HERE)
        person = nearest()
    return person if person is not None and away(person) > RIGHT_HERE else None


async def _put_down(context: SkillContext, piece: Furniture | None) -> Result:
    """On or into the piece of furniture, where there is one that the arm reaches and that has room; else on the
    floor."""
    if piece is not None and piece.kind == "bin":
        return await put_in(context, piece)
    if piece is not None and 0 < piece.height <= HIGHEST:
        put = await put_on(context, piece)
        if put.error_code not in ("no_room", "out_of_reach"):
            return put
    return await put_on_floor(context)


@skill(occupies=["base", "arm", "camera"], lasting=True)
async def clean_room(context: SkillContext, room: RoomName = "") -> Result:
    """Clean a room, the one that the robot is in unless another is named: everything that lies about goes into the
    bin."""
    place = room_called(context, room)
    if (bin_ := nearest_bin(context, place)) is None:
        return fail("unknown_place", "There is no bin on the map to put things into.")
    return await _put_away(context, place, Wanted(), lambda: put_in(context, bin_), f"into the {bin_.name}", None)


@skill(occupies=["base", "arm", "camera"], lasting=True)
async def clear_rubbish(context: SkillContext) -> Result:
    """Put the rubbish that lies about into the bin: in this room, or where nothing lies about here, in the nearest one
    that has some."""
    looked_in: list[str] = []
    for room in by_distance(context.robot.floor_map, context.pose):
        cleaned = await clean_room.run(context, room.name)
        if cleaned.error_code in NO_WAY:
            continue
        if not cleaned.ok or cleaned.data.get("moved"):
            return cleaned
        looked_in.append(room.name)
    if not looked_in:
        return fail("unreachable", "I cannot get into any room.")
    return fail("object_not_found", f"I looked in the {' and the '.join(looked_in)} and saw nothing to throw away.")


@skill(occupies=["base", "arm", "camera"], lasting=True)
async def tidy(
    context: SkillContext, color: Annotated[str, Word("thing_colour")], surface: Annotated[str, Word("surface")]
) -> Result:
    """Put all things of a colour that lie about in this room onto a piece of furniture, or into the bin."""
    place = room_at(context.robot.floor_map, context.pose.x, context.pose.y)
    piece = furniture_called(context, surface)
    if piece is None:
        return fail("unknown_place", f"There is no {surface} on the map to put things on.")
    into = piece.kind == "bin"
    put: PutAway = (lambda: put_in(context, piece)) if into else (lambda: put_on(context, piece))
    return await _put_away(
        context, place, wanted(color), put, f"{'into' if into else 'onto'} the {piece.name}", None if into else piece
    )


@skill(occupies=["voice"], changes=[])
async def ask_user(context: SkillContext, question: Annotated[str, Word("sentence")]) -> Result:
    """Ask a question and wait: the plan ends here, and what is said next answers it."""
    del context  # the question is asked by whoever runs the plan
    return Result("ok", "needs_answer", question)


async def _put_away(
    context: SkillContext, room: Room, what: Wanted, put: PutAway, where: str, target: Furniture | None
) -> Result:
    """Look through the room and put all things that are meant away, nearest first, until none is left."""
    moved: list[Thing] = []
    tries: Counter[int] = Counter()
    worst: Result | None = None
    for _ in range(ROUNDS):
        searched = await search(context, room)
        if searched.trouble is not None:
            return _summary(moved, where, searched.trouble)
        before = len(moved)
        while (thing := _next_thing(context, room, what, target, tries)) is not None:
            tries[thing.number] += 1
            context.progress(None, f"{len(moved)} put {where}, now the {thing.name}")
            result = await pick(context, thing)
            if result.ok:
                result = await put()
                if result.ok:
                    moved.append(thing)
                    continue
                if context.world.held is not None:
                    return _summary(moved, where, result)
            worst = result
            if result.error_code in _HOPELESS:
                return _summary(moved, where, result)
        if len(moved) == before:
            break  # a round without anything to put away, or nothing that can be: it is over
    left = _matching(context, room, what, target)
    if left:
        message = f"I had to leave {listing(left)}."
        code: ErrorCode = (worst.error_code if worst else None) or "grasp_failed"
        return _summary(moved, where, fail(code, f"{message} {worst.message if worst else ''}".rstrip()))
    if not moved:
        return ok(f"There is nothing to put away in the {room.name}.", moved=0)
    return ok(f"I put {listing(tuple(moved))} {where}.", moved=len(moved))


def _next_thing(
    context: SkillContext, room: Room, what: Wanted, target: Furniture | None, tries: Counter[int]
) -> Thing | None:
    matching = _matching(context, room, what, target)
    return next((thing for thing in matching if tries[thing.number] < ATTEMPTS), None)


def _matching(context: SkillContext, room: Room, what: Wanted, target: Furniture | None) -> tuple[Thing, ...]:
    """What is remembered to lie about, is meant, and is not where it belongs already."""
    return tuple(
        thing
        for thing in things_in(context, room)
        if what.fits(thing.kind, thing.colour, thing.tag)
        and not (target is not None and target.holds(*thing.position[:2]))
    )


def _summary(moved: Sequence[Thing], where: str, trouble: Result) -> Result:
    """A failure that says what was done before it."""
    done = f"I put {listing(tuple(moved))} {where}. " if moved else ""
    return fail(trouble.error_code or "no_progress", f"{done}{trouble.message}", moved=len(moved))


def _rooms_of(context: SkillContext, source: str) -> tuple[Room, ...] | None:
    """Where to look for something that is to be on or in ``source``; None: anywhere."""
    if not source:
        return None
    floor = context.robot.floor_map
    if (room := next((room for room in floor.rooms if room.name == source), None)) is not None:
        return (room,)
    piece = furniture_called(context, source)
    if piece is None:
        return None
    return (room_at(floor, (piece.x_min + piece.x_max) / 2, (piece.y_min + piece.y_max) / 2),)
