"""Pictures on surfaces, made by program: AprilTags, QR codes, wooden planks and kitchen tiles.

A tag block carries its tag on all six sides, as a cube texture. For cameras that cast rays instead of rendering,
:func:`tag_cells` gives the same picture as black and white cells.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from engine.robot.sim.colours import rgba

TAG_CELLS = 10
"""Cells along a side of a block: 6 of code, 1 of black border and 1 of white margin on either side."""
_PIXELS = 8  # per cell
_QUARTERS = (1, 3, 2, 0, 0, 2)  # turns to the left, of the faces towards +x, −x, +y, −y, +z and −z
UPRIGHT_FACE = 3
"""Of those six, one that is not turned."""
_QUIET = 3  # cells of white around a QR code


@cache
def tag_cells(tag: int) -> NDArray[np.bool_]:
    """The AprilTag 36h11 with its white margin; True is white. Shape (10, 10), row 0 on top."""
    import cv2  # slow to import, and needed only where tags are

    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    code = cv2.aruco.generateImageMarker(dictionary, tag, TAG_CELLS - 2)
    cells = np.ones((TAG_CELLS, TAG_CELLS), dtype=np.bool_)
    cells[1:-1, 1:-1] = np.asarray(code) > 127
    cells.setflags(write=False)
    return cells


@cache
def qr_cells(text: str) -> NDArray[np.bool_]:
    """A QR code with its quiet zone; True is white. Square, row 0 on top."""
    import cv2

    white = np.asarray(cv2.QRCodeEncoder.create().encode(text)) > 127
    rows, columns = (np.flatnonzero(~white.all(axis=axis)) for axis in (1, 0))  # OpenCV's own margin varies
    cells = white[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    cells = np.pad(cells, _QUIET, constant_values=True)
    cells.setflags(write=False)
    return cells


def cube(cells: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Six faces below one another, RGB, for a cube texture, turned so that the four sides stand upright in OpenGL."""
    face = np.kron(cells, np.ones((_PIXELS, _PIXELS), dtype=np.bool_))
    grey = np.where(face, 245, 15).astype(np.uint8)
    turned = [np.rot90(grey, quarters) for quarters in _QUARTERS]
    faces: NDArray[np.uint8] = np.repeat(np.concatenate(turned)[:, :, None], 3, axis=2)
    return faces


def planks(colour: str, seed: int = 0, *, pixels: int = 512) -> NDArray[np.uint8]:
    """Eight staggered rows of boards with a little grain; one picture covers 1.6 m × 1.6 m."""
    rng = np.random.default_rng(seed)
    rows, size = 8, pixels // 8
    shade = np.ones((pixels, pixels))
    for row in range(rows):
        top, at = row * size, int(rng.integers(0, pixels // 2))
        cuts = sorted({at, at + pixels // 2})
        tones = rng.uniform(0.9, 1.05, size=len(cuts) + 1)
        tones[-1] = tones[0]  # the last board goes on at the other edge
        edges = [0, *cuts, pixels]
        for tone, left, right in zip(tones, edges[:-1], edges[1:], strict=True):
            shade[top : top + size, left:right] = tone
        shade[top : top + size] *= 1 + 0.015 * rng.standard_normal((size, 1))
        shade[top : top + 2] *= 0.82
        for cut in cuts:
            shade[top : top + size, cut % pixels : cut % pixels + 2] *= 0.85
    return _coloured(colour, shade)


def tiles(colour: str, *, pixels: int = 256) -> NDArray[np.uint8]:
    """Four by four tiles with joints, in two tones; one picture covers 1.6 m × 1.6 m."""
    side = pixels // 4
    index = np.arange(pixels)
    shade = np.where((index[:, None] // side + index[None, :] // side) % 2 == 0, 1.0, 0.93)
    joint = index % side < 2
    shade[joint, :] = 0.8
    shade[:, joint] = 0.8
    return _coloured(colour, shade)


def _coloured(colour: str, shade: NDArray[np.float64]) -> NDArray[np.uint8]:
    base = np.array(rgba(colour)[:3]) * 255
    picture: NDArray[np.uint8] = np.clip(shade[:, :, None] * base, 0, 255).astype(np.uint8)
    return picture
