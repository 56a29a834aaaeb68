"""Following and guiding one of three people who walk about near each other, in different clothes.

Following is kept up for a minute: the right one must be near for most of it, and at its end. Guiding is done when the
right one has arrived at the place, and the robot with them.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime
from typing import Any, Final, Literal

import numpy as np

from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_parts import Point
from tests.eval.gpsr.goal import Command, Goal, MustBe, Needs, Want
from tests.eval.gpsr.judge import Verdict, judge
from tests.eval.gpsr.lexicon import Language
from tests.eval.gpsr.perform import run_in

Company = Literal["following", "guiding"]
FOLLOWED_S: Final = 60
GUIDED_S: Final = 240.0
_SHIRTS: Final[Mapping[str, str]] = {
    "red": "红", "blue": "蓝", "green": "绿", "yellow": "黄", "purple": "紫", "orange": "橙"
}  # fmt: skip
_INSIDE: Final = 1.5
"""Where the robot begins, m from the middle: in nobody's way, who would wait for it."""
_NAMES: Final = ("Linda", "John", "Mary")
_LANE: Final = 0.7
"""Between one who walks and the next, m."""
_HALF: Final = (4.5, 4.0)  # of the hall, m


def among(kind: Company, seed: int, *, language: Language = "en") -> tuple[Scene, Command]:
    """The hall of a seed, and what is said in it. The right one is ``person 1``."""
    rng = np.random.default_rng([seed, 3])
    shirts = [str(colour) for colour in rng.permutation(list(_SHIRTS))][:3]
    places = {"door": {"at": (-3.6, -3.1), "yaw": 180, "aliases": ("门口",)},
              "window": {"at": (3.6, 3.1), "yaw": 0, "aliases": ("窗边",)}}  # fmt: skip
    begin = float(rng.uniform(-math.pi, math.pi))
    people = {f"person {index + 1}": _walker(rng, begin, index, shirt) for index, shirt in enumerate(shirts)}
    x, y = people["person 1"]["path"][0]
    start = _before(rng, (x, y), [person["path"][0] for person in people.values()])
    scene = Scene.model_validate(
        {
            "name": f"{kind}-{seed}",
            "bounds": {"x": (-_HALF[0], _HALF[0]), "y": (-_HALF[1], _HALF[1])},
            "start": {"x": start[0], "y": start[1], "yaw": math.degrees(math.atan2(y - start[1], x - start[0]))},
            "rooms": {"hall": {"x": (-_HALF[0], _HALF[0]), "y": (-_HALF[1], _HALF[1]), "aliases": ("大厅",)}},
            "furniture": {
                "palm": {"kind": "plant", "at": (4.1, -3.6), "size": (0.5, 0.5, 1.1), "colour": "terracotta"},
                "bench": {"kind": "low_table", "at": (-4.2, 3.0), "size": (0.9, 0.4, 0.14), "turn": 90},
            },
            "landmarks": list(_landmarks()),
            "people": people,
            "places": places,
        }
    )
    to = str(rng.choice(list(places)))
    return scene, _command(kind, seed, language, shirts[0], to)


def perform_among(
    kind: Company,
    seed: int,
    *,
    language: Language = "en",
    speed: str = "max",
    settings: Mapping[str, str] | None = None,
) -> Verdict:
    """Say it to an engine in the hall of a seed, and judge what becomes of it."""
    began = time.monotonic()
    scene, command = among(kind, seed, language=language)
    limit_s = FOLLOWED_S if kind == "following" else GUIDED_S
    run = run_in(scene, command, speed=speed, limit_s=limit_s, settings=settings or {})
    verdict = judge(command, run, datetime.now())
    return replace(verdict, wall_s=time.monotonic() - began)


def _command(kind: Company, seed: int, language: Language, shirt: str, to: str) -> Command:
    chinese = {"door": "门口", "window": "窗边"}[to]
    if kind == "following":
        english, text = f"follow the person in the {shirt} shirt", f"跟着穿{_SHIRTS[shirt]}衣服的人"
        wants: tuple[Want, ...] = (Want(("follow",), (shirt, _SHIRTS[shirt])),)
        truths = (MustBe("kept", "person 1", count=FOLLOWED_S),)
    else:
        english = f"guide the person in the {shirt} shirt to the {to}"
        text = f"带穿{_SHIRTS[shirt]}衣服的人去{chinese}"
        wants = (Want(("guide",), (shirt, _SHIRTS[shirt]), places=(to,)),)
        truths = (MustBe("arrived", "person 1", place=to),)
    said = text if language == "zh" else english
    return Command(seed, seed, kind, kind, (), language, said, Needs(), Goal(wants, truths))


def _walker(rng: np.random.Generator, begin: float, index: int, shirt: str) -> dict[str, Any]:
    """Somebody who walks round the hall. The second walks the other way, the third slower or faster than the first, so
    that each of them comes near the right one, and whoever keeps near another one does not keep near that. Each has a
    lane of their own: people do not walk through each other."""
    round_ = float(rng.uniform(2.3, 2.5)) + (0.0, _LANE, -_LANE)[index]
    angle, way = begin + (0.0, 1.2, -0.5)[index], -1 if index == 1 else 1
    speed = float(rng.uniform(0.24, 0.3)) * (1.0, 1.0, float(rng.choice([0.55, 1.5])))[index]
    corners = [angle + way * turn * math.pi / 6 for turn in range(12)]
    return {
        "path": [(round(round_ * math.cos(a), 2), round(round_ * math.sin(a), 2)) for a in corners],
        "speed": round(speed, 2),
        "height": round(float(rng.uniform(1.6, 1.85)), 2),
        "shirt": shirt,
        "trousers": str(rng.choice(["black", "blue", "grey"])),
        "called": _NAMES[index],
        "gender": "male" if _NAMES[index] == "John" else "female",
    }


def _before(rng: np.random.Generator, target: Point, people: list[Point]) -> Point:
    """Where the robot begins: near the right one, and not in anybody's way."""
    found = target
    for _ in range(500):
        away, angle = float(rng.uniform(1.4, 2.0)), float(rng.uniform(-math.pi, math.pi))
        found = (round(target[0] + away * math.cos(angle), 2), round(target[1] + away * math.sin(angle), 2))
        if math.hypot(*found) < _INSIDE and all(math.dist(found, person) > 1.2 for person in people):
            break
    return found


def _landmarks() -> list[dict[str, Any]]:
    width, height = _HALF
    faces = [
        ((part * width, y), facing)
        for part in (-0.7, -0.25, 0.25, 0.7)
        for y, facing in ((-height + 0.055, 90), (height - 0.055, 270))
    ]
    faces += [
        ((x, part * height), facing)
        for part in (-0.6, 0.0, 0.6)
        for x, facing in ((-width + 0.055, 0), (width - 0.055, 180))
    ]
    return [
        {"id": 100 + index, "at": (round(at[0], 3), round(at[1], 3)), "z": 0.36, "facing": facing, "size": 0.24}
        for index, (at, facing) in enumerate(faces)
    ]
