"""The robot, its map, places and pictures as plain data for JSON, and back. ``protocol`` documents the shapes."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from config.schema import Place, Position, Quaternion
from engine.events import Value
from engine.robot.arm import ArmModel
from engine.robot.camera import Lens, Mount, Picture
from engine.robot.floor_map import Doorway, FloorMap, Furniture, Landmark, Room, Wall
from engine.robot.geometry import Pose, Twist
from engine.robot.robot import Capability, Footprint, RobotState, Scan
from engine.skills.context import SkillContext
from engine.skills.places import ZERO_SYMBOL, Places

MAX_MM = 65536
"""Depths from here on, mm, count as none: they are told in two bytes."""

Facts = dict[str, Any]


def start_facts(name: str, args: Mapping[str, Value], context: SkillContext, occupies: frozenset[Capability]) -> Facts:
    """All that a program is told before it begins; to it, the robot has what it occupies."""
    robot = context.robot
    return {
        "name": name,
        "args": dict(args),
        "epoch": context.epoch,
        "robot": {
            "name": robot.name,
            "capabilities": sorted(robot.capabilities & occupies),
            "footprint": {"length": robot.footprint.length, "width": robot.footprint.width},
            "arm": asdict(robot.arm),
        },
        "places": _places_facts(context.places),
        "map": map_facts(robot.floor_map),
        "state": state_facts(robot.state()),
    }


def state_facts(state: RobotState) -> Facts:
    return {
        "t": state.t,
        "pose": pose_facts(state.pose),
        "twist": _twist_facts(state.twist),
        "command": _twist_facts(state.command),
        "joints": list(state.joints),
        "joint_targets": list(state.joint_targets),
        "gripper": state.gripper,
        "grip": state.grip,
        "light": list(state.light),
        "blocked": state.blocked,
        "halted": state.halted,
        "paused_s": state.paused_s,
    }


def state_of(facts: Facts, epoch: int) -> RobotState:
    """The state as it was; the epoch is the program's own."""
    return RobotState(
        t=facts["t"],
        epoch=epoch,
        pose=Pose(*facts["pose"]),
        twist=Twist(*facts["twist"]),
        command=Twist(*facts["command"]),
        joints=tuple(facts["joints"]),
        joint_targets=tuple(facts["joint_targets"]),
        gripper=facts["gripper"],
        grip=facts["grip"],
        light=tuple(facts["light"]),
        blocked=facts["blocked"],
        halted=facts["halted"],
        paused_s=facts["paused_s"],
    )


def scan_facts(scan: Scan) -> Facts:
    ranges = [round(distance, 4) if math.isfinite(distance) else None for distance in scan.ranges.tolist()]
    return {"t": scan.t, "angles": scan.angles.tolist(), "ranges": ranges}


def scan_of(facts: Facts) -> Scan:
    ranges = [math.inf if distance is None else distance for distance in facts["ranges"]]
    return Scan(facts["t"], np.array(facts["angles"], dtype=np.float64), np.array(ranges, dtype=np.float64))


def picture_facts(picture: Picture) -> Facts:
    lens, mount = picture.lens, picture.mount
    millimetres = np.where(picture.depth * 1000 < MAX_MM, np.rint(picture.depth * 1000), 0).astype("<u2")
    return {
        "t": picture.t,
        "pose": pose_facts(picture.pose),
        "lens": asdict(lens),
        "mount": {"rotation": mount.rotation.tolist(), "position": mount.position.tolist()},
        "rgb": base64.b64encode(picture.rgb.tobytes()).decode(),
        "depth": base64.b64encode(millimetres.tobytes()).decode(),
    }


def picture_of(facts: Facts) -> Picture:
    lens = Lens(**facts["lens"])
    rgb = np.frombuffer(base64.b64decode(facts["rgb"]), np.uint8).reshape(lens.height, lens.width, 3)
    millimetres = np.frombuffer(base64.b64decode(facts["depth"]), "<u2").reshape(lens.height, lens.width)
    depth = np.where(millimetres > 0, millimetres / 1000, np.inf).astype(np.float32)
    mount = Mount(np.array(facts["mount"]["rotation"]), np.array(facts["mount"]["position"]))
    return Picture(facts["t"], rgb, depth, lens, mount, Pose(*facts["pose"]))


def pose_facts(pose: Pose) -> list[float]:
    return [pose.x, pose.y, pose.yaw]


def arm_of(facts: Facts) -> ArmModel:
    tuples = {name: tuple(facts[name]) for name in ("shoulder", "eye")}
    return ArmModel(**{**facts, **tuples, "ranges": tuple((low, high) for low, high in facts["ranges"])})


def map_of(facts: Facts) -> FloorMap:
    rows = [[cell == "#" for cell in row] for row in facts["rows"]]
    return FloorMap(
        resolution=facts["resolution"],
        origin=(facts["origin"][0], facts["origin"][1]),
        occupied=np.array(rows, dtype=np.bool_),
        rooms=tuple(Room(**room) for room in facts["rooms"]),
        furniture=tuple(Furniture(**thing) for thing in facts["furniture"]),
        doors=tuple(Doorway(**{**door, "between": tuple(door["between"])}) for door in facts["doors"]),
        tags=tuple(Landmark(**tag) for tag in facts["tags"]),
        walls=tuple(Wall(**wall) for wall in facts["walls"]),
    )


def footprint_of(facts: Facts) -> Footprint:
    return Footprint(facts["length"], facts["width"])


def places_of(facts: Mapping[str, Facts]) -> Places:
    places = Places({symbol: _place(place) for symbol, place in facts.items() if symbol != ZERO_SYMBOL})
    if zero := facts.get(ZERO_SYMBOL):
        places.remember(Pose(zero["x"], zero["y"], zero["yaw"]))
    return places


def _place(facts: Facts) -> Place:
    name, *aliases = facts["names"]
    half = facts["yaw"] / 2
    return Place(
        name=name,
        aliases=tuple(aliases),
        position=Position(x=facts["x"], y=facts["y"]),
        orientation=Quaternion(z=math.sin(half), w=math.cos(half)),
    )


def _places_facts(places: Places) -> dict[str, Facts]:
    found: dict[str, Facts] = {}
    for symbol in places.known():
        if (pose := places.pose(symbol)) is not None:
            names = [ZERO_SYMBOL] if symbol == ZERO_SYMBOL else list(places.words(symbol))
            found[symbol] = {"names": names, "x": pose.x, "y": pose.y, "yaw": pose.yaw}
    return found


def map_facts(floor: FloorMap) -> Facts:
    return {
        "resolution": floor.resolution,
        "origin": list(floor.origin),
        "rows": ["".join("#" if cell else "." for cell in row) for row in floor.occupied.tolist()],
        "rooms": [asdict(room) for room in floor.rooms],
        "furniture": [asdict(thing) for thing in floor.furniture],
        "doors": [asdict(door) for door in floor.doors],
        "tags": [asdict(tag) for tag in floor.tags],
        "walls": [asdict(wall) for wall in floor.walls],
    }


def _twist_facts(twist: Twist) -> list[float]:
    return [twist.vx, twist.vy, twist.wz]
