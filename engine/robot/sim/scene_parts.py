"""What a scene is made of: rooms, doors, furniture, loose objects, lines, signs, people and places.

Lengths are metres in the map frame, angles degrees, because people write degrees. How these are put together and read
from a file is in :mod:`engine.robot.sim.scene`.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from engine.robot.company import Gesture, Posture
from engine.robot.geometry import Pose
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


class Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Area(Part):
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
    aliases: tuple[str, ...] = ()  # other names


class Walls(Part):
    thickness: Length = 0.1
    height: Length = 1.2
    colour: Colour = "white"


class Door(Part):
    """A gap in the wall between two rooms: its centre ``at`` this x (or y) along their common edge."""

    between: tuple[str, str]
    at: float
    width: Length
    closed: bool = Field(default=False, description="A leaf fills the gap; the map does not know.")


class FurniturePiece(Part):
    """Size is length (x), depth (y), height before turning; the front of a piece looks along −y at turn 0.

    The map shows it ``at`` its place, even if it was ``moved`` since, unless it is not ``mapped`` at all.
    """

    kind: FurnitureKind
    at: Point
    size: tuple[Length, Length, Length]
    turn: Literal[0, 90, 180, 270] = 0
    colour: Colour = "oak"
    accent: Colour = "linen"
    moved: Point | None = None
    mapped: bool = True
    aliases: tuple[str, ...] = ()  # other names

    @property
    def stands(self) -> Point:
        """Where its middle is now, map frame, m."""
        return self.moved or self.at

    @property
    def extent(self) -> tuple[float, float]:
        """Size along the map's x and y, m."""
        length, depth, _ = self.size
        return (length, depth) if self.turn % 180 == 0 else (depth, length)

    @property
    def area(self) -> tuple[float, float, float, float]:
        """x_min, y_min, x_max, y_max of where it stands, map frame, m."""
        return self._around(self.stands)

    @property
    def mapped_area(self) -> tuple[float, float, float, float]:
        """The same of where the map has it."""
        return self._around(self.at)

    def _around(self, middle: Point) -> tuple[float, float, float, float]:
        (x, y), (ex, ey) = middle, self.extent
        return x - ex / 2, y - ey / 2, x + ex / 2, y + ey / 2


class LooseObject(Part):
    """Something that can be moved. Size: edge of boxes and blocks, height of cups and bottles, diameter of balls."""

    kind: ObjectKind
    at: Point
    stands_on: str | None = Field(
        default=None, description="Name of the furniture or object it stands on; the floor without."
    )
    size: Length
    height: Length | None = Field(default=None, description="Of a box that is no cube.")
    colour: Colour = "white"
    mass: float = Field(default=0.05, gt=0, le=5, description="kg")
    turn: float = 0.0
    tag: int | None = Field(default=None, ge=0, le=586, description="AprilTag 36h11 id of a tag_block.")
    category: str = Field(default="", description="What people call it and others like it: drinks, fruits.")

    @model_validator(mode="after")
    def _tag_matches_kind(self) -> Self:
        if (self.kind == "tag_block") != (self.tag is not None):
            raise ValueError("a tag_block has a tag, and nothing else has one")
        if self.height is not None and self.kind != "box":
            raise ValueError("only a box has a height of its own")
        return self

    @property
    def tall(self) -> float:
        """From its bottom to its top, m."""
        return self.height or self.size


class FloorLine(Part):
    """A coloured tape on the floor through these points."""

    colour: Colour
    width: Length = 0.03
    points: tuple[Point, ...] = Field(min_length=2)


class Sign(Part):
    """A square sheet that hangs upright: ``at`` and ``z`` are the middle of its face, which looks to ``facing``."""

    at: Point
    z: Length = 0.35
    facing: float = Field(description="Degrees, map frame: 0 looks east, 90 north.")

    @property
    def yaw(self) -> float:
        """``facing`` in rad."""
        return math.radians(self.facing)


class LandmarkTag(Sign):
    """An AprilTag 36h11 that is fixed to the house. Size: edge of its black square."""

    id: int = Field(ge=100, le=586, description="Smaller numbers are those of blocks.")
    size: Length = 0.18


class Poster(Sign):
    """A QR code on a wall. Size: edge of the sheet."""

    text: str = Field(min_length=1, max_length=80)
    size: Length = 0.3


class Person(Part):
    """Somebody who walks round the points of a path for ever, and waits while the robot is in the way.

    One point: stands there, looking to ``facing``; or sits there, with ``seat`` under them, looking there; or lies on
    it, with the head in that direction. What the robot says to them they hear when it is near, and do what people would
    (:mod:`engine.robot.company`).
    """

    path: tuple[Point, ...] = Field(min_length=1)
    speed: float = Field(default=0.4, ge=0, le=1.5, description="m/s")
    height: float = Field(default=1.5, ge=1.0, le=2.0)
    facing: float = 0.0  # degrees
    shirt: Colour = "petrol"
    trousers: Colour = "slate"
    posture: Posture = "standing"
    seat: float = Field(default=0.42, ge=0, le=1, description="m above the floor, of what they sit or lie on.")
    gesture: Gesture | None = None
    called: str | None = Field(default=None, description="The name that they answer with; their key without.")
    gender: Literal["female", "male"] | None = None
    aliases: tuple[str, ...] = ()  # other names
    known: bool = Field(default=False, description="The robot knows them: their name, and what they wear.")
    replies: dict[str, str] = Field(
        default_factory=dict, description="What they answer to a question that has this word in it."
    )
    leads: tuple[Point, ...] = Field(default=(), description="Where they walk, once, to be followed.")
    strays: float | None = Field(
        default=None, gt=0, description="m behind the robot after which they stop once, until they are called."
    )
    holds: str | None = Field(default=None, description="The loose object in their hand.")
    gives_tasks: bool = Field(
        default=False,
        description="Who types or speaks to the robot: they answer no question, because that one does, and lead to any "
        "room, furniture or place of the scene that the robot says it follows them to.",
    )


class ScenePlace(Part):
    """A place that the robot can be sent to; its key is what people call it."""

    at: Point
    yaw: float = 0.0  # degrees
    aliases: tuple[str, ...] = ()


class KeepOut(Area):
    """Floor that the robot must not enter, though nothing stands there."""

    name: str


class Start(Part):
    x: float
    y: float
    yaw: float = 0.0  # degrees

    @property
    def pose(self) -> Pose:
        return Pose(self.x, self.y, math.radians(self.yaw))
