"""Scene files: a dwelling described in YAML that a person can read and change.

Rooms are rectangles; walls stand on their edges, with doors as gaps between two rooms. Furniture and loose objects
are placed by name, and an object may stand on a piece of furniture. Lengths are metres in the map frame, angles
degrees, because people write degrees. A mistake raises :class:`SceneError` naming the file and the key.
"""

from __future__ import annotations

import difflib
import math
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from engine.errors import SceneError
from engine.robot.robot import Pose
from engine.robot.sim.colours import Colour

Span = tuple[float, float]
"""Lower and upper end, m."""
Point = tuple[float, float]
"""x and y in the map frame, m."""
Length = Annotated[float, Field(gt=0, le=50)]

FurnitureKind = Literal[
    "table", "low_table", "sofa", "armchair", "chair", "bed", "wardrobe", "shelf", "desk", "counter", "bin", "dock",
    "plant", "carton", "rug",
]  # fmt: skip
ObjectKind = Literal["box", "cup", "bottle", "ball", "tag_block"]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Area(_Part):
    """An upright rectangle of floor."""

    x: Span
    y: Span

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.x[0] >= self.x[1] or self.y[0] >= self.y[1]:
            raise ValueError("x and y are written [lower, upper]")
        return self

    def contains(self, x: float, y: float) -> bool:
        return self.x[0] <= x <= self.x[1] and self.y[0] <= y <= self.y[1]


class RoomArea(Area):
    """A room; its floor may have a colour and a pattern."""

    colour: Colour = "birch"
    floor: Literal["planks", "tiles", "plain"] = "planks"


class Walls(_Part):
    thickness: Length = 0.1
    height: Length = 1.2
    colour: Colour = "white"


class Door(_Part):
    """A gap in the wall between two rooms: its centre ``at`` this x (or y) along their common edge."""

    between: tuple[str, str]
    at: float
    width: Length


class FurniturePiece(_Part):
    """Size is length (x), depth (y), height before turning; the front of a piece looks along −y at turn 0."""

    kind: FurnitureKind
    at: Point
    size: tuple[Length, Length, Length]
    turn: Literal[0, 90, 180, 270] = 0
    colour: Colour = "oak"
    accent: Colour = "linen"

    @property
    def extent(self) -> tuple[float, float]:
        """Size along the map's x and y, m."""
        length, depth, _ = self.size
        return (length, depth) if self.turn % 180 == 0 else (depth, length)

    @property
    def area(self) -> tuple[float, float, float, float]:
        """x_min, y_min, x_max, y_max in the map frame, m."""
        (x, y), (ex, ey) = self.at, self.extent
        return x - ex / 2, y - ey / 2, x + ex / 2, y + ey / 2


class LooseObject(_Part):
    """Something that can be moved. Size: edge of boxes and blocks, height of cups and bottles, diameter of balls."""

    kind: ObjectKind
    at: Point
    stands_on: str | None = Field(default=None, description="Name of the furniture it stands on; the floor without.")
    size: Length
    colour: Colour = "white"
    mass: float = Field(default=0.05, gt=0, le=5, description="kg")
    turn: float = 0.0
    tag: int | None = Field(default=None, ge=0, le=586, description="AprilTag 36h11 id of a tag_block.")

    @model_validator(mode="after")
    def _tag_matches_kind(self) -> Self:
        if (self.kind == "tag_block") != (self.tag is not None):
            raise ValueError("a tag_block has a tag, and nothing else has one")
        return self


class FloorLine(_Part):
    """A coloured tape on the floor through these points."""

    colour: Colour
    width: Length = 0.03
    points: tuple[Point, ...] = Field(min_length=2)


class KeepOut(Area):
    """Floor that the robot must not enter, though nothing stands there."""

    name: str


class Start(_Part):
    x: float
    y: float
    yaw: float = 0.0  # degrees

    @property
    def pose(self) -> Pose:
        return Pose(self.x, self.y, math.radians(self.yaw))


