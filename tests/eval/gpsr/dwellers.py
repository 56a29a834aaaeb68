"""The people of a made-up house: where those stand, sit and lie whom a command needs, and who else is about.

Clothes differ, so that somebody who is known can be told by them. Where somebody leads to is a way around furniture.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
import pyastar2d
from numpy.typing import NDArray

from engine.robot.sim.clutter import _away
from engine.robot.sim.scene_parts import Point
from tests.eval.gpsr.goal import OPERATOR, Guest
from tests.eval.gpsr.rooms import CORRIDOR, Area, Draft, NoHouse, area_of, before, free_point, front_of

SHIRTS: Final = ("red", "blue", "green", "yellow", "purple", "orange", "white", "black")
TROUSERS: Final = ("black", "blue", "grey", "white")
_SEATS: Final = {"couch": 0.38, "bed": 0.45}
_CHAIR: Final = {"kind": "chair", "size": (0.42, 0.42, 0.85), "colour": "#e9dfcc"}
_CELL: Final = 0.1
_WIDE: Final = 0.35  # m around the middle of somebody who walks
_TRIES: Final = 200


def settle(draft: Draft, guests: Sequence[Guest]) -> None:
    """Put everybody where they must be: first those who sit or lie on furniture. Raises :class:`NoHouse`."""
    shirts = [str(colour) for colour in draft.rng.permutation(SHIRTS)]
    order = sorted(range(len(guests)), key=lambda index: guests[index].posture == "standing")
    for index in order:
        guest = guests[index]
        at, facing, seat = _where(draft, guest, f"person {index + 1}")
        draft.people[f"person {index + 1}"] = {
            "path": [at],
            "facing": facing,
            "posture": guest.posture,
            "seat": seat,
            "gesture": guest.gesture,
            "height": draft.uniform(1.05, 1.25) if guest.is_child else draft.uniform(1.58, 1.86),
            "called": guest.called,
            "gender": guest.gender,
            "known": guest.known,
            "shirt": shirts[index % len(shirts)],
            "trousers": str(draft.rng.choice([c for c in TROUSERS if c != shirts[index % len(shirts)]])),
            "replies": {**_of_themselves(guest), **guest.replies},
            "strays": draft.uniform(2.0, 3.0) if guest.strays else None,
        }
    draft.people = dict(sorted(draft.people.items()))
    for index, guest in enumerate(guests):
        if guest.leads_to:
            person = draft.people[f"person {index + 1}"]
            person["leads"] = way(draft, person["path"][0], draft.places[guest.leads_to]["at"], index + 1)


def operator(draft: Draft) -> None:
    """Who gives the command stands before the robot; in the corridor at its other side, so that others come by."""
    x, y, yaw = draft.start
    at = (x + 1.1 * math.cos(yaw), y + 1.1 * math.sin(yaw))
    if _away((x, y), draft.rooms[CORRIDOR]) == 0:
        at = (x + 0.8 * math.cos(yaw), math.copysign(draft.rooms[CORRIDOR][3] - 0.42, -y))
    facing = math.degrees(math.atan2(y - at[1], x - at[0]))
    draft.people[OPERATOR] = {
        "path": [(round(at[0], 3), round(at[1], 3))], "facing": round(facing), "height": 1.75, "shirt": "slate",
        "trousers": "slate", "gender": "female",
    }  # fmt: skip


def _where(draft: Draft, guest: Guest, key: str) -> tuple[Point, float, float]:
    """Where somebody is, which way they look (degrees), and how high they sit."""
    room = draft.room_of(guest.at)
    if guest.posture != "standing":
        for name, height in _SEATS.items():
            free = name in draft.furniture and draft.room_of(name) == room and not _is_taken(draft, name)
            if free and guest.at in (room, name):
                return _on(draft, name, lying=guest.posture == "lying"), _facing(draft, name, guest), height
    if guest.posture == "sitting":
        return _on_a_chair(draft, guest, room, key)
    if guest.at == room:
        x, y = free_point(draft, room, stands=0.6)
    else:
        x, y = _beside(draft, guest.at)
    lying = guest.posture == "lying"
    x0, y0, x1, y1 = draft.rooms[room]
    facing = math.degrees(math.atan2((y0 + y1) / 2 - y, (x0 + x1) / 2 - x))
    return (x, y), round(facing, 0), 0.0 if lying else 0.42


def _on(draft: Draft, name: str, *, lying: bool) -> Point:
    x, y = draft.furniture[name]["at"]
    if lying or name == "couch":
        return x, y
    return before(draft.furniture[name], -0.25)


def _facing(draft: Draft, name: str, guest: Guest) -> float:
    """Sitting, away from the back; lying along it: in a bed the head is at the back, on a couch at its left end."""
    front, right = front_of(draft.furniture[name])
    dx, dy = front if guest.posture == "sitting" else (-front[0], -front[1]) if name == "bed" else right
    return math.degrees(math.atan2(dy, dx))


def _is_taken(draft: Draft, name: str) -> bool:
    return any(_away(body, area_of(draft.furniture[name])) == 0 for body in draft.bodies())


def _on_a_chair(draft: Draft, guest: Guest, room: str, key: str) -> tuple[Point, float, float]:
    """On a chair of their own, in the room or beside a place."""
    at = free_point(draft, room, wall=0.7, furniture=0.7, stands=0.7) if guest.at == room else _beside(draft, guest.at)
    turn = int(draft.rng.choice([0, 90, 180, 270]))
    draft.furniture[f"chair {key.rpartition(' ')[2]}"] = {**_CHAIR, "at": at, "turn": turn}
    return at, float((turn + 270) % 360), 0.46


def _beside(draft: Draft, place: str) -> Point:
    """Near a place, but not where the robot stands when it is sent there."""
    stand = draft.places[place]["at"]
    room = draft.rooms[draft.room_of(place)]
    for attempt in range(_TRIES):
        away, angle = draft.uniform(0.6, 0.75 + 0.5 * attempt / _TRIES), draft.uniform(-math.pi, math.pi)
        x, y = round(stand[0] + away * math.cos(angle), 3), round(stand[1] + away * math.sin(angle), 3)
        if (
            room[0] + 0.4 < x < room[2] - 0.4
            and room[1] + 0.4 < y < room[3] - 0.4
            and all(_away((x, y), area) > 0.32 for area in draft.areas())
            and all(math.dist((x, y), door.at) > 0.8 for door in draft.doors.values())
            and all(math.dist((x, y), other) > 0.5 for other in draft.stands())
            and all(math.dist((x, y), body) > 0.8 for body in draft.bodies())
        ):
            return x, y
    raise NoHouse(f"no room for somebody at the {place}")


def _of_themselves(guest: Guest) -> dict[str, str]:
    """What they answer when they are asked what they are."""
    word = {
        ("female", False): "woman", ("female", True): "girl", ("male", False): "man", ("male", True): "boy"
    }[guest.gender, guest.is_child]  # fmt: skip
    chinese = {"woman": "女人", "girl": "女孩", "man": "男人", "boy": "男孩"}[word]
    english = dict.fromkeys(("gender", "woman", "man", "girl", "boy", "male", "female"), f"I am a {word}.")
    return {**english, **dict.fromkeys(("性别", "男", "女"), f"我是{chinese}。")}


# Ways


def walkable(draft: Draft, *, but: int = 0) -> tuple[NDArray[np.bool_], Point]:
    """Cells where somebody can walk, and the corner of the first; the person of number ``but`` is in nobody's way."""
    x0, x1 = draft.rooms[CORRIDOR][0], draft.rooms[CORRIDOR][2]
    y0, y1 = min(area[1] for area in draft.rooms.values()), max(area[3] for area in draft.rooms.values())
    columns, rows = round((x1 - x0) / _CELL), round((y1 - y0) / _CELL)
    xs, ys = np.meshgrid(x0 + (np.arange(columns) + 0.5) * _CELL, y0 + (np.arange(rows) + 0.5) * _CELL)

    def inside(area: Area, grow: float) -> NDArray[np.bool_]:
        found: NDArray[np.bool_] = (
            (xs > area[0] - grow) & (xs < area[2] + grow) & (ys > area[1] - grow) & (ys < area[3] + grow)
        )
        return found

    free = np.zeros_like(xs, dtype=np.bool_)
    for area in draft.rooms.values():
        free |= inside(area, -_WIDE)
    for door in draft.doors.values():
        x, y = door.at
        free |= inside((x - 0.15, y - 0.6, x + 0.15, y + 0.6), 0.0)
    for area in draft.areas():
        free &= ~inside(area, _WIDE)
    own = draft.people.get(f"person {but}", {}).get("path", [None])[0]
    for x, y in draft.bodies():
        if (x, y) != own:
            free &= np.hypot(xs - x, ys - y) > _WIDE + 0.2
    return free, (x0, y0)


def way(draft: Draft, start: Point, goal: Point, number: int) -> list[Point]:
    """The points that somebody walks by, without the first. Raises :class:`NoHouse`."""
    free, origin = walkable(draft, but=number)
    weights = np.where(free, 1.0, 1000.0).astype(np.float32)
    cells = [(int((y - origin[1]) / _CELL), int((x - origin[0]) / _CELL)) for x, y in (start, goal)]
    found = pyastar2d.astar_path(weights, cells[0], cells[1], allow_diagonal=True)
    if found is None or not free[tuple(found[8:-4].T)].all():
        raise NoHouse("there is no way to lead on")
    points = [(origin[0] + (c + 0.5) * _CELL, origin[1] + (r + 0.5) * _CELL) for r, c in found[::5]]
    return [(round(x, 2), round(y, 2)) for x, y in (*points[1:], goal)]
