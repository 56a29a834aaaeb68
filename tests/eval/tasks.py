"""The tasks of the suite: what is said, in which scene, and what must be true afterwards.

``tasks.yaml`` has one entry a kind. With a seed an entry becomes a :class:`Trial`: the scene is made up or shaken from
the seed, and ``{thing}`` and other names in the text stand for what the seed chose.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
import yaml
from pydantic import BaseModel, ConfigDict, Field

from engine.robot.sim.clutter import clutter
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_file import load_scene, scene_path

FILE = Path(__file__).parent / "tasks.yaml"
SHAKE = 0.015
"""How far things of a scene from a file are moved aside by a seed, m; they also turn."""


class _Entry(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class MadeUp(_Entry):
    """A cluttered scene with so many things and rooms."""

    things: int
    rooms: int = 1


class Choice(_Entry):
    """One of the scene's things: on the floor or on a table, of these kinds."""

    source: Literal["floor", "table"] | None = Field(default=None, alias="from")
    kinds: tuple[str, ...] = ("box", "cup", "bottle", "ball")


class Task(_Entry):
    """One kind of task."""

    say: str
    scene: str | MadeUp
    choose: dict[str, Choice] = {}
    changes: dict[str, Any] = Field(default={}, description="Laid over the scene; null takes an entry away.")
    settings: dict[str, str] = {}
    limit_s: float = Field(default=300, gt=0, description="Robot time.")
    watch_s: float | None = Field(default=None, gt=0, description="An endless task is interrupted after this.")
    success: tuple[dict[str, Any], ...] = Field(min_length=1)


class Trial(_Entry):
    """A task with a seed."""

    kind: str
    seed: int
    say: str
    scene: Scene
    settings: dict[str, str]
    limit_s: float
    watch_s: float | None
    success: tuple[dict[str, Any], ...]


def tasks() -> dict[str, Task]:
    """All kinds."""
    raw = yaml.safe_load(FILE.read_text("utf-8"))
    return {kind: Task.model_validate(entry) for kind, entry in raw.items()}


def trial(kind: str, task: Task, seed: int) -> Trial:
    """What ``seed`` makes of a task."""
    rng = np.random.default_rng([seed, *kind.encode()])
    scene = _scene(task, seed, rng)
    words = _chosen(task, scene, rng)
    return Trial(
        kind=kind,
        seed=seed,
        say=task.say.format(**words),
        scene=scene,
        settings=task.settings,
        limit_s=task.limit_s,
        watch_s=task.watch_s,
        success=tuple(_filled(entry, words) for entry in task.success),
    )


def _scene(task: Task, seed: int, rng: np.random.Generator) -> Scene:
    if isinstance(task.scene, MadeUp):
        scene = clutter(seed, things=task.scene.things, rooms=task.scene.rooms)
        return Scene.model_validate(_laid_over(scene.model_dump(), task.changes))
    raw = load_scene(scene_path(task.scene)).model_dump()
    bases = {loose["stands_on"] for loose in raw["objects"].values()}
    for name, loose in raw["objects"].items():
        if name in bases or loose["stands_on"] in raw["objects"]:
            continue  # a stack stays a stack
        loose["at"] = tuple(round(v + float(rng.uniform(-SHAKE, SHAKE)), 4) for v in loose["at"])
        loose["turn"] = float(rng.integers(0, 90))
    return Scene.model_validate(_laid_over(raw, task.changes))


def _laid_over(below: Any, above: Any) -> Any:
    if not (isinstance(below, Mapping) and isinstance(above, Mapping)):
        return above
    merged = {key: value for key, value in below.items() if above.get(key, value) is not None or value is None}
    for key, value in above.items():
        if value is not None:
            merged[key] = _laid_over(below.get(key), value)
    return merged


def _chosen(task: Task, scene: Scene, rng: np.random.Generator) -> dict[str, str]:
    """A name for every choice, with its colour and what it stands on; ``{table}`` is any low table."""
    words: dict[str, str] = {}
    tables = sorted(name for name, piece in scene.furniture.items() if piece.kind == "low_table")
    for word, choice in task.choose.items():
        fitting = [
            name
            for name, loose in scene.objects.items()
            if loose.kind in choice.kinds
            and name not in words.values()
            and (choice.source is None or (loose.stands_on is None) == (choice.source == "floor"))
        ]
        if not fitting:
            raise LookupError(f"{scene.name} has nothing that {word} could be")
        words[word] = fitting[int(rng.integers(len(fitting)))]
        words[f"{word}_colour"] = scene.objects[words[word]].colour
        words[f"{word}_on"] = scene.objects[words[word]].stands_on or "floor"
    elsewhere = [name for name in tables if name not in words.values()]
    if elsewhere:
        words["table"] = elsewhere[int(rng.integers(len(elsewhere)))]
    return words


def _filled(value: Any, words: Mapping[str, str]) -> Any:
    """``value`` with the chosen names in all of its texts."""
    match value:
        case str():
            return value.format(**words) if "{" in value else value
        case dict():
            return {key: _filled(item, words) for key, item in value.items()}
        case list() | tuple():
            return [_filled(item, words) for item in value]
    return value