class Scene(_Part):
    """A whole scene. ``bounds`` is the workspace of the robot."""

    name: str
    bounds: Area
    start: Start
    walls: Walls = Walls()
    rooms: dict[str, RoomArea] = Field(min_length=1)
    doors: tuple[Door, ...] = ()
    furniture: dict[str, FurniturePiece] = {}
    objects: dict[str, LooseObject] = {}
    lines: dict[str, FloorLine] = {}
    keep_out: tuple[KeepOut, ...] = ()

    @model_validator(mode="after")
    def _names_exist_and_things_are_inside(self) -> Self:
        for index, door in enumerate(self.doors):
            for room in door.between:
                _must_know(room, self.rooms, f"doors.{index}.between", "room")
        for name, loose in self.objects.items():
            if loose.stands_on is not None:
                _must_know(loose.stands_on, self.furniture, f"objects.{name}.stands_on", "piece of furniture")
                x0, y0, x1, y1 = self.furniture[loose.stands_on].area
                if not (x0 <= loose.at[0] <= x1 and y0 <= loose.at[1] <= y1):
                    raise ValueError(f"objects.{name}: at {loose.at} is not on the {loose.stands_on}")
        placed = [(f"furniture.{n}", f.at) for n, f in self.furniture.items()]
        placed += [(f"objects.{n}", o.at) for n, o in self.objects.items()]
        placed.append(("start", (self.start.x, self.start.y)))
        for key, (x, y) in placed:
            if not self.bounds.contains(x, y):
                raise ValueError(f"{key}: ({x:g}, {y:g}) is outside the bounds")
        for zone in self.keep_out:
            if zone.contains(self.start.x, self.start.y):
                raise ValueError(f"start: lies inside the keep-out zone {zone.name}")
        return self


def _must_know(name: str, known: dict[str, Any], key: str, what: str) -> None:
    if name not in known:
        near = difflib.get_close_matches(name, known, 1, 0.5)
        ask = f"; did you mean {near[0]}?" if near else f"; there are {', '.join(known) or 'none'}"
        raise ValueError(f"{key}: no {what} is called {name!r}{ask}")


def scene_path(name: str) -> Path:
    """Where a scene is: the name of one that comes with sayso, or a path. Raises :class:`SceneError`."""
    if name.endswith((".yaml", ".yml")) or "/" in name:
        path = Path(name).expanduser()
        if not path.is_file():
            raise SceneError(f"There is no scene file {path}.", hint="Check robot.scene in your configuration.")
        return path.resolve()
    folder = Path(str(resources.files("assets") / "scenes"))
    path = folder / f"{name}.yaml"
    if not path.is_file():
        known = sorted(p.stem for p in folder.glob("*.yaml"))
        near = difflib.get_close_matches(name, known, 1, 0.5)
        raise SceneError(
            f"There is no scene called {name!r}.",
            hint=f"Did you mean {near[0]}?" if near else f"There are: {', '.join(known)}.",
        )
    return path


def load_scene(path: Path) -> Scene:
    """Read a scene file. Raises :class:`SceneError` that names the file and the key."""
    try:
        raw = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"The scene {path} cannot be read: {error}.") from error
    except yaml.YAMLError as error:
        raise SceneError(f"The scene {path} is not YAML: {error}.") from error
    try:
        return Scene.model_validate(raw)
    except ValidationError as error:
        raise SceneError(f"The scene {path} is wrong: {_first_fault(error)}.", hint=_more(error)) from error


def _first_fault(error: ValidationError) -> str:
    fault = error.errors()[0]
    key = ".".join(str(part) for part in fault["loc"])
    text = fault["msg"].removeprefix("Value error, ")
    if fault["type"] == "extra_forbidden":
        text = "this key means nothing here"
    return f"{key}: {text}" if key else text


def _more(error: ValidationError) -> str:
    rest = error.error_count() - 1
    return f"And {rest} more." if rest else ""
