"""QR codes: what they say, where they are and which way they face.

Whatever is black and white all over may be a code. Depth tells its plane, so that it can be looked at from straight
ahead, upright. There the grid that suits the three finder patterns best is laid over it, the cells are sampled and
drawn anew, and that clean picture is what is read: a pixel and a half for a cell are enough. A code that does not
hang upright is left to a reader that finds its own way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from engine.robot.camera import Picture

if TYPE_CHECKING:
    import cv2

_ENLARGED: Final = 640  # pixels of width that the reader of turned codes works on
_OWN: Final = 0.2  # m from the camera that only the hand is
_CONTRAST, _PALE = 80, 40  # grey levels between black and white next to each other, and between a pixel's colours
_SMALLEST, _FILLED = 18, 0.5  # pixels across a code, and how much of the rectangle around it is black and white
_STRAIGHT: Final = 400  # pixels across what is looked at from straight ahead
_VERSIONS: Final = range(1, 7)  # 21 cells to a side, and four more for each
_DOUBTFUL, _LIKELY = 0.25, 0.6  # agreement with the finder patterns from which a grid is refined, and is one
_CLEAN: Final = 8  # pixels to a cell of what is drawn anew
_MARGIN: Final = 4  # cells

Corners = NDArray[np.float64]
"""Shape (4, 2), pixels: upper left, upper right, lower right, lower left of the code."""
Grey = NDArray[np.uint8]
Grid = NDArray[np.float64]
"""Left, upper, right and lower end of a code that is seen from straight ahead, pixels."""


@dataclass(frozen=True, slots=True, eq=False)
class CodeSighting:
    """One QR code in one picture."""

    text: str
    corners: Corners
    position: tuple[float, float, float]  # of its middle, map frame, m
    normal: tuple[float, float, float]  # of its face, map frame
    size: float  # edge of the code without its margin, m
    range: float  # from the camera, m


def find_qr(picture: Picture) -> tuple[CodeSighting, ...]:
    """The QR codes in a picture that can be read, the nearest first. Those without depth are left out: their size is
    not known, so nobody could tell where they are."""
    import cv2  # slow to import, and not every program that knows of codes has pictures

    grey: Grey = np.asarray(cv2.cvtColor(picture.rgb, cv2.COLOR_RGB2GRAY), dtype=np.uint8)
    patches = list(_patches(picture, grey))
    codes = [code for patch in patches if (code := _upright(picture, grey, patch)) is not None]
    if len(codes) < len(patches):
        codes += [code for code in _turned(grey) if not any(_same(code[1], known) for _, known in codes)]
    found = (_located(picture, text, corners) for text, corners in codes)
    return tuple(sorted((code for code in found if code is not None), key=lambda code: code.range))


def _located(picture: Picture, text: str, corners: Corners) -> CodeSighting | None:
    from engine.perception.tags import face_of

    face = face_of(picture, corners)
    if face is None:
        return None
    place, ahead = picture.on_map(picture.mount.out(np.array([face.middle, face.middle + face.normal])))
    return CodeSighting(
        text,
        corners,
        (float(place[0]), float(place[1]), float(place[2])),
        (float(ahead[0] - place[0]), float(ahead[1] - place[1]), float(ahead[2] - place[2])),
        sum(face.sides) / 4,
        float(np.linalg.norm(face.middle)),
    )


def _same(one: Corners, other: Corners) -> bool:
    apart = np.linalg.norm(one.mean(axis=0) - other.mean(axis=0))
    return bool(apart < np.ptp(other, axis=0).max() / 2)


def _patches(picture: Picture, grey: Grey) -> Iterator[NDArray[np.bool_]]:
    """What is black and white all over, and not the robot's own hand."""
    import cv2

    reach = round(picture.lens.width / 36) | 1  # cells of a code that fills the picture
    around = np.ones((reach, reach), dtype=np.uint8)
    contrast = np.asarray(cv2.morphologyEx(grey, cv2.MORPH_GRADIENT, around))
    own = cv2.dilate((picture.depth < _OWN).astype(np.uint8), around) > 0
    pale = np.ptp(picture.rgb, axis=2) < _PALE
    mask = (contrast > _CONTRAST) & pale & ~own & np.isfinite(picture.depth)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    for label in range(1, count):
        _, _, width, height, area = stats[label]
        if min(width, height) >= _SMALLEST and area > _FILLED * width * height:
            yield labels == label


def _upright(picture: Picture, grey: Grey, patch: NDArray[np.bool_]) -> tuple[str, Corners] | None:
    """Text and corners of a code that hangs upright."""
    import cv2

    outline = _outline(picture, patch)
    if outline is None:
        return None
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float32) * _STRAIGHT
    into = cv2.getPerspectiveTransform(outline.astype(np.float32) - np.float32(0.5), square)
    straight = cv2.warpPerspective(
        grey, into, (_STRAIGHT, _STRAIGHT), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
    )
    laid = _lay(np.asarray(straight, dtype=np.uint8))
    if laid is None:
        return None
    cells, (left, top, right, bottom) = laid
    text = _text(cells)
    if not text:
        return None
    ends = np.array([[[left, top], [right, top], [right, bottom], [left, bottom]]])
    return text, cv2.perspectiveTransform(ends, np.linalg.inv(into))[0] + 0.5


