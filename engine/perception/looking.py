"""Where to hold the arm to look: poses that keep the hand out of the way and show a known stretch of the floor.

The fingers ride below the camera and hide the middle of the picture's lowest quarter, most when they are closed; that
is why each pose sees nearer at the sides than straight ahead. All poses stay above the hull and within the joints'
ranges at any yaw of the arm.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from engine.robot.arm import Joints

LookName = Literal["DOWN", "AHEAD", "FAR"]


@dataclass(frozen=True, slots=True)
class Look:
    """One pose to look from. Distances are those of the floor, from the middle of the robot, m."""

    joints: Joints
    near: float  # of the lowest row of the picture, beside the fingers
    clear: float  # from which on closed fingers hide nothing, straight ahead
    far: float  # up to which small things on the floor are seen well

    def shows(self, distance: float) -> bool:
        """Whether a thing on the floor straight ahead is in the picture and not behind the fingers."""
        return self.clear <= distance <= self.far

    def turned(self, yaw: float) -> Joints:
        """The same look to the side; ``yaw`` in rad, counter-clockwise."""
        return (yaw, *self.joints[1:])


LOOK_POSES: Final[dict[LookName, Look]] = {
    "DOWN": Look((0.0, -1.0, 1.5, 2.0, 0.0), near=0.15, clear=0.22, far=0.65),
    "AHEAD": Look((0.0, -0.9, 1.2, 1.9, 0.0), near=0.25, clear=0.40, far=1.6),
    "FAR": Look((0.0, -0.3, 0.6, 1.5, 0.0), near=0.71, clear=1.15, far=2.5),
}
"""``DOWN`` shows what lies right before the hull, ``AHEAD`` what is within a step or two and on low tables there,
``FAR`` the rest of the room; tables of 14 cm stand a little nearer in each."""


def look_at(distance: float) -> Look:
    """The pose that shows a thing on the floor at this distance from the middle of the robot, m, the nearest one
    first: it shows the thing largest."""
    return next((look for look in LOOK_POSES.values() if distance <= 0.85 * look.far), LOOK_POSES["FAR"])
