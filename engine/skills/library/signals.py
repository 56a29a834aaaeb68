"""Light and buzzer."""

from __future__ import annotations

from typing import Annotated

from engine.skills.context import SkillContext
from engine.skills.outcome import Result, ok
from engine.skills.registry import Measure, Word, skill

BEEP_S = 0.2
_LOOK_S, _LOOKS = 0.02, 25
"""How often the state is looked at for the new colour, s, and how many times at most: not every robot tells it."""

COLOURS: dict[str, tuple[int, int, int]] = {
    "off": (0, 0, 0),
    "white": (255, 255, 255),
    "red": (255, 0, 0),
    "green": (0, 255, 0),
    "blue": (0, 0, 255),
    "yellow": (255, 200, 0),
    "orange": (255, 110, 0),
    "purple": (150, 0, 255),
    "pink": (255, 80, 160),
    "cyan": (0, 220, 255),
}


@skill(changes=[])
async def beep(context: SkillContext, seconds: Annotated[float, Measure("s", 0.01, 5)] = BEEP_S) -> Result:
    """Sound the buzzer."""
    context.robot.beep(seconds, context.epoch)
    await context.sleep(seconds)
    return ok("Beeped.")


@skill(changes=["light"])
async def light(context: SkillContext, color: Annotated[str, Word("colour")]) -> Result:
    """Set the colour of the light: white, red, green, blue, yellow, orange, purple, pink, cyan, or off."""
    context.robot.set_light(COLOURS[color], context.epoch)
    for _ in range(_LOOKS):  # what it has changed may be asked about at once
        if (await context.sleep(_LOOK_S)).light == COLOURS[color]:
            break
    return ok("The light is off." if color == "off" else f"The light is {color}.")