def _outline(picture: Picture, patch: NDArray[np.bool_]) -> Corners | None:
    """Corners of the upright rectangle around a patch in the plane that its depth shows, pixels; None when it lies."""
    from engine.perception.tags import robust_fit

    rows, columns = np.nonzero(patch)
    depth = picture.depth[rows, columns].astype(np.float64)
    rays = picture.lens.rays(np.column_stack((columns + 0.5, rows + 0.5)))
    plane = robust_fit(rays, 1 / depth)
    inwards = plane / np.linalg.norm(plane)
    down = -picture.mount.rotation[2]  # the optical frame's own view of it
    down = down - inwards * (down @ inwards)
    if np.linalg.norm(down) < 0.2:
        return None
    down /= np.linalg.norm(down)
    right = np.cross(down, inwards)
    points = rays / (rays @ plane)[:, None]
    middle = points.mean(axis=0)
    across, along = (points - middle) @ right, (points - middle) @ down
    (near, far), (top, bottom) = ((values.min(), values.max()) for values in (across, along))
    ends = ((near, top), (far, top), (far, bottom), (near, bottom))
    corners = np.array([middle + x * right + y * down for x, y in ends])
    if (corners[:, 2] < 0.01).any():
        return None
    on_picture: Corners = (corners / corners[:, 2:] @ picture.lens.matrix.T)[:, :2]
    return on_picture


def _lay(straight: Grey) -> tuple[NDArray[np.bool_], Grid] | None:
    """The cells of a code, True is black, and where its grid lies."""
    import cv2

    limit, _ = cv2.threshold(straight, 0, 255, cv2.THRESH_OTSU)
    dark = straight < limit
    columns, rows = np.flatnonzero(dark.mean(axis=0) > 0.05), np.flatnonzero(dark.mean(axis=1) > 0.05)
    if not len(columns) or not len(rows):
        return None
    around = np.array([columns[0], rows[0], columns[-1] + 1, rows[-1] + 1], dtype=np.float64)
    fits = [(*_refined(straight, around, _finders(version)), _finders(version)) for version in _VERSIONS]
    agreement, grid, finders = max(fits, key=lambda fit: fit[0])
    if agreement < _LIKELY:
        return None
    shades = _sample(straight, grid, len(finders))
    black = shades < (shades[finders > 0].mean() + shades[finders < 0].mean()) / 2
    return np.where(finders == 0, black, finders > 0), grid


def _refined(straight: Grey, grid: Grid, finders: NDArray[np.float64]) -> tuple[float, Grid]:
    """The best grid near this one, and how well it agrees with the finder patterns, 1 at best: its four ends are moved
    in turn, in ever smaller steps."""
    best = _agreement(straight, grid, finders)
    if best < _DOUBTFUL:
        return best, grid
    cell = (grid[2] - grid[0]) / len(finders)
    for step in cell * np.array([1, 1 / 2, 1 / 4, 1 / 8]):
        better = True
        while better:
            better = False
            for move in (*np.eye(4) * step, *np.eye(4) * -step):
                agreement = _agreement(straight, grid + move, finders)
                if agreement > best + 1e-6:
                    best, grid, better = agreement, grid + move, True
    return best, grid


def _agreement(straight: Grey, grid: Grid, finders: NDArray[np.float64]) -> float:
    shades = _sample(straight, grid, len(finders))[finders != 0]
    known = finders[finders != 0]
    off = shades - shades.mean()
    return -float(off @ known) / max(float(np.abs(off).sum()), 1e-9)


def _sample(straight: Grey, grid: Grid, count: int) -> NDArray[np.float32]:
    """Grey levels in the middles of ``count`` × ``count`` cells."""
    import cv2

    middles = (np.arange(count) + 0.5) / count
    x = (grid[0] + middles * (grid[2] - grid[0])).astype(np.float32)
    y = (grid[1] + middles * (grid[3] - grid[1])).astype(np.float32)
    columns, rows = np.tile(x, (count, 1)), np.tile(y[:, None], (1, count))
    levels = cv2.remap(straight, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(levels, dtype=np.float32)


@cache
def _finders(version: int) -> NDArray[np.float64]:
    """What every code of this version shows (ISO/IEC 18004): 1 black, −1 white, 0 what differs from code to code."""
    count = 17 + 4 * version
    cells = np.zeros((count, count))
    eye = np.full((8, 8), -1.0)
    eye[:7, :7], eye[1:6, 1:6], eye[2:5, 2:5] = 1, -1, 1
    cells[:8, :8], cells[:8, -8:], cells[-8:, :8] = eye, eye[:, ::-1], eye[::-1]
    cells[6, 8:-8] = cells[8:-8, 6] = np.where(np.arange(8, count - 8) % 2 == 0, 1, -1)
    return cells


def _text(cells: NDArray[np.bool_]) -> str:
    import cv2

    margin = _MARGIN * _CLEAN
    white = np.pad(np.kron(~cells, np.ones((_CLEAN, _CLEAN), dtype=np.bool_)), margin, constant_values=True)
    drawn: Grey = np.where(white, 255, 0).astype(np.uint8)
    low, high = margin, margin + _CLEAN * len(cells) - 1
    ends = np.array([[[low, low], [high, low], [high, high], [low, high]]], dtype=np.float32)
    return str(cv2.QRCodeDetector().decode(drawn, ends)[0])


def _turned(grey: Grey) -> list[tuple[str, Corners]]:
    """Texts and corners of codes however they are turned, larger in the picture than :func:`_upright` needs them."""
    import cv2

    scale = max(1, round(_ENLARGED / grey.shape[1]))
    if scale > 1:
        grey = np.asarray(cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC), dtype=np.uint8)
    read, texts, quads, _ = _reader().detectAndDecodeMulti(grey)
    if not read:
        return []
    corners = [(np.asarray(quad, dtype=np.float64).reshape(4, 2) + 0.5) / scale for quad in quads]
    return [(text, quad) for text, quad in zip(texts, corners, strict=True) if text]


@cache
def _reader() -> cv2.QRCodeDetectorAruco:
    import cv2

    return cv2.QRCodeDetectorAruco()
