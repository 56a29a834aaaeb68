"""Doors that are shut, as the lidar sees them."""

from __future__ import annotations

import math

import numpy as np

from engine.robot.floor_map import Doorway
from engine.skills.context import SkillContext

SEEN_RANGE = 2.5  # m
DOOR_RANGE = 1.5  # m from which the lidar can tell whether a door is shut
FILLED = 0.6  # part of a door's width


def closed_door(context: SkillContext) -> Doorway | None:
    """The nearest door that the lidar sees to be shut: something fills most of its width."""
    pose = context.pose
    points = context.robot.scan().on_map(pose, SEEN_RANGE)
    near = [
        door for door in context.robot.floor_map.doors if math.dist((door.x, door.y), (pose.x, pose.y)) < DOOR_RANGE
    ]
    for door in sorted(near, key=lambda door: math.dist((door.x, door.y), (pose.x, pose.y))):
        apart = points - np.array((door.x, door.y))
        inside = apart[np.hypot(apart[:, 0], apart[:, 1]) < 0.9 * door.width / 2]
        if len(inside) > 1 and np.ptp(inside, axis=0).max() > FILLED * door.width:
            return door
    return None


def is_closed(door: Doorway) -> str:
    """In words for people."""
    return f"the door between the {door.between[0]} and the {door.between[1]} is closed"
