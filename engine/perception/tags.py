"""AprilTags of the family 36h11: which ones a picture shows, where they are and which way they face.

Small pictures are enlarged before they are read, so that eleven pixels are enough for a tag. Where it is follows from
its corners and its known size, and again, without any size, from the depth of its face. The two are weighed by their
errors; a pattern whose size in metres or shape contradicts the depth is no tag.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.perception.sighting import TagSighting
from engine.robot.camera import Lens, Picture, Points
from engine.robot.floor_map import Landmark

BLOCK_TAG: Final = 0.036
"""Edge of the black square on a tag block of 4.5 cm, m: eight of its ten cells."""
PIXEL_ERROR: Final = 0.3
"""Standard deviation of a corner, pixels."""
DEPTH_ERROR: Final = 0.003
"""Standard deviation of the depth of a face: m, and a fraction of the depth as well."""

_ENLARGED = 640  # pixels of width that the reader works on
_SIZES = (0.015, 0.6)  # m, of anything that may be a tag
_SQUARE = 1.45  # the longest side over the shortest, of what may be a tag
_SAME_SIZE = 1.3  # measured over known
_FEWEST = 5  # depths that make a face
_OUTWARDS = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) / 2  # corners in the order of IPPE_SQUARE

Corners = NDArray[np.float64]
"""Shape (4, 2), pixels: upper left, upper right, lower right, lower left of the tag."""


@dataclass(frozen=True, slots=True)
class Face:
    """A tag's plane in the optical frame."""

    middle: NDArray[np.float64]  # m
    normal: NDArray[np.float64]  # towards the camera
    sides: tuple[float, ...]  # m, the lengths of the four sides


def find_tags(picture: Picture, landmarks: Sequence[Landmark] = ()) -> tuple[TagSighting, ...]:
    """The tags in a picture, the nearest first. ``landmarks`` gives the sizes of those that are fixed to the house."""
    found = []
    for number, corners in read(picture.rgb):
        sighting = _locate(picture, number, corners, landmarks)
        if sighting is not None:
            found.append(sighting)
    return tuple(sorted(found, key=lambda tag: tag.range))


def read(rgb: NDArray[np.uint8]) -> list[tuple[int, Corners]]:
    """The numbers and corners of everything that looks like a tag."""
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
    scale = max(1, round(_ENLARGED / grey.shape[1]))
    if scale > 1:
        grey = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_LANCZOS4)
    corners, numbers, _ = _reader().detectMarkers(grey)
    if not len(corners):  # then there are no numbers either
        return []
    return [
        (int(number), (np.asarray(corner, dtype=np.float64).reshape(4, 2) + 0.5) / scale)
        for number, corner in zip(numbers.ravel(), corners, strict=True)
    ]


@cache
def _reader() -> cv2.aruco.ArucoDetector:
    """Tuned on pictures of tags of 9 to 19 pixels, turned by up to 40°, with one sample a pixel: reads 148 of 165 where
    the defaults, enlarged as much, read 108. That it believes tags with wrong cells is made up for by the depth."""
    settings = cv2.aruco.DetectorParameters()
    settings.adaptiveThreshWinSizeMin, settings.adaptiveThreshWinSizeMax = 15, 39
    settings.adaptiveThreshWinSizeStep = 24
    settings.adaptiveThreshConstant = 3
    settings.perspectiveRemovePixelPerCell = 8
    settings.perspectiveRemoveIgnoredMarginPerCell = 0.3
    settings.errorCorrectionRate = 0.8  # four of the five wrong cells that the family could mend
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    return cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11), settings)


def _locate(picture: Picture, number: int, corners: Corners, landmarks: Sequence[Landmark]) -> TagSighting | None:
    """Where a tag is; None when it cannot be one."""
    known = next((landmark.size for landmark in landmarks if landmark.id == number), None)
    face = face_of(picture, corners)
    size = known or BLOCK_TAG
    if face is not None:
        measured = sum(face.sides) / 4
        if max(face.sides) > _SQUARE * min(face.sides) or not _SIZES[0] < measured < _SIZES[1]:
            return None
        alike = [each for each in (known, BLOCK_TAG) if each and 1 / _SAME_SIZE < measured / each < _SAME_SIZE]
        size = alike[0] if alike else measured
    guesses = _by_corners(picture.lens, corners, size)
    if face is None:
        if not guesses:
            return None
        middle, normal = guesses[0]
        error = _corner_error(picture.lens, middle, size)
    else:
        middle, normal, error = _weighed(picture.lens, face, [guess for guess, _ in guesses], size)
    place = picture.on_map(picture.mount.out(middle[None]))[0]
    ahead = picture.on_map(picture.mount.out((middle + normal)[None]))[0] - place
    return TagSighting(
        id=number,
        corners=corners,
        position=(float(place[0]), float(place[1]), float(place[2])),
        normal=(float(ahead[0]), float(ahead[1]), float(ahead[2])),
        size=size,
        range=float(np.linalg.norm(middle)),
        sigma=error,
    )


