"""A big room with one person in it, and a camera that looks at them from any side."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from engine.robot.camera import Picture
from engine.robot.company import Gesture, Posture
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Pose
from engine.robot.sim.dimensions import ARM
from engine.robot.sim.figure import WAVE_HZ, WAVE_SWING, waving_joint
from engine.robot.sim.floor import floor_map
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path
from engine.robot.sim.scene_parts import FurniturePiece, Person, RoomArea
from engine.skills.servo import gaze
from tests.sim.eye import Eye

SOFA: Final = FurniturePiece(kind="sofa", at=(0, 0), size=(2.1, 0.9, 0.78), turn=180, colour="petrol")
SEATS: Final = {
    "sofa": (SOFA, 0.38),
    "armchair": (FurniturePiece(kind="armchair", at=(0, 0), size=(0.85, 0.85, 0.75), turn=180), 0.38),
    "chair": (FurniturePiece(kind="chair", at=(0, 0), size=(0.42, 0.42, 0.85), turn=180), 0.46),
}
"""What one sits on, and how high that is, m."""
BEDS: Final = {
    "bed": (FurniturePiece(kind="bed", at=(0, 0), size=(1.6, 1.9, 0.9), colour="oak", accent="#7d93a8"), 0.46),
    "sofa": (SOFA, 0.38),
}
LOOKED_AT: Final = {"standing": 1.0, "sitting": 0.8, "lying": 0.5}
"""m: the height that the camera turns to."""
_FEWEST = 0.003  # part of a picture that somebody takes at least who can be found in it
_NAME = "somebody"

Error = tuple[float, float, float]
"""How wrong a pose is believed to be: m, m and rad."""


@dataclass(frozen=True, slots=True)
class Case:
    """Somebody, and what they are on."""

    posture: Posture = "standing"
    on: str = ""
    gesture: Gesture | None = None
    shirt: str = "red"
    trousers: str = "blue"
    height: float = 1.65

    @property
    def piece(self) -> tuple[FurniturePiece, float] | None:
        return None if not self.on else (BEDS if self.posture == "lying" else SEATS)[self.on]

    @property
    def at(self) -> tuple[float, float]:
        if self.posture != "lying":
            return 0.0, 0.0
        return (0.0, -0.1) if self.on == "bed" else (0.1, -0.05)

    @property
    def facing(self) -> float:
        """Degrees. A sofa at turn 180 looks along +y, where the head of a bed is too; on a sofa one lies along x."""
        return 0.0 if self.posture == "lying" and self.on == "sofa" else 90.0


def room(case: Case, *others: Person) -> Scene:
    """With them in the middle, and others."""
    flat, piece = load_scene(scene_path("flat")), case.piece
    person = Person(
        path=(case.at,), posture=case.posture, gesture=case.gesture,
        seat=piece[1] if piece else 0.0 if case.posture == "lying" else 0.42,
        facing=case.facing, shirt=case.shirt, trousers=case.trousers, height=case.height,
    )  # fmt: skip
    wide = (-5.0, 5.0)
    people = {_NAME: person} | {f"other {number}": other for number, other in enumerate(others)}
    return flat.model_copy(
        update={
            "rooms": {"room": RoomArea(x=wide, y=wide)},
            "bounds": flat.bounds.model_copy(update={"x": wide, "y": wide}),
            "doors": (), "landmarks": (), "objects": {}, "lines": {}, "posters": (),
            "furniture": {"seat": piece[0]} if piece else {}, "people": people,
        }
    )  # fmt: skip


class Onlooker:
    """Takes pictures of somebody."""

    def __init__(self, case: Case, *others: Person, width: int = 160) -> None:
        self._case = case
        self._eye = Eye(room(case, *others), width=width, height=width * 3 // 4)
        self.map: FloorMap = floor_map(self._eye.scene)

    def look(self, away: float, side: float = 0.0, *, t: float = 0.0, error: Error = (0.0, 0.0, 0.0)) -> Picture:
        """From ``away`` m, ``side`` degrees counter-clockwise from where they look, at ``t`` s."""
        case, eye = self._case, self._eye
        bearing = math.radians(case.facing + side)
        x, y = case.at[0] + away * math.cos(bearing), case.at[1] + away * math.sin(bearing)
        pose = Pose(x, y, bearing + math.pi)
        if case.gesture == "waving":
            joint = eye.model.joint(waving_joint(_NAME)).qposadr[0]
            eye.data.qpos[joint] = WAVE_SWING * math.sin(2 * math.pi * WAVE_HZ * t)
        believed = Pose(pose.x + error[0], pose.y + error[1], pose.yaw + error[2])
        return eye.look(pose, gaze(ARM, (away, 0.0, LOOKED_AT[case.posture])), believed)

    def hidden(self, picture: Picture) -> bool:
        """Whether furniture hides nearly all of them."""
        model, labels = self._eye.model, picture.labels
        assert labels is not None
        them = [geom for geom in range(model.ngeom) if model.body(model.geom_bodyid[geom]).name.startswith(_NAME)]
        return float(np.mean(np.isin(labels, them))) < _FEWEST
