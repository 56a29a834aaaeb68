"""The skill ``apriltag_follow``, an external program: follows an AprilTag at a distance, until told otherwise.

It drives by the same visual servoing as the followers of the library, on pictures that the engine hands over. Tags
that are fixed to the house are no targets unless one is asked for by its number.
"""

from __future__ import annotations

from engine.skills.context import SkillContext
from engine.skills.external.guest import main
from engine.skills.outcome import Result
from engine.skills.servo import Target, follow, tag_finder

KEEP = 0.6
"""m from the robot's middle to the tag."""


async def apriltag_follow(context: SkillContext, tag: float = -1) -> Result:
    """Follow the tag of this number; a negative one stands for any. Ends only when it is lost."""
    number = round(tag) if tag >= 0 else None
    name = "the tag" if number is None else f"tag {number}"
    return await follow(context, Target(name, tag_finder(number, context.robot.floor_map), {"tags"}), keep=KEEP)


if __name__ == "__main__":
    main(apriltag_follow)
