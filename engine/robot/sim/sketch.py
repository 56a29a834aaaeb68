"""A scene seen from straight above, drawn as an architect would: floors, walls, furniture, and what lies about.

Colours are those of the scene. It is a drawing, not a rendering: it needs no graphics library, and small things are
drawn a little larger than they are, so that they can be found.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.robot.floor_map import Wall
from engine.robot.sim.colours import rgba
from engine.robot.sim.dimensions import FOOTPRINT
from engine.robot.sim.floor import door_leaf, wall_pieces
from engine.robot.sim.furniture import FLAT, Solid, solids
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_parts import FurniturePiece, LandmarkTag, LooseObject, Point, Poster
from engine.robot.sim.textures import planks, tiles

MARGIN: Final = 0.25
"""Paper around the walls, m."""
_PAPER = (250, 249, 246)
_INK = (52, 56, 62)
_WALL = (84, 88, 94)
_TAG = (30, 30, 30)
_SMALLEST = 0.05  # m: what is smaller is drawn as large as this
_FINE = 16  # cv2 takes coordinates in sixteenths of a pixel
_SHIFT = 4
_Colour = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Sketch:
    """The drawing, and where on it a point of the floor is."""

    picture: NDArray[np.uint8]  # shape (height, width, 3), RGB; north is up
    scale: float  # pixels per metre
    west: float  # x of its left edge, map frame, m
    north: float  # y of its upper edge, map frame, m

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Column and row of a point of the map."""
        return (x - self.west) * self.scale, (self.north - y) * self.scale


