"""Things put before the robot: a flat with a chosen set of loose objects, laid out for one picture at a time.

What a thing truly is and where it truly stands is for the test that asks, never for what it tests.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from engine.perception.sighting import Sight, Sighting
from engine.robot.arm import Joints
from engine.robot.camera import Picture
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Pose
from engine.robot.sim.floor import floor_map
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.robot.sim.scene_parts import LooseObject
from tests.sim.eye import Eye

CHROMATIC = ("red", "orange", "yellow", "green", "blue", "purple")
COLOURS = (*CHROMATIC, "white", "grey", "black")
SIZES = {"box": 0.04, "ball": 0.06, "cup": 0.08, "bottle": 0.15, "tag_block": 0.045}
"""Usual ones, m, as scene files count them."""
_AWAY = (0.0, 0.0, -3.0)  # below the floor


@dataclass(frozen=True, slots=True)
class Put:
    """One thing of the set, standing somewhere on the map."""

    name: str
    x: float
    y: float
    z: float = 0.0  # of what it stands on
    yaw: float = 0.0


class Arranged:
    """Looks at the flat with only what was put into it."""

    def __init__(self, objects: dict[str, LooseObject], *, width: int = 160, height: int = 120) -> None:
        scene = load_scene(scene_path("flat"))
        self.scene: Scene = scene.model_copy(update={"objects": objects})
        self.map: FloorMap = floor_map(self.scene)
        self.eye = Eye(self.scene, width=width, height=height)
        self.objects = objects
        bodies = {name: self.eye.model.body(name).id for name in objects}
        self._geoms = {
            name: np.flatnonzero(self.eye.model.geom_bodyid == body).tolist() for name, body in bodies.items()
        }
        for finger in ("finger left", "finger right"):  # open
            self.eye.data.qpos[self.eye.model.joint(finger).qposadr[0]] = 0.034

    def look(self, things: Iterable[Put], pose: Pose, joints: Joints, believed: Pose | None = None) -> Picture:
        """A picture of these things and no others."""
        for name in self.objects:
            self.eye.put(name, *_AWAY)
        for thing in things:
            self.eye.put(thing.name, thing.x, thing.y, thing.z, thing.yaw)
        return self.eye.look(pose, joints, believed)

    def shown(self, picture: Picture, name: str) -> int:
        """Pixels in which the picture truly shows a thing."""
        assert picture.labels is not None
        return int(np.isin(picture.labels, self._geoms[name]).sum())

    def cut(self, picture: Picture, name: str) -> bool:
        """Whether the picture's edge cuts it off."""
        assert picture.labels is not None
        mask = np.isin(picture.labels, self._geoms[name])
        return bool(mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any())

    def middle(self, thing: Put) -> tuple[float, float, float]:
        """Where its middle truly is, map frame."""
        loose = self.objects[thing.name]
        return thing.x, thing.y, thing.z + loose.tall / 2

    def found(self, sight: Sight, thing: Put, *, within: float = 0.06) -> Sighting | None:
        """The sighting next to where a thing truly stands."""
        x, y, _ = self.middle(thing)
        near = [
            (float(np.hypot(seen.position[0] - x, seen.position[1] - y)), index)
            for index, seen in enumerate(sight.objects)
        ]
        best = min(near, default=None)
        return sight.objects[best[1]] if best is not None and best[0] < within else None


def loose(kind: str, colour: str = "white", *, scale: float = 1.0, tag: int | None = None) -> LooseObject:
    """One thing for a set; ``scale`` is against its usual size."""
    size = round(SIZES[kind] * scale, 4)
    return LooseObject.model_validate(
        {"kind": kind, "at": (0, 0), "size": size, "colour": colour, **({"tag": tag} if tag is not None else {})}
    )


def one_of_each(colours: Sequence[str] = COLOURS, *, scale: float = 1.0) -> dict[str, LooseObject]:
    """Every kind in every colour, and three tag blocks."""
    things = {
        f"{colour} {kind}": loose(kind, colour, scale=scale)
        for kind in ("box", "ball", "cup", "bottle")
        for colour in colours
    }
    return things | {f"block {tag}": loose("tag_block", tag=tag, scale=scale) for tag in (1, 2, 3)}
