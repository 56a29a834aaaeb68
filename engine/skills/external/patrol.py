"""The skill ``patrol``, an external program: visits places one after the other, again and again.

Without places it visits one in each room, in the order in which the map lists rooms: the first place of the map that
lies there. What is in the way of one place does not end the round: it says so and goes on to the next. Only a round
in which nothing was reached does.
"""

from __future__ import annotations

from dataclasses import replace

from engine.skills.context import Progress, SkillContext
from engine.skills.external.guest import main
from engine.skills.library.navigation import navigation
from engine.skills.outcome import Result, fail
from engine.skills.places import ZERO_SYMBOL

LOOK_S = 1.0
"""How long it stays at each place, s of robot time."""


async def patrol(context: SkillContext, places: str = "") -> Result:
    """Visit ``places`` (symbols separated by commas) in rounds; ends only when it can reach none of them."""
    stops = tuple(places.split(",")) if places else one_in_each_room(context)
    if not stops:
        return fail("unknown_place", "There is no place on the map to patrol.")
    on_the_way = replace(context, progress=_endless(context))
    while True:
        reached, why = 0, ""
        for stop in stops:
            result = await navigation.run(on_the_way, stop)
            if result.ok:
                reached += 1
                await context.sleep(LOOK_S)
            elif result.error_code in ("path_blocked", "unreachable", "no_progress", "unknown_place"):
                why = result.message
                context.progress(None, f"{why} I go on with my round.", path=())
                await context.robot.tick()  # also where every place is refused at once, time has to pass
            else:
                return result
        if not reached:
            return fail("path_blocked", f"I could reach no place of my round. {why}")


def one_in_each_room(context: SkillContext) -> tuple[str, ...]:
    """For each room the first place that lies in it; all places where the map has no rooms."""
    places = [symbol for symbol in context.places.known() if symbol != ZERO_SYMBOL]
    rooms = context.robot.floor_map.rooms
    if not rooms:
        return tuple(places)
    poses = {symbol: pose for symbol in places if (pose := context.places.pose(symbol)) is not None}
    first = (next((s for s, pose in poses.items() if room.holds(pose.x, pose.y)), None) for room in rooms)
    return tuple(dict.fromkeys(symbol for symbol in first if symbol is not None))


def _endless(context: SkillContext) -> Progress:
    """Progress of a way is no progress of a patrol, which has no end."""

    def progress(
        fraction: float | None, message: str = "", *, path: tuple[tuple[float, float], ...] | None = None
    ) -> None:
        del fraction
        context.progress(None, message, path=path)

    return progress


if __name__ == "__main__":
    main(patrol)
