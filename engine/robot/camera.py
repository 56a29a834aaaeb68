"""What a camera sees: a picture with depth, taken from a known place, and the geometry between pixels and metres.

The *optical frame* is that of the camera: x to the right of the picture, y down, z along the line of sight. A pixel is
(column, row), counted from the picture's upper left corner; its centre is at the half. A :class:`Picture` knows where
it was taken, so that everything in it can be placed in the base frame, and on the map as well as the robot knows its
own pose.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.robot.geometry import Pose

Points = NDArray[np.float64]
"""Points, one a row: shape (n, 3), m."""


@dataclass(frozen=True, slots=True)
class Lens:
    """Intrinsics of a pinhole camera without distortion, in pixels."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    @classmethod
    def of_view(cls, width: int, height: int, fovy: float) -> Lens:
        """Square pixels; ``fovy`` is the vertical field of view, rad."""
        focal = height / 2 / math.tan(fovy / 2)
        return cls(width, height, focal, focal, width / 2, height / 2)

    @property
    def matrix(self) -> NDArray[np.float64]:
        """As OpenCV wants it, shape (3, 3); its pixels have their centres at whole numbers."""
        return np.array([[self.fx, 0, self.cx - 0.5], [0, self.fy, self.cy - 0.5], [0, 0, 1.0]])

    def project(self, points: Points) -> NDArray[np.float64]:
        """Where points of the optical frame appear, shape (n, 2), pixels; only those with z > 0 have a meaning."""
        z = points[:, 2]
        return np.column_stack((self.fx * points[:, 0] / z + self.cx, self.fy * points[:, 1] / z + self.cy))

    def rays(self, pixels: NDArray[np.float64]) -> Points:
        """Directions through pixels, optical frame, with z = 1; ``pixels`` has shape (n, 2)."""
        x = (pixels[:, 0] - self.cx) / self.fx
        y = (pixels[:, 1] - self.cy) / self.fy
        return np.column_stack((x, y, np.ones(len(pixels))))

    def grid(self) -> Points:
        """The directions through all pixel centres, row by row: shape (height · width, 3). Nobody may change them."""
        return _grid(self)


@lru_cache(maxsize=4)
def _grid(lens: Lens) -> Points:
    columns, rows = np.meshgrid(np.arange(lens.width) + 0.5, np.arange(lens.height) + 0.5)
    rays = lens.rays(np.column_stack((columns.ravel(), rows.ravel())))
    rays.flags.writeable = False
    return rays


@dataclass(frozen=True, slots=True)
class Mount:
    """Where a camera is: its optical frame, seen from another frame."""

    rotation: NDArray[np.float64]  # shape (3, 3); its columns are the optical axes
    position: NDArray[np.float64]  # shape (3,), m

    def out(self, points: Points) -> Points:
        """From the optical frame to the outer one."""
        found: Points = points @ self.rotation.T + self.position
        return found

    def into(self, points: Points) -> Points:
        """From the outer frame to the optical one."""
        found: Points = (points - self.position) @ self.rotation
        return found


TILT: Final = math.radians(1.0)
"""By how much a camera looks up or down otherwise than it is thought to: a wheel on a carpet's edge does that."""


def floor_depth(lens: Lens, mount: Mount, farthest: float = 4.0) -> NDArray[np.float32]:
    """The depth that every pixel would have if it showed the floor, shape (height, width), m along the optical z; inf
    above the horizon and beyond ``farthest``. For a camera that measures none: right on the floor, too far above it."""
    down = (lens.grid() @ mount.rotation.T)[:, 2]
    with np.errstate(divide="ignore"):
        depth = np.where(down < 0, -mount.position[2] / down, np.inf)
    depth[depth > farthest] = np.inf
    return depth.reshape(lens.height, lens.width).astype(np.float32)


def floor_error(height: float, away: float) -> float:
    """How wrong a distance by :func:`floor_depth` may be, m, ``away`` m before a camera that is ``height`` m above the
    floor: a place that is seen ``TILT`` too high or too low."""
    return TILT * (away * away + height * height) / height


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """One picture. Nobody changes its arrays."""

    t: float  # robot time at which it was taken, s
    rgb: NDArray[np.uint8]  # shape (height, width, 3)
    depth: NDArray[np.float32]  # shape (height, width), m along the optical z; inf where nothing is in range
    lens: Lens
    mount: Mount  # in the base frame, by the arm's measured joints
    pose: Pose  # of the base at that time, as the robot believed
    labels: NDArray[np.int32] | None = None  # geom ids for debugging, −1 for none; no skill may use them
    guessed: bool = False  # its depth is that of the floor, and none was measured

    def points(self, mask: NDArray[np.bool_] | None = None) -> Points:
        """What the pixels show, base frame: all of them row by row, or those of ``mask`` (height, width). Pixels
        without depth are at infinity, or not a number."""
        rays, depth = self.lens.grid(), self.depth.ravel()
        if mask is not None:
            chosen = np.flatnonzero(mask)
            rays, depth = rays[chosen], depth[chosen]
        return self.mount.out(rays * depth.astype(np.float64)[:, None])

    def on_map(self, points: Points) -> Points:
        """From the base frame to the map frame."""
        c, s = math.cos(self.pose.yaw), math.sin(self.pose.yaw)
        x, y = points[:, 0], points[:, 1]
        return np.column_stack((self.pose.x + c * x - s * y, self.pose.y + s * x + c * y, points[:, 2]))

    def from_map(self, points: Points) -> Points:
        """From the map frame to the base frame."""
        c, s = math.cos(self.pose.yaw), math.sin(self.pose.yaw)
        x, y = points[:, 0] - self.pose.x, points[:, 1] - self.pose.y
        return np.column_stack((c * x + s * y, c * y - s * x, points[:, 2]))

    def pixels(self, points: Points) -> NDArray[np.float64]:
        """Where points of the base frame appear, shape (n, 2); not a number for those behind the camera."""
        seen = self.mount.into(points)
        seen[seen[:, 2] <= 0] = np.nan
        return self.lens.project(seen)
