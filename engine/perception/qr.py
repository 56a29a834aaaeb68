"""QR codes: what they say, where they are and which way they face."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.perception.tags import face_of
from engine.robot.camera import Picture

_ENLARGED: Final = 640  # pixels of width that the reader works on


@dataclass(frozen=True, slots=True, eq=False)
class CodeSighting:
    """One QR code in one picture."""

    text: str
    corners: NDArray[np.float64]  # shape (4, 2), pixels: upper left, upper right, lower right, lower left of the code
    position: tuple[float, float, float]  # of its middle, map frame, m
    normal: tuple[float, float, float]  # of its face, map frame
    size: float  # edge of the code without its margin, m
    range: float  # from the camera, m


def find_qr(picture: Picture) -> tuple[CodeSighting, ...]:
    """The QR codes in a picture that can be read, the nearest first. Those without depth are left out: their size is
    not known, so nobody could tell where they are."""
    grey = cv2.cvtColor(picture.rgb, cv2.COLOR_RGB2GRAY)
    scale = max(1, round(_ENLARGED / grey.shape[1]))
    if scale > 1:
        grey = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
    read, texts, quads, _ = _reader().detectAndDecodeMulti(grey)
    if not read:
        return ()
    found = []
    for text, quad in zip(texts, quads, strict=True):
        corners = (np.asarray(quad, dtype=np.float64).reshape(4, 2) + 0.5) / scale
        face = face_of(picture, corners) if text else None
        if face is None:
            continue
        place, ahead = picture.on_map(picture.mount.out(np.array([face.middle, face.middle + face.normal])))
        found.append(
            CodeSighting(
                text,
                corners,
                (float(place[0]), float(place[1]), float(place[2])),
                (float(ahead[0] - place[0]), float(ahead[1] - place[1]), float(ahead[2] - place[2])),
                sum(face.sides) / 4,
                float(np.linalg.norm(face.middle)),
            )
        )
    return tuple(sorted(found, key=lambda code: code.range))


@cache
def _reader() -> cv2.QRCodeDetector:
    return cv2.QRCodeDetector()
