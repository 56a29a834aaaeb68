"""Scenes by their name or path: the YAML files that come with sayso, people's own, and those made up from a seed.

People can read and change a scene file; a mistake in it raises :class:`SceneError` naming the file and the key.
"""

from __future__ import annotations

import re
from importlib import resources
from pathlib import Path

import yaml
from pydantic import ValidationError

from config.nearest import did_you_mean
from engine.errors import SceneError
from engine.robot.sim.clutter import clutter
from engine.robot.sim.scene import Scene

_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # the one in C is ten times as fast, where it was built

CLUTTER = re.compile(r"clutter-(\d{1,9})")
"""Names of scenes that are made up from a seed: ``clutter-7``."""


def scene_names() -> tuple[str, ...]:
    """Names of the scenes that come with sayso as files."""
    return tuple(sorted(path.stem for path in _folder().glob("*.yaml")))


def scene_path(name: str) -> Path:
    """Where a scene is: the name of one that comes with sayso, or a path. One that is made up has its name for a path.
    Raises :class:`SceneError`."""
    if CLUTTER.fullmatch(name):
        return Path(name)
    if name.endswith((".yaml", ".yml")) or "/" in name:
        path = Path(name).expanduser()
        if not path.is_file():
            raise SceneError(f"There is no scene file {path}.", hint="Check robot.scene in your configuration.")
        return path.resolve()
    path = _folder() / f"{name}.yaml"
    if not path.is_file():
        known = (*scene_names(), "clutter-SEED")
        raise SceneError(
            f"There is no scene called {name!r}.",
            hint=did_you_mean(name, known) or f"There are: {', '.join(known)}.",
        )
    return path


def _folder() -> Path:
    return Path(str(resources.files("assets") / "scenes"))


def load_scene(path: Path) -> Scene:
    """Read the scene that :func:`scene_path` found. Raises :class:`SceneError` that names the file and the key."""
    if made_up := CLUTTER.fullmatch(str(path)):
        return clutter(int(made_up[1]))
    try:
        raw = yaml.load(path.read_text(encoding="utf-8"), _Loader)  # noqa: S506 - both are safe loaders
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"The scene {path} cannot be read: {error}.") from error
    except yaml.YAMLError as error:
        raise SceneError(f"The scene {path} is not YAML: {error}.") from error
    try:
        return Scene.model_validate(raw)
    except ValidationError as error:
        raise SceneError(f"The scene {path} is wrong: {_first_fault(error)}.", hint=_more(error)) from error


def _first_fault(error: ValidationError) -> str:
    fault = error.errors()[0]
    key = ".".join(str(part) for part in fault["loc"])
    text = fault["msg"].removeprefix("Value error, ")
    if fault["type"] == "extra_forbidden":
        text = "this key means nothing here"
    return f"{key}: {text}" if key else text


def _more(error: ValidationError) -> str:
    rest = error.error_count() - 1
    return f"And {rest} more." if rest else ""