def sketch(scene: Scene, *, scale: float = 100.0, words: bool = True) -> Sketch:
    """Draw a scene at ``scale`` pixels per metre; ``words``: with the names of rooms, places and things."""
    fine = _Draughtsman(scene, 2 * scale)
    fine.floors()
    fine.lines()
    fine.furniture()
    fine.walls()
    fine.signs()
    fine.people()
    fine.objects()
    fine.start()
    if words:
        fine.words()
    height, width = (side // 2 for side in fine.picture.shape[:2])
    small = cv2.resize(fine.picture, (width, height), interpolation=cv2.INTER_AREA)
    return Sketch(np.asarray(small, dtype=np.uint8), scale, fine.west, fine.north)


class _Draughtsman:
    """Draws at twice the size, so that edges come out smooth."""

    def __init__(self, scene: Scene, scale: float) -> None:
        self._scene, self._scale = scene, scale
        self.west, self.north = scene.bounds.x[0] - MARGIN, scene.bounds.y[1] + MARGIN
        width = (scene.bounds.x[1] - scene.bounds.x[0] + 2 * MARGIN) * scale
        height = (scene.bounds.y[1] - scene.bounds.y[0] + 2 * MARGIN) * scale
        self.picture = np.full((2 * round(height / 2), 2 * round(width / 2), 3), _PAPER, dtype=np.uint8)
        self._written: list[tuple[int, int, int, int]] = []  # where words are, pixels

    def floors(self) -> None:
        for index, room in enumerate(self._scene.rooms.values()):
            (left, top), (right, bottom) = self._at(room.x[0], room.y[1]), self._at(room.x[1], room.y[0])
            area = self.picture[round(top) : round(bottom), round(left) : round(right)]
            if room.floor == "plain":
                area[:] = _rgb(room.colour)
                continue
            pattern = planks(room.colour, index) if room.floor == "planks" else tiles(room.colour)
            side = round(1.6 * self._scale)
            tile = cv2.resize(pattern, (side, side), interpolation=cv2.INTER_AREA)
            rows, columns = (-(-n // side) for n in area.shape[:2])
            pale = 0.55 * np.tile(tile, (rows, columns, 1))[: area.shape[0], : area.shape[1]] + 0.45 * 255
            area[:] = pale.astype(np.uint8)

    def lines(self) -> None:
        for line in self._scene.lines.values():
            thick = max(2, round(line.width * self._scale))
            cv2.polylines(
                self.picture, [self._points(line.points)], False, _rgb(line.colour), thick, cv2.LINE_AA, _SHIFT
            )

    def furniture(self) -> None:
        pieces = sorted(self._scene.furniture.values(), key=lambda piece: piece.kind not in FLAT)
        for piece in pieces:
            if piece.kind not in FLAT:
                self._rectangle(piece.area, (205, 203, 198), offset=0.03)  # a shadow
            for part in sorted(solids(piece), key=lambda part: part.centre[2] + part.half[2]):
                self._solid(piece, part)
            if piece.kind not in FLAT:
                self._outline(piece.area)
            if piece.moved is not None:
                self._dashes(piece.mapped_area)

    def walls(self) -> None:
        for wall in wall_pieces(self._scene):
            self._wall(wall, _WALL)
        for door in self._scene.doors:
            if door.closed:
                self._wall(door_leaf(self._scene, door), _rgb("walnut"))

    def signs(self) -> None:
        signs: list[LandmarkTag | Poster] = [*self._scene.landmarks, *self._scene.posters]
        for sign in signs:
            out, half = (math.cos(sign.yaw), math.sin(sign.yaw)), sign.size / 2
            ends = [
                (sign.at[0] + side * half * out[1] + 0.01 * out[0], sign.at[1] - side * half * out[0] + 0.01 * out[1])
                for side in (-1, 1)
            ]
            self._stroke(ends, (255, 255, 255), 0.07)
            self._stroke(ends, _TAG if isinstance(sign, LandmarkTag) else _rgb("purple"), 0.04)

    def objects(self) -> None:
        for loose in sorted(self._scene.objects.values(), key=self._scene.standing_height):
            self._object(loose)

    def people(self) -> None:
        for person in self._scene.people.values():
            if len(person.path) > 1:
                self._dotted([*person.path, person.path[0]])
            x, y = person.path[0]
            for side, half in ((0.0, 0.18), (0.0, 0.1)):
                colour = _rgb(person.shirt) if half > 0.1 else (74, 52, 40)
                self._disc((x, y + side), half, colour)

    def start(self) -> None:
        """The robot, where it begins."""
        pose = self._scene.start.pose
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        length, width = FOOTPRINT.length / 2, FOOTPRINT.width / 2

        def placed(points: Sequence[Point]) -> list[Point]:
            return [(pose.x + c * x - s * y, pose.y + s * x + c * y) for x, y in points]

        hull = placed([(length, width), (length, -width), (-length, -width), (-length, width)])
        self._polygon(hull, _rgb("slate"))
        nose = placed([(length - 0.02, 0.0), (0.0, width - 0.03), (0.0, 0.03 - width)])
        self._polygon(nose, _rgb("orange"))

    def words(self) -> None:
        """Names, each beside what it names where nothing is written yet."""
        for symbol, place in self._scene.known_places().items():
            at = (place.position.x, place.position.y)
            self._disc(at, 0.075, (255, 255, 255))
            self._write(symbol, [at], 0.1, (190, 70, 40), plain=True)
        for name, loose in self._scene.objects.items():
            x, y = loose.at
            around = [(x, y - 0.1), (x, y + 0.1), (x, y - 0.2), (x, y + 0.2), (x, y + 0.3), (x, y - 0.3)]
            self._write(name, around, 0.075, _INK)
        for name, piece in self._scene.furniture.items():
            if piece.kind not in FLAT:
                (x, y), aside = piece.stands, piece.extent[1] / 2 + 0.1
                self._write(name, [(x, y), (x, y + 0.15), (x, y - 0.15), (x, y + aside), (x, y - aside)], 0.085, _INK)
        for name, room in self._scene.rooms.items():
            x, (low, high) = sum(room.x) / 2, room.y
            heights = [high - 0.3, *np.linspace(high - 0.5, low + 0.3, 8).tolist()]
            bare = [
                (x, y) for y in heights if not any(_covers(piece, x, y) for piece in self._scene.furniture.values())
            ]
            self._write(name.upper(), bare or [(x, high - 0.3)], 0.15, (110, 112, 116), plain=True)

    # How things are drawn

    def _at(self, x: float, y: float) -> tuple[float, float]:
        return (x - self.west) * self._scale, (self.north - y) * self._scale

    def _points(self, points: Sequence[Point]) -> NDArray[np.int32]:
        return np.array([[round(v * _FINE) for v in self._at(*point)] for point in points], dtype=np.int32)

    def _polygon(self, points: Sequence[Point], colour: _Colour) -> None:
        cv2.fillPoly(self.picture, [self._points(points)], colour, cv2.LINE_AA, _SHIFT)

    def _rectangle(self, area: tuple[float, float, float, float], colour: _Colour, *, offset: float = 0.0) -> None:
        x0, y0, x1, y1 = area[0] + offset, area[1] - offset, area[2] + offset, area[3] - offset
        self._polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], colour)

    def _outline(self, area: tuple[float, float, float, float]) -> None:
        x0, y0, x1, y1 = area
        self._stroke([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)], _INK, 0.012)

    def _dashes(self, area: tuple[float, float, float, float]) -> None:
        x0, y0, x1, y1 = area
        self._dotted([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)])

    def _dotted(self, points: Sequence[Point]) -> None:
        for start, end in pairwise(points):
            count = max(2, round(math.dist(start, end) / 0.12))
            for part in np.linspace(0, 1, count, endpoint=False):
                at = (start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1]))
                self._disc(at, 0.015, (120, 124, 130), ink=False)

    def _stroke(self, points: Sequence[Point], colour: _Colour, width: float) -> None:
        thick = max(1, round(width * self._scale))
        cv2.polylines(self.picture, [self._points(points)], False, colour, thick, cv2.LINE_AA, _SHIFT)

    def _disc(self, at: Point, radius: float, colour: _Colour, *, ink: bool = True) -> None:
        centre = tuple(round(v * _FINE) for v in self._at(*at))
        size = round(radius * self._scale * _FINE)
        cv2.circle(self.picture, centre, size, colour, -1, cv2.LINE_AA, _SHIFT)
        if ink:
            cv2.circle(self.picture, centre, size, _INK, max(1, round(0.01 * self._scale)), cv2.LINE_AA, _SHIFT)

    def _wall(self, wall: Wall, colour: _Colour) -> None:
        self._rectangle((wall.x_min, wall.y_min, wall.x_max, wall.y_max), colour)

    def _solid(self, piece: FurniturePiece, part: Solid) -> None:
        turn = math.radians(piece.turn)
        c, s = math.cos(turn), math.sin(turn)
        x, y, _ = part.centre
        middle = (piece.stands[0] + c * x - s * y, piece.stands[1] + s * x + c * y)
        colour = _rgb(part.colour, part.shade)
        if part.shape != "box":
            self._disc(middle, part.half[0], colour, ink=False)
            return
        half = part.half[:2] if piece.turn % 180 == 0 else part.half[1::-1]
        self._rectangle((middle[0] - half[0], middle[1] - half[1], middle[0] + half[0], middle[1] + half[1]), colour)

    def _object(self, loose: LooseObject) -> None:
        x, y = loose.at
        colour = _rgb(loose.colour)
        if loose.kind in ("box", "tag_block"):
            half, turn = max(loose.size, _SMALLEST) / 2, math.radians(loose.turn)
            c, s = half * math.cos(turn), half * math.sin(turn)
            corners = [(x + c - s, y + s + c), (x - c - s, y - s + c), (x - c + s, y - s - c), (x + c + s, y + s - c)]
            self._polygon(corners, colour)
            self._stroke([*corners, corners[0]], _INK, 0.01)
            if loose.tag is not None:
                self._disc(loose.at, 0.4 * half, _TAG, ink=False)
            return
        part = {"cup": 0.375, "bottle": 0.2, "ball": 0.5}[loose.kind]
        radius = max(part * loose.size, _SMALLEST / 2)
        self._disc(loose.at, radius, colour)
        if loose.kind == "cup":
            self._disc(loose.at, 0.65 * radius, _rgb(loose.colour, 0.6), ink=False)
        elif loose.kind == "bottle":
            self._disc(loose.at, 0.45 * radius, (250, 250, 250), ink=False)

    def _write(self, text: str, middles: Sequence[Point], tall: float, colour: _Colour, *, plain: bool = False) -> None:
        """Words around the first of these points where there is room, letters ``tall`` m high; on a pale label unless
        ``plain``."""
        font, size = cv2.FONT_HERSHEY_SIMPLEX, tall * self._scale / 22
        ink = max(1, round(size * 1.6))
        (wide, high), _ = cv2.getTextSize(text, font, size, ink)
        wide, high = wide + round(0.03 * self._scale), high + round(0.03 * self._scale)
        height, width = self.picture.shape[:2]
        boxes = []
        for middle in middles:
            column, row = self._at(*middle)
            left = min(max(0, round(column - wide / 2)), width - wide)
            top = min(max(0, round(row - high / 2)), height - high)
            boxes.append((left, top, left + wide, top + high))
        box = next((box for box in boxes if not any(_overlap(box, other) for other in self._written)), boxes[0])
        self._written.append(box)
        left, top, right, bottom = box
        if not plain:
            label = self.picture[top:bottom, left:right]
            label[:] = (0.3 * label + 0.7 * 255).astype(np.uint8)
        pad = round(0.015 * self._scale)
        cv2.putText(self.picture, text, (left + pad, bottom - pad), font, size, colour, ink, cv2.LINE_AA)


def _overlap(a: tuple[int, int, int, int], b: tuple[int, int, int, int]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _covers(piece: FurniturePiece, x: float, y: float) -> bool:
    x0, y0, x1, y1 = piece.area
    return piece.kind not in FLAT and x0 - 0.6 < x < x1 + 0.6 and y0 - 0.15 < y < y1 + 0.15


def _rgb(colour: str, shade: float = 1.0) -> _Colour:
    red, green, blue, _ = rgba(colour, shade=shade)
    return red * 255, green * 255, blue * 255
