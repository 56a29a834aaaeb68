"""What was seen in one picture: the facts that perception hands on.

Positions are in the map frame as well as the robot knew its own pose when the picture was taken. ``sigma`` is one
standard deviation of a horizontal position; it grows with distance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from engine.events import Value
from engine.robot.camera import Picture
from engine.robot.company import Gesture, Posture

Kind = Literal["box", "ball", "cup", "bottle", "block", "person", "thing"]
"""``block`` is a box with tags on its faces; ``thing`` is what has no shape that is known."""

Part = Literal["people", "things", "tags"]
"""What can be looked for apart from the rest."""
EVERYTHING: Final[frozenset[Part]] = frozenset({"people", "things", "tags"})

Colour = Literal["red", "orange", "yellow", "green", "blue", "purple", "white", "grey", "black"]
"""Colours that are told apart."""

PixelBox = tuple[int, int, int, int]
"""Left, top, right, bottom; the last two are just outside."""


@dataclass(frozen=True, slots=True)
class Figure:
    """How somebody was seen; None where it did not show."""

    posture: Posture | None = None
    gesture: Gesture | None = None  # in this picture alone: an arm that is up may be waving
    shirt: Colour | None = None  # the colour of the sighting, where that is their shirt's
    trousers: Colour | None = None
    hand: tuple[float, float, float] | None = None  # the one that is up or points, map frame, m
    facing: float | None = None  # map frame, rad


@dataclass(frozen=True, slots=True)
class Sighting:
    """One loose thing, or one person, in one picture."""

    kind: Kind
    colour: Colour
    box: PixelBox
    position: tuple[float, float, float]  # of its middle, map frame, m
    sigma: float  # m
    size: tuple[float, float]  # width and height, m
    range: float  # from the camera, m
    surface: float  # height of what it stands on, m: 0 is the floor
    yaw: float | None = None  # of its sides, map frame, rad modulo π/2, where they show
    tag: int | None = None  # on it, or on somebody's clothes
    complete: bool = True  # neither cut off by the picture's edge nor partly behind something
    figure: Figure | None = None  # of a person

    @property
    def name(self) -> str:
        """What people would call it: ``red box``, ``block 3``."""
        if self.kind == "person":
            return self.kind
        return f"block {self.tag}" if self.tag is not None else f"{self.colour} {self.kind}"


@dataclass(frozen=True, slots=True, eq=False)
class TagSighting:
    """One AprilTag of the family 36h11 in one picture."""

    id: int
    corners: NDArray[np.float64]  # shape (4, 2), pixels: upper left, upper right, lower right, lower left of the tag
    position: tuple[float, float, float]  # of its middle, map frame, m
    normal: tuple[float, float, float]  # of its face, map frame
    size: float  # edge of the black square, m
    range: float  # from the camera, m
    sigma: float  # m


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """A picture and what is in it."""

    picture: Picture
    objects: tuple[Sighting, ...]  # the nearest first
    tags: tuple[TagSighting, ...]

    @property
    def t(self) -> float:
        """Robot time at which the picture was taken, s."""
        return self.picture.t


def as_json(thing: Sighting) -> dict[str, Value]:
    """As it stands in a ``perception.result``."""
    left, top, right, bottom = thing.box
    x, y, z = thing.position
    return {
        "name": thing.name, "x1": left, "y1": top, "x2": right, "y2": bottom, "range": round(thing.range, 3),
        "x": round(x, 3), "y": round(y, 3), "z": round(z, 3), "sigma": round(thing.sigma, 3),
    }  # fmt: skip
