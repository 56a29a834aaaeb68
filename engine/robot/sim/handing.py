"""What people of a scene do with their hands: they hold loose objects, take what the gripper holds, and put something
between its fingers.

A thing that is held has its coordinates set in every step: nothing pulls at it, and it pulls at nobody.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from engine.robot.sim.body import GRIP_SITE
from engine.robot.sim.dimensions import FINGER_TRAVEL
from engine.robot.sim.figure import Vector
from engine.robot.sim.scene_parts import LooseObject, Point

REACH: Final = 0.9
"""m along the floor, from the middle of somebody to the fingers."""
PATIENCE_S: Final = 10.0
"""s that somebody waits for the gripper to come near, or to open."""
PULL_AFTER_S: Final = 1.0
"""s after which somebody pulls, if the gripper does not open."""
HOLD_FOR_S: Final = 5.0
"""s that somebody holds a thing between the fingers for them to close."""
PRESSED_N: Final = 1.0
"""What each finger presses with on a thing that the robot has got hold of, N."""

_ROOM = 0.004  # m by which the gripper is open wider than what is put into it


class Hands:
    """Puts loose objects where hands are, and looks at what the gripper does."""

    def __init__(self, model: Any, data: Any, objects: Mapping[str, LooseObject]) -> None:
        self._model, self._data, self._objects = model, data, objects
        self._site = model.site(GRIP_SITE).id
        self._fingers = [model.body(f"{side} finger").id for side in ("left", "right")]
        self._opening = [int(model.joint(f"finger {side}").qposadr[0]) for side in ("left", "right")]
        self._places = {name: int(model.joint(name).qposadr[0]) for name in objects}
        self._speeds = {name: int(model.joint(name).dofadr[0]) for name in objects}
        self._geoms = {int(model.geom(name).id): name for name in objects}

    @property
    def grip_point(self) -> Vector:
        """Between the fingertips, map frame, m."""
        x, y, z = self._data.site_xpos[self._site].tolist()
        return x, y, z

    def middle(self, name: str) -> Vector:
        """Of a thing, map frame, m, if it is upright."""
        at = self._places[name]
        x, y, z = self._data.qpos[at : at + 3].tolist()
        return x, y, z + _middle(self._objects[name])

    def put(self, name: str, middle: Vector, yaw: float = 0.0) -> None:
        """Have a thing there now, upright and at rest; never below the floor."""
        at, speed = self._places[name], self._speeds[name]
        x, y, z = middle
        z = max(0.001, z - _middle(self._objects[name]))
        self._data.qpos[at : at + 7] = x, y, z, math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)
        self._data.qvel[speed : speed + 6] = 0

    def put_between_fingers(self, name: str) -> None:
        """Have a thing where the fingers close on it, its sides along them."""
        across = self._data.site_xmat[self._site].reshape(3, 3)[:, 1]
        self.put(name, self.grip_point, math.atan2(across[1], across[0]))

    def let_go(self, name: str) -> None:
        """Leave a thing to gravity, which does not wake what sleeps."""
        self._data.qvel[self._speeds[name] + 2] = -0.001

    def fits(self, name: str) -> bool:
        """Whether the gripper is open wide enough for a thing."""
        opening = float(self._data.qpos[self._opening].sum())
        return opening > min(_width(self._objects[name]) + _ROOM, 1.9 * FINGER_TRAVEL)

    def held_by_robot(self) -> str | None:
        """The thing that both fingers touch."""
        touched = [self._touched(finger) for finger in self._fingers]
        return next((name for name in touched[0] if name in touched[1]), None)

    def pressed(self, name: str) -> bool:
        """Whether both fingers press on it."""
        return all(self._touched(finger).get(name, 0.0) > PRESSED_N for finger in self._fingers)

    def _touched(self, finger: int) -> dict[str, float]:
        """What a finger touches, and with how many newtons."""
        found: dict[str, float] = {}
        pairs: NDArray[np.int32] = self._data.contact.geom
        for index, pair in enumerate(pairs.tolist()):
            bodies = [int(self._model.geom_bodyid[geom]) for geom in pair]
            name = next((self._geoms[geom] for geom in pair if geom in self._geoms), None)
            if name is None or finger not in bodies:
                continue
            force = np.zeros(6)
            mujoco.mj_contactForce(self._model, self._data, index, force)
            found[name] = found.get(name, 0.0) + float(force[0])
        return found


class Giving:
    """Somebody puts a thing between the fingers and holds it there until they close."""

    def __init__(self, thing: str, t: float) -> None:
        self.thing = thing
        self.given = False
        """The thing is between the fingers."""
        self._until = t + PATIENCE_S

    def step(self, hands: Hands, at: Point, t: float) -> bool:
        """Whether it goes on; in the end the robot has the thing, or it falls, unless nothing was given."""
        if not self.given:
            if not (_is_near(hands, at) and hands.fits(self.thing)):
                return t < self._until
            self.given, self._until = True, t + HOLD_FOR_S
        elif hands.pressed(self.thing):
            return False
        elif t > self._until:
            hands.let_go(self.thing)
            return False
        hands.put_between_fingers(self.thing)
        return True


class Taking:
    """Somebody takes hold of what the gripper holds, and has it when that opens, or pulls."""

    def __init__(self, t: float) -> None:
        self.thing: str | None = None
        """What they have taken hold of."""
        self.taken = False
        self._until = t + PATIENCE_S

    def step(self, hands: Hands, at: Point, t: float) -> bool:
        """Whether it goes on; in the end they have the thing, unless none was taken."""
        held = hands.held_by_robot()
        if self.thing is None:
            if held is not None and _is_near(hands, at):
                self.thing, self._until = held, t + PULL_AFTER_S
            return t < self._until
        self.taken = held != self.thing or t >= self._until
        return not self.taken


def _is_near(hands: Hands, at: Point) -> bool:
    x, y, _ = hands.grip_point
    return math.dist((x, y), at) <= REACH


def _width(loose: LooseObject) -> float:
    """What the fingers close on, m."""
    return {"cup": 0.75, "bottle": 0.4}.get(loose.kind, 1.0) * loose.size


def _middle(loose: LooseObject) -> float:
    """Of what can be gripped of a thing, above its bottom, m."""
    return 0.34 * loose.size if loose.kind == "bottle" else loose.tall / 2
