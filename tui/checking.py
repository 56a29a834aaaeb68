"""What is wrong with settings beyond their schema: a name of something that there is not, or a key that cannot be had.

``sayso config check`` and the page of the settings ask here, so that neither takes what the other refuses.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from config import Explained, Problem
from config.errors import Where
from config.nearest import did_you_mean
from config.schema import Settings
from engine.errors import SaysoError, UsageError

_KEYS: Final = ("console", "keys")


def wrong_names(settings: Settings, found: Sequence[Explained]) -> Iterator[Problem]:
    """What stands for something that there is not, or cannot be: beyond the schema, by whoever it is a name for."""
    from engine.skills.library import LIBRARY

    by_key = {setting.key: setting for setting in found}
    yield from _wrong_keys([setting for setting in found if setting.path[:2] == _KEYS != setting.path])
    for key, look in (("robot.scene", _scene), ("asr.model", _recogniser), ("console.theme", _theme)):
        try:
            look(settings)
        except SaysoError as error:
            yield _problem(by_key[key], str(error))
    taken = {skill.name for skill in LIBRARY} & settings.skills.keys()
    for name in sorted(taken):
        setting = next(setting for setting in found if setting.path[:2] == ("skills", name))
        yield Problem(
            _where(setting), f"skills.{name}", "there is a built-in skill of this name; give yours another one"
        )


def _scene(settings: Settings) -> None:
    """Raises :class:`SceneError`."""
    from engine.robot.sim.scene_file import load_scene, scene_path

    load_scene(scene_path(settings.robot.scene))


def _recogniser(settings: Settings) -> None:
    """Whether there is such a model; it need not be fetched. Raises :class:`ModelError`."""
    from engine.asr.sizes import is_size, listed
    from engine.parts.loading import model_store, speech_folder

    name = settings.asr.model
    if settings.asr.backend != "whisper" or speech_folder(settings) is not None:
        return
    manifest = model_store(settings).manifest
    if listed(name, manifest.models) is None and not is_size(name):
        manifest[name]


def _theme(settings: Settings) -> None:
    """Raises :class:`UsageError`."""
    check_theme(settings.console.theme)


def check_theme(name: str) -> None:
    """Whether there is a theme of this name. Raises :class:`UsageError`, with the nearest one and all of them."""
    from textual.theme import BUILTIN_THEMES  # 0.1 s, and here alone outside of the console

    from tui.looks.themes import CONTRAST, DARK, LIGHT

    known = (*(theme.name for theme in (DARK, LIGHT, CONTRAST)), *BUILTIN_THEMES)
    if name not in known:
        hint = " ".join(filter(None, (did_you_mean(name, known), f"There are: {', '.join(known)}.")))
        raise UsageError(f"There is no theme called {name!r}.", hint=hint)


def _wrong_keys(chosen: Sequence[Explained]) -> Iterator[Problem]:
    """What is wrong with the keys that somebody chose for the console."""
    if not chosen:
        return
    from tui.keys.keymap import keymap

    by_action = {setting.path[-1]: setting for setting in chosen}
    for mistake in keymap({action: str(setting.value) for action, setting in by_action.items()}).mistakes:
        yield _problem(by_action[mistake.action], mistake.message)


def _problem(setting: Explained, message: str) -> Problem:
    return Problem(_where(setting), setting.key, message)


def _where(setting: Explained) -> Where:
    name, _, line = setting.origin.rpartition(":")
    return Where(name, int(line)) if name and line.isdecimal() else Where(setting.origin)