def face_of(picture: Picture, corners: Corners) -> Face | None:
    """The plane that the depth inside the corners shows; None without depth."""
    height, width = picture.depth.shape
    inside = np.zeros((height, width), dtype=np.uint8)
    cv2.fillConvexPoly(inside, np.round((corners - 0.5) * 256).astype(np.int32), 1, shift=8)
    rows, columns = np.nonzero(inside)
    depth = picture.depth[rows, columns].astype(np.float64)
    good = np.isfinite(depth) & (depth > 0)
    if np.count_nonzero(good) < _FEWEST:
        return None
    rays = picture.lens.rays(np.column_stack((columns[good] + 0.5, rows[good] + 0.5)))
    # A plane is linear in the inverse of depth: 1/z = a·x + b·y + c on the rays with z = 1.
    plane = robust_fit(rays, 1 / depth[good])
    at_corners = picture.lens.rays(corners)
    inverse = at_corners @ plane
    if not (inverse > 0).all():
        return None
    points = at_corners / inverse[:, None]
    sides = tuple(float(np.linalg.norm(points[i] - points[i - 1])) for i in range(4))
    ray = picture.lens.rays(_crossing(corners)[None])[0]
    return Face(ray / float(ray @ plane), -plane / float(np.linalg.norm(plane)), sides)


def robust_fit(rays: Points, inverse: NDArray[np.float64]) -> NDArray[np.float64]:
    """The plane through most of the points: what is off after the first fit, such as the ground behind an edge, is
    left out of the second."""
    plane = np.asarray(np.linalg.lstsq(rays, inverse, rcond=None)[0], dtype=np.float64)
    off = np.abs(rays @ plane - inverse)
    kept = off <= max(3 * float(np.median(off)), 1e-9)
    if _FEWEST <= np.count_nonzero(kept) < len(kept):
        plane = np.asarray(np.linalg.lstsq(rays[kept], inverse[kept], rcond=None)[0], dtype=np.float64)
    return plane


def _crossing(corners: Corners) -> NDArray[np.float64]:
    """Where the diagonals cross: the picture of the tag's middle."""
    (a, b, c, d) = corners
    along, across = c - a, d - b
    span = along[0] * across[1] - along[1] * across[0]
    if abs(span) < 1e-9:
        middle: NDArray[np.float64] = corners.mean(axis=0)
        return middle
    part = ((b - a)[0] * across[1] - (b - a)[1] * across[0]) / span
    found: NDArray[np.float64] = a + part * along
    return found


def _by_corners(lens: Lens, corners: Corners, size: float) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Middle and normal, optical frame, as the corners alone tell: two guesses, the better first. A small tag looks
    nearly the same when it is tilted the other way."""
    count, rotations, places, _ = cv2.solvePnPGeneric(
        _OUTWARDS * size, corners - 0.5, lens.matrix, None, flags=cv2.SOLVEPNP_IPPE_SQUARE
    )
    found = []
    for i in range(count):
        middle = np.asarray(places[i], dtype=np.float64).ravel()
        normal = np.asarray(cv2.Rodrigues(rotations[i])[0], dtype=np.float64)[:, 2]
        if np.isfinite(middle).all() and middle[2] > 0:
            found.append((middle, normal))
    return found


def _weighed(
    lens: Lens, face: Face, guesses: list[NDArray[np.float64]], size: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Middle, normal and error of the middle, from the depth and, as far as they agree, from the corners."""
    by_depth = DEPTH_ERROR * (1 + float(face.middle[2]))
    near = min(guesses, key=lambda guess: float(np.linalg.norm(guess - face.middle)), default=face.middle)
    by_corners = _corner_error(lens, face.middle, size)
    if float(np.linalg.norm(near - face.middle)) > 3 * math.hypot(by_depth, by_corners):
        return face.middle, face.normal, 2 * by_depth
    share = by_depth**2 / (by_depth**2 + by_corners**2)
    error = by_depth * by_corners / math.hypot(by_depth, by_corners)
    sideways = PIXEL_ERROR / 2 / lens.fx * float(face.middle[2])
    return face.middle + share * (near - face.middle), face.normal, math.hypot(error, sideways)


def _corner_error(lens: Lens, middle: NDArray[np.float64], size: float) -> float:
    """What an error of the corners makes of the distance, m."""
    distance = float(middle[2])
    return distance * PIXEL_ERROR / max(lens.fx * size / distance, 1.0)
