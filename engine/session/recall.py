"""What the robot knows of the things around it, in words for a planner."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from engine.errors import CameraError, PlanError, RobotError
from engine.perception.asking import as_png
from engine.perception.describe import in_words
from engine.perception.memory import WorldMemory
from engine.perception.naming import wanted
from engine.perception.people import PersonSeen
from engine.perception.someone import someone
from engine.robot.floor_map import FloorMap
from engine.robot.robot import Robot
from engine.skills.find import may_stand, whereabouts

MOST_TOLD = 12
"""Things that are told, those that were seen last."""


class Recall:
    """The memory of one robot."""

    def __init__(self, robot: Robot, memory: WorldMemory) -> None:
        self._robot = robot
        self._memory = memory

    def holding(self) -> str:
        """The name of what the gripper holds; empty for nothing."""
        held = self._memory.held
        return held.name if held is not None else ""

    def seen(self) -> tuple[str, ...]:
        """What was seen and where, a sentence each, the newest last."""
        floor_map: FloorMap = self._robot.floor_map
        world = self._memory.snapshot()
        told = [(p.seen_at, f"{in_words(p)} {_room(p, floor_map)}.") for p in world.people if not p.gone]
        told += [(t.seen_at, f"The {t.name} is {whereabouts(t, floor_map)}.") for t in world.things]
        return tuple(words for _, words in sorted(told, key=lambda one: one[0])[-MOST_TOLD:])

    def people(self) -> dict[str, str]:
        """Of those who are known and were seen: where and when, a sentence by name."""
        now, found = self._robot.state().t, {}
        for person in self._memory.people.everybody:
            if person.name is not None and not person.gone:
                where, ago = _room(person, self._robot.floor_map), now - person.seen_at
                when = f"{ago:.0f} s ago" if ago < 100 else f"{ago / 60:.0f} min ago"
                found[person.name] = f"I saw {person.name} {where} {when}."
        return found

    def since(self, t: float) -> Callable[[str], bool]:
        """Whether a thing or a person of a description has been seen after ``t`` (robot time, s), or is held. Of people
        only what shows is known, and the names of those who have told theirs."""

        def sees(words: str) -> bool:
            try:
                what = wanted(words)
            except PlanError:
                return self._saw_somebody(words, t)
            held = self._memory.held
            if held is not None and what.fits(held.kind, held.colour, held.tag):
                return True
            return any(thing.seen_at >= t for thing in self._memory.find(what))

        return sees

    def where_since(self, t: float) -> Callable[[str, str], bool]:
        """Whether a thing that was seen after ``t`` may be on a piece of furniture, beside it, or in a room, by its
        name; so it may where the map has no such name."""
        floor: FloorMap = self._robot.floor_map

        def may_be_at(words: str, place: str) -> bool:
            try:
                seen = [thing for thing in self._memory.find(wanted(words)) if thing.seen_at >= t]
            except PlanError:
                return True
            return not seen or any(may_stand(thing, place, floor) for thing in seen)

        return may_be_at

    def _saw_somebody(self, words: str, t: float) -> bool:
        try:
            who = someone(words)
        except PlanError:
            return False
        if who.gender is not None:  # it does not show
            return False
        everybody = self._memory.people.everybody
        return any(person.seen_at >= t and not person.gone and person.fits(who, None) for person in everybody)

    async def picture(self) -> bytes | None:
        """What the camera shows now, as a PNG file; None where there is no picture to be had."""
        try:
            return await asyncio.to_thread(as_png, await self._robot.look())
        except (CameraError, RobotError):
            return None

    def now(self) -> float:
        """Robot time, s."""
        return self._robot.state().t


def _room(person: PersonSeen, floor: FloorMap) -> str:
    room = next((room.name for room in floor.rooms if room.holds(*person.position[:2])), None)
    return f"in the {room}" if room else "here"
