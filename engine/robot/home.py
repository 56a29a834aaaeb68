"""Where a robot lives, whichever it is: the map of the house, its places by name, and what things are called there."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from config.schema import KnownPerson, Place
from config.schema import Robot as RobotSettings
from engine.robot.clearance import Points
from engine.robot.floor_map import FloorMap
from engine.robot.geometry import Pose
from engine.robot.host.envelope import fence


@dataclass(frozen=True, slots=True)
class Thing:
    """A thing that has a name here: what it looks like in words ("brown box"), which may be none that are known."""

    name: str
    looks: str
    category: str = ""
    """What it and others like it are called: ``drinks``."""


@dataclass(frozen=True, slots=True)
class Home:
    """A house as it was mapped."""

    name: str
    key: str
    """Like no other house's, for what is kept of it."""
    floor_map: FloorMap
    start: Pose
    """Where the robot is put down, map frame."""
    places: Mapping[str, Place]
    """By symbol; empty where the configuration names them."""
    things: tuple[Thing, ...]
    called: Mapping[str, str]
    """Other names of rooms and furniture, and the ones that the map has."""
    people: Mapping[str, KnownPerson]
    """Whom the robot knows there, by name."""
    fences: tuple[tuple[float, float, float, float], ...]
    """Rectangles (x_min, y_min, x_max, y_max) whose outlines the robot must not cross, map frame, m."""

    def edges(self, *, blind: bool) -> Points:
        """Points that the hull may not cross, map frame, shape (n, 2), m: the fences, and for a robot that sees nothing
        in its way, all that the map knows to stand there."""
        fences = fence(self.fences)
        if not blind:
            return fences
        floor = self.floor_map
        rows, columns = np.nonzero(_rim(floor.occupied))
        cells = np.column_stack((columns, rows)) + 0.5
        return np.concatenate((fences, np.array(floor.origin) + floor.resolution * cells))


def home(settings: RobotSettings) -> Home:
    """The house of the configured robot. Raises ``SceneError``."""
    if settings.map is None:
        return _home(settings.scene)
    path = Path(settings.map).expanduser().absolute()
    try:
        changed = path.stat().st_mtime_ns
    except OSError:
        changed = 0  # whoever reads it says so
    return _mapped(path, changed)


@lru_cache(maxsize=2)
def _mapped(path: Path, changed: int) -> Home:
    """A house of which there is nothing but a map: the robot is put down where the map was begun."""
    from engine.robot.saved_map import read_map

    floor = read_map(path)
    rows, columns = floor.occupied.shape
    x, y = floor.origin
    fence = (x, y, x + columns * floor.resolution, y + rows * floor.resolution)
    key = f"{path.stem}-{hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:8]}"
    return Home(path.stem, key, floor, Pose(0.0, 0.0, 0.0), {}, (), {}, {}, (fence,))


@lru_cache(maxsize=8)
def _home(scene: str) -> Home:
    from engine.robot.sim.floor import floor_map
    from engine.robot.sim.scene_file import load_scene, scene_path

    loaded = load_scene(scene_path(scene))
    named = [(name, room.aliases) for name, room in loaded.rooms.items()]
    named += [(name, piece.aliases) for name, piece in loaded.furniture.items()]
    return Home(
        name=loaded.name,
        key=loaded.name,
        floor_map=floor_map(loaded),
        start=loaded.start.pose,
        places=loaded.known_places(),
        things=tuple(
            Thing(name, f"{thing.colour} {thing.kind}", thing.category) for name, thing in loaded.objects.items()
        ),
        called={word: name for name, words in named for word in words},
        people=loaded.known_people(),
        fences=tuple(loaded.edges()),
    )


def _rim(occupied: np.ndarray) -> np.ndarray:
    """Cells at which something begins: those inside can't be reached."""
    free = np.pad(~occupied, 1, constant_values=True)
    beside = free[:-2, 1:-1] | free[2:, 1:-1] | free[1:-1, :-2] | free[1:-1, 2:]
    found: np.ndarray = occupied & beside
    return found
