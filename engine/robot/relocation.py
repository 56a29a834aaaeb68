"""Which corrections of the robot's pose can be true.

Whatever a program says about where the robot is becomes the origin of all that follows: a pose that is not on the map
is never left again, because nothing that is seen from there fits. So a correction is checked before it is believed.
"""

from __future__ import annotations

import math
from typing import Final

from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Pose, wrap

LAG: Final = 2.0
"""m that the robot can have driven since what it is told about: understanding a picture takes a second or two."""
JUMP: Final = (2.0, math.pi / 2)
"""m and rad by which odometry can be wrong: it is put right at every landmark, long before."""


def impossible(believed: Pose, true: Pose, now: Pose, house: FloorMap) -> str:
    """Why the robot, which believes to be at ``now``, cannot have been at ``true`` when it believed to be at
    ``believed``; "" if it can."""
    numbers = (believed.x, believed.y, believed.yaw, true.x, true.y, true.yaw)
    if not all(map(math.isfinite, numbers)):
        return "a pose has three finite numbers"
    if not believed.distance_to(now) <= LAG:
        return f"it has not believed to be at {believed.x:.3g}, {believed.y:.3g} lately"
    if not house.holds(true.x, true.y):
        return f"{true.x:.3g}, {true.y:.3g} is not on the map"
    if believed.distance_to(true) > JUMP[0] or abs(wrap(true.yaw - believed.yaw)) > JUMP[1]:
        return f"no odometry is wrong by more than {JUMP[0]:g} m or {math.degrees(JUMP[1]):.0f}°"
    return ""
