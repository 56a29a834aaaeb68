"""Which pictures of a board a lens is calibrated with: sharp ones, of a board that is held still, each in another way.

A board that is held straight at the camera says nothing about the lens, however often it is seen: one that is twice as
far looks like a lens that is half as long. And what a lens does at its rim is seen there alone. So the last places are
kept for boards that are tilted to each side, and for such as reach into the margins of the picture.
"""

from __future__ import annotations

from typing import Final, Literal

import cv2
import numpy as np

from engine.robot.calibration.chessboard import Chessboard, Pixels, View
from engine.robot.camera import Lens, Points

Flaw = Literal["unseen", "moving", "blurred"]
Verdict = Literal["taken", "like before"] | Flaw
Side = Literal["left", "right", "upper", "lower"]
"""As the camera sees it."""
Need = tuple[Literal["tilt", "margin"], Side]
"""What one of the pictures has to show: a board whose edge on this side is nearer than the other, or one that is in the
margin of the picture on this side."""

WANTED: Final = 12
SIDES: Final[tuple[Side, ...]] = ("left", "right", "upper", "lower")
NEEDS: Final[tuple[Need, ...]] = (*(("tilt", side) for side in SIDES), *(("margin", side) for side in SIDES))
SHARP: Final = 4.0
"""px of blur at most."""
STILL: Final = 0.005
"""Of the picture's width, by which a corner may have moved since the picture before."""
TILTED: Final = 0.3
"""Sine of the tilt that counts as one (17°)."""
MARGIN: Final = 0.15
"""Of the picture's width and height."""
_TURN, _MOVE, _SIZE = np.radians(10), 0.12, 1.2
"""By how much a board is held in another way: rad, of the picture's width, and as a ratio of sizes."""


def flaw_of(view: View | None, before: View | None, width: int) -> Flaw | None:
    """What is wrong with a picture, ``width`` pixels wide, by itself and by the one ``before``."""
    if view is None:
        return "unseen"
    if before is None or np.abs(view.corners - before.corners).max() > STILL * width:
        return "moving"
    return "blurred" if view.blur > SHARP else None


class Views:
    """The pictures that were taken so far."""

    def __init__(self, board: Chessboard, guess: Lens) -> None:
        """``guess`` is the lens as it is believed to be; it has the size of the pictures."""
        self._board = board
        self._lens = guess
        self._before: View | None = None
        self._held: list[_Held] = []
        self._verdicts: set[Verdict] = set()
        self.taken: list[Pixels] = []

    def look(self, view: View | None) -> Verdict:
        """What becomes of the next picture."""
        verdict = self._judge(view)
        self._before = view
        self._verdicts.add(verdict)
        return verdict

    @property
    def complete(self) -> bool:
        return len(self.taken) == WANTED

    @property
    def advice(self) -> str:
        """How to hold the board for the next picture."""
        match self._missing:
            case [("tilt", side), *_]:
                return f"tilt its {side} edge towards the camera"
            case [("margin", side), *_]:
                return f"bring it to the {side} margin of the picture"
        return "hold it nearer, farther, or tilted in another way"

    @property
    def reason(self) -> str:
        """Why there are not enough of them."""
        if self._verdicts <= {"unseen"}:
            squares = f"{self._board.columns} × {self._board.rows} squares"
            return f"The board was never seen. It has {squares}, and all of them must be in the picture."
        if not self.taken:
            return "The board was never seen sharp and still. More light helps, and a hand that rests on something."
        if len(self.taken) == 1:
            return "The board was held in one way only. It has to be moved about and tilted."
        return f"Only {len(self.taken)} of {WANTED} pictures were taken: {self.advice}."

    def _judge(self, view: View | None) -> Verdict:
        if flaw := flaw_of(view, self._before, self._lens.width):
            return flaw
        assert view is not None, "it has no flaw"
        held = _Held(self._board, self._lens, view.corners)
        missing, left = self._missing, WANTED - len(self.taken)
        if any(map(held.is_like, self._held)) or (len(missing) >= left and held.meets.isdisjoint(missing)):
            return "like before"
        self._held.append(held)
        self.taken.append(view.corners)
        return "taken"

    @property
    def _missing(self) -> list[Need]:
        return [need for need in NEEDS if all(need not in held.meets for held in self._held)]


class _Held:
    """How a board is held, as far as a lens that is only believed in can tell."""

    def __init__(self, board: Chessboard, lens: Lens, corners: Pixels) -> None:
        self._normal = facing(board, lens, corners)
        self._middle = corners.mean(axis=0) / lens.width
        self._size = float(np.linalg.norm(corners.std(axis=0)))
        x, y, _ = self._normal.tolist()
        (left, upper), (right, lower) = corners.min(axis=0), corners.max(axis=0)
        shown: tuple[bool, ...] = (x > TILTED, x < -TILTED, y > TILTED, y < -TILTED)
        across, along = MARGIN * lens.width, MARGIN * lens.height
        shown += (left < across, right > lens.width - across, upper < along, lower > lens.height - along)
        self.meets: frozenset[Need] = frozenset(need for need, is_met in zip(NEEDS, shown, strict=True) if is_met)

    def is_like(self, other: _Held) -> bool:
        turned = np.arccos(np.clip(self._normal @ other._normal, -1, 1))
        moved = np.linalg.norm(self._middle - other._middle)
        size = max(self._size, other._size) / min(self._size, other._size)
        return bool(turned < _TURN and moved < _MOVE and size < _SIZE)


def facing(board: Chessboard, lens: Lens, corners: Pixels) -> Points:
    """Which way a board faces: its normal on the camera's side, optical frame, shape (3,)."""
    rotation, _ = placed(board, lens, corners)
    return rotation[:, 2]


def placed(board: Chessboard, lens: Lens, corners: Pixels) -> tuple[Points, Points]:
    """Where a board is, optical frame: its axes as columns, z on the camera's side, and its middle, m."""
    _, turn, middle = cv2.solvePnP(board.points, corners, lens.matrix, None, flags=cv2.SOLVEPNP_ITERATIVE)
    axes, at = cv2.Rodrigues(turn)[0], middle.ravel()
    if axes[:, 2] @ at > 0:  # x to the right and y down make a z that points away
        axes = axes * (1, -1, -1)
    return np.asarray(axes, dtype=np.float64), np.asarray(at, dtype=np.float64)
