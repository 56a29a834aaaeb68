"""Houses for the commands of the General Purpose Service Robot grammar, made up from a seed.

Each has the grammar's rooms and furniture in an arrangement of its own, things that it knows by the grammar's names
(what they look like is :data:`LOOKS`), people, and everything that a command needs. Everything can be reached: floor
that a robot needs joins all places, and there is some around each person and before each thing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import cv2
import numpy as np

from engine.robot.sim.clutter import _away
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_parts import Point
from tests.eval.gpsr.dwellers import operator, settle
from tests.eval.gpsr.goal import Guest, Item, Needs
from tests.eval.gpsr.lexicon import Language, said
from tests.eval.gpsr.rooms import (
    CORRIDOR,
    FURNITURE,
    Draft,
    NoHouse,
    before,
    free_point,
    front_of,
    furnished,
    landmarks,
    with_aliases,
)

_CATEGORIES: Final[Mapping[str, tuple[str, Mapping[str, str]]]] = {
    "bottle": ("counter", {"coke": "red", "sprite": "green", "orange juice": "orange", "grape juice": "purple",
                           "chocolate drink": "blue"}),
    "box": ("cupboard", {"cereal": "red", "noodles": "yellow", "sausages": "orange", "pringles": "green",
                         "crackers": "blue", "potato chips": "purple"}),
    "cup": ("storage table", {"cup": "white", "bowl": "blue", "dish": "green", "cloth": "yellow", "scrubby": "purple",
                              "sponge": "orange", "cascade pod": "red"}),
    "ball": ("bookcase", {"apple": "red", "orange": "orange", "paprika": "yellow", "fork": "green", "knife": "blue",
                          "spoon": "purple"}),
}  # fmt: skip
LOOKS: Final[Mapping[str, tuple[str, str]]] = {
    **{name: (kind, colour) for kind, (_, names) in _CATEGORIES.items() for name, colour in names.items()},
    "tray": ("bottle", "yellow"), "basket": ("bottle", "white"), "bag": ("box", "white"),
}  # fmt: skip
"""Kind and colour of what the simulation has for each thing of the grammar: no two are alike."""
_SIZES: Final = {"box": 0.05, "cup": 0.08, "bottle": 0.155, "ball": 0.055}
_MASSES: Final = {"box": 0.05, "cup": 0.08, "bottle": 0.12, "ball": 0.03}
_ALIASES: Final = {
    "entrance": ("front door", "main door", "front entrance", "main entrance", "前门", "大门"),
    "exit": ("back door", "rear door", "back entrance", "rear entrance", "后门"),
    "taxi": ("cab", "uber", "的士"),
}
_NAMES: Final = ("Elizabeth", "Jennifer", "Linda", "Mary", "Patricia", "James", "John", "Michael", "Robert", "William")
_FEMALE: Final = 5  # of these names
_TRIES: Final = 60
_CELL: Final = 0.05
ROBOT: Final = 0.2
"""Radius of the floor that the robot needs, m: half the diagonal of its hull."""


def house(seed: int, needs: Needs | None = None, *, language: Language = "en", name: str = "") -> Scene:
    """The house of a seed for what is needed. Raises :class:`NoHouse` where no arrangement has room for it."""
    needs = needs or Needs()
    for attempt in range(_TRIES):
        rng = np.random.default_rng([seed, attempt])
        try:
            draft = _draft(rng, needs, language)
            scene = _scene(draft, name or f"house-{seed}")
            if not unreachable(scene, needs.blocked):
                return scene
        except NoHouse:
            continue
    raise NoHouse(f"no house has room for {needs}")


def _draft(rng: np.random.Generator, needs: Needs, language: Language) -> Draft:
    guests, items = (*needs.guests, *_fillers(rng, needs)), (*needs.items, *_stock(rng, needs, language))
    many = {piece: sum(item.at == piece for item in items) for room in FURNITURE.values() for piece in room}
    draft = furnished(rng, many)
    _begin(draft, needs)
    operator(draft)
    settle(draft, guests)
    for place in dict.fromkeys(item.at for item in items):
        here = [item for item in items if item.at == place]
        if place in draft.furniture:
            _on_furniture(draft, place, here)
        else:
            for item in here:
                at = free_point(draft, place, wall=0.4, furniture=0.36, stands=0.42, people=0.7)
                draft.objects[item.key] = {**_thing(item), "at": at}
    if needs.blocked:
        piece = draft.furniture[needs.blocked]
        at = before(piece, 0.42, draft.uniform(-0.1, 0.1))
        draft.furniture["carton"] = {
            "kind": "carton", "size": (0.35, 0.3, 0.3), "colour": "cardboard", "at": at, "turn": piece["turn"],
            "mapped": False,
        }  # fmt: skip
    return draft


def _begin(draft: Draft, needs: Needs) -> None:
    """The robot begins in the corridor; in another room, where a command is about the corridor."""
    if CORRIDOR not in needs.clear:
        side = int(draft.rng.choice([-1, 1]))
        draft.start = (draft.uniform(-1.2, 1.2), draft.uniform(0.2, 0.3) * side, math.pi * int(draft.rng.integers(2)))
        return
    room = next(room for room in ("living room", "dining room", "bedroom") if room not in needs.clear)
    x, y = free_point(draft, room, wall=1.2, furniture=0.6, stands=0.0)
    for turn in draft.rng.permutation(8):
        yaw = float(turn) * math.pi / 4
        there = (x + 1.1 * math.cos(yaw), y + 1.1 * math.sin(yaw))
        if all(_away(there, area) > 0.4 for area in draft.areas()) and _away(there, draft.rooms[room]) == 0:
            draft.start = (x, y, yaw)
            return
    raise NoHouse("nowhere to begin")


def _fillers(rng: np.random.Generator, needs: Needs) -> list[Guest]:
    """Others, so that two to four people are in the house, where they change nothing that a command asks for."""
    taken = {guest.called for guest in needs.guests}
    busy = {*needs.clear, *(guest.at for guest in needs.guests)}
    busy |= {room for room, pieces in FURNITURE.items() if busy & pieces.keys()}
    rooms = [room for room in FURNITURE if room not in busy]
    free = [index for index, name in enumerate(_NAMES) if name not in taken]
    count = min(len(rooms), max(0, int(rng.integers(2, 5)) - len(needs.guests)))
    chosen: list[int] = rng.choice(free, count, replace=False).tolist()
    where: list[str] = rng.choice(rooms, count, replace=False).tolist() if rooms else []
    return [
        Guest(room, _NAMES[index], "female" if index < _FEMALE else "male")
        for index, room in zip(chosen, where, strict=True)
    ]


def _stock(rng: np.random.Generator, needs: Needs, language: Language) -> list[Item]:
    """Other things where they belong, unless a command asks what is there."""
    busy = {*needs.clear, *(piece for room, pieces in FURNITURE.items() if room in needs.clear for piece in pieces)}
    taken = {item.name for item in needs.items}
    categories = {name: at for at, names in _CATEGORIES.values() for name in names}
    free = [name for name, at in categories.items() if name not in taken and at not in busy]
    if not free:
        return []
    chosen = rng.choice(free, min(len(free), int(rng.integers(3, 6))), replace=False)
    return [Item(str(name), said(str(name), language), categories[str(name)]) for name in chosen]


def _thing(item: Item) -> dict[str, Any]:
    kind, colour = LOOKS[item.name]
    size = round(_SIZES[kind] * item.scale, 4)
    mass = round(_MASSES[kind] * item.scale**3, 4)
    return {"kind": kind, "colour": colour, "size": size, "mass": mass, "category": item.category}


def _on_furniture(draft: Draft, name: str, items: Sequence[Item]) -> None:
    """Side by side near the front, those that are beside another one where they must be."""
    row: list[str] = []
    alone = [item for item in items if item.beside is None]
    for index in draft.rng.permutation(len(alone)):
        row.append(alone[int(index)].key)
    for item in items:
        if item.beside is not None and item.beside[0] in ("left", "right"):
            row.insert(row.index(item.beside[1]) + (item.beside[0] == "right"), item.key)
    piece = draft.furniture[name]
    front, _ = front_of(piece)
    length = piece["size"][0] - 0.16
    for item in sorted(items, key=lambda item: item.key not in row):
        thing = {**_thing(item), "stands_on": name}
        if item.key in row:
            aside = (row.index(item.key) + 0.5) / len(row) * length - length / 2
            draft.objects[item.key] = {**thing, "at": before(piece, -draft.uniform(0.06, 0.075), aside)}
            continue
        assert item.beside is not None
        side, other = item.beside
        x, y = draft.objects[other]["at"]
        if side == "on":
            draft.objects[item.key] = {**thing, "at": (x, y), "stands_on": other}
        else:  # behind
            at = (round(x - 0.13 * front[0], 3), round(y - 0.13 * front[1], 3))
            draft.objects[item.key] = {**thing, "at": at}


def _scene(draft: Draft, name: str) -> Scene:
    x0, y0 = (min(area[i] for area in draft.rooms.values()) for i in (0, 1))
    x1, y1 = (max(area[i] for area in draft.rooms.values()) for i in (2, 3))
    floors = dict(zip(draft.rooms, ("birch", "oak", "#cdb08a", "birch", "#dfe3e2"), strict=True))
    rooms = {room: {"x": (a[0], a[2]), "y": (a[1], a[3]), "colour": floors[room]} for room, a in draft.rooms.items()}
    spots = {key: place for key, place in draft.places.items() if key not in draft.furniture and key not in rooms}
    others = {key: place for key, place in draft.places.items() if key not in spots}
    return Scene.model_validate(
        {
            "name": name,
            "bounds": {"x": (x0, x1), "y": (y0, y1)},
            "start": {"x": draft.start[0], "y": draft.start[1], "yaw": math.degrees(draft.start[2])},
            "walls": {"colour": "#efece4"},
            "rooms": with_aliases(rooms, {}),
            "doors": [{"between": (CORRIDOR, d.room), "at": d.at[0], "width": 1.0} for d in draft.doors.values()],
            "furniture": with_aliases(draft.furniture, {}),
            "objects": draft.objects,
            "landmarks": list(landmarks(draft)),
            "people": draft.people,
            "places": with_aliases({**spots, **others}, _ALIASES),
        }
    )


# Whether everything can be reached


def unreachable(scene: Scene, blocked: str = "") -> list[str]:
    """Places, people and things that the robot cannot come near from its start; ``blocked`` may be one."""
    labels, origin = _floor(scene)

    def near(point: Point, within: float) -> bool:
        rows, columns = np.indices(labels.shape)
        away = np.hypot(origin[0] + (columns + 0.5) * _CELL - point[0], origin[1] + (rows + 0.5) * _CELL - point[1])
        return bool((labels[away <= within] == mine).any())

    mine = labels[_cell((scene.start.x, scene.start.y), origin)]
    if mine == 0:
        return ["start"]
    found = [name for name, place in scene.places.items() if name != blocked and not near(place.at, 0.08)]
    found += [name for name, person in scene.people.items() if not near(person.path[0], 1.3)]
    for name, loose in scene.objects.items():
        if not near(loose.at, 0.5):
            found.append(name)
    return found


def _floor(scene: Scene) -> tuple[np.ndarray[Any, np.dtype[np.int32]], Point]:
    """Floor for the robot's middle, in connected parts: 0 is none."""
    x0, y0 = scene.bounds.x[0], scene.bounds.y[0]
    columns, rows = (round((b[1] - b[0]) / _CELL) for b in (scene.bounds.x, scene.bounds.y))
    xs, ys = np.meshgrid(x0 + (np.arange(columns) + 0.5) * _CELL, y0 + (np.arange(rows) + 0.5) * _CELL)
    free = np.zeros(xs.shape, dtype=np.uint8)
    wall = scene.walls.thickness / 2 + ROBOT
    for room in scene.rooms.values():
        (left, right), (low, high) = room.x, room.y
        free[(xs > left + wall) & (xs < right - wall) & (ys > low + wall) & (ys < high - wall)] = 1
    for door in scene.doors:
        low, high = scene.rooms[CORRIDOR].y
        y = high if scene.rooms[door.between[1]].y[0] >= high else low
        half = door.width / 2 - ROBOT
        free[(abs(xs - door.at) < half) & (abs(ys - y) < 2 * wall)] = 1
    for piece in scene.furniture.values():
        left, low, right, high = piece.area
        free[(xs > left - ROBOT) & (xs < right + ROBOT) & (ys > low - ROBOT) & (ys < high + ROBOT)] = 0
    for person in scene.people.values():
        x, y = person.path[0]
        free[np.hypot(xs - x, ys - y) < 0.25 + ROBOT] = 0
    for loose in scene.objects.values():
        if loose.stands_on is None:
            free[np.hypot(xs - loose.at[0], ys - loose.at[1]) < 0.04 + ROBOT] = 0
    _, labels = cv2.connectedComponents(free, connectivity=4)
    return np.asarray(labels, dtype=np.int32), (x0, y0)


def _cell(point: Point, origin: Point) -> tuple[int, int]:
    return int((point[1] - origin[1]) / _CELL), int((point[0] - origin[0]) / _CELL)
