"""The measurements of the simulated robot: what the engine must know of its body without loading the simulator."""

from __future__ import annotations

import math

from engine.robot.arm import ArmModel
from engine.robot.robot import Footprint

FOOTPRINT = Footprint(length=0.30, width=0.24)
"""The hull; wheels, lidar and the folded arm stay within it."""

SHOULDER = (0.05, 0.0, 0.16)
"""Where the shoulder axis crosses the arm's yaw axis, base frame, m."""
UPPER_ARM, FOREARM, HAND = 0.16, 0.14, 0.13
"""Shoulder to elbow, elbow to wrist, wrist to the point between the fingertips, m."""
JOINT_RANGES: tuple[tuple[float, float], ...] = ((-2.8, 2.8), (-1.9, 1.9), (-2.5, 2.5), (-2.3, 2.3), (-1.7, 1.7))
"""rad, in the order of ``ARM_JOINTS``."""
FINGER_TRAVEL = 0.034
"""Of each finger, m; the gripper opens to twice that."""

CAMERA_OFFSET = (-0.036, 0.0, 0.03)
"""The camera's place on the wrist: above the hand when the arm leans forward."""
CAMERA_VIEW = math.radians(48)
"""Its vertical field of view, rad."""

ARM = ArmModel(SHOULDER, UPPER_ARM, FOREARM, HAND, 2 * FINGER_TRAVEL, JOINT_RANGES, CAMERA_OFFSET)

LIDAR_HEIGHT = 0.10
"""m above the floor: furniture, walls and cartons are seen, things as small as a cup on the floor are not."""
LIDAR_RANGE = 12.0
"""m."""
