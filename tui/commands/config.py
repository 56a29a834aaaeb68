"""``sayso config``: the settings in force and where each was written, the files, and what is wrong with them."""

from __future__ import annotations

import contextlib
import difflib
from argparse import Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path

import yaml

from config import ConfigError, Explained, Problem, examine, explain, load, paths
from config.errors import Where
from config.schema import Settings
from engine.errors import ExitCode, SaysoError, UsageError
from tui.commands.settings import overrides
from tui.output import data, json_line, say

_ORIGIN_COLUMN = 44
_KEYS = ("console", "keys")


def run(arguments: Namespace) -> int:
    """The command as the command line gives it."""
    files = arguments.config or ()
    match arguments.action:
        case "show":
            return config_show(files, overrides(arguments), json=arguments.json)
        case "path":
            return config_path(files, overrides(arguments), json=arguments.json)
        case _:
            return config_check(files, overrides(arguments), json=arguments.json)


def config_show(files: Sequence[Path] = (), flags: Sequence[str] = (), *, json: bool = False) -> int:
    """Every setting: YAML with its origin as a comment, or one JSON object a setting. Raises ConfigError."""
    settings = explain(files, flags)
    if json:
        for setting in settings:
            json_line({"key": setting.key, "value": setting.value, "origin": setting.origin})
    else:
        data("\n".join(_as_yaml(settings)))
    return int(ExitCode.DONE)


def config_path(files: Sequence[Path] = (), flags: Sequence[str] = (), *, json: bool = False) -> int:
    """The folders, and the files in reading order. Works whatever is wrong inside them."""
    folders = paths()
    reading = [*folders.files, *files]
    models = folders.models
    with contextlib.suppress(ConfigError):  # nothing is kept anywhere until that is mended
        models = load(files, flags).models.folder or models
    if json:
        listed = [{"path": str(file), "exists": file.exists()} for file in reading]
        json_line(
            {
                "config": str(folders.config),
                "models": str(models),
                "logs": str(folders.logs),
                "files": listed,
            }
        )
    else:
        data(f"config  {folders.config}\nmodels  {models}\nlogs    {folders.logs}")
        for file in reading:
            data(f"file    {file}{'' if file.exists() else '  (not there)'}")
    return int(ExitCode.DONE)


def config_check(files: Sequence[Path] = (), flags: Sequence[str] = (), *, json: bool = False) -> int:
    """One problem a line, like a compiler. Exit code 2 when there is one."""
    examined = examine(files, flags)
    problems = [*examined.problems]
    if (settings := examined.settings) is not None:
        told = {problem.key for problem in problems}
        names = (problem for problem in _wrong_names(settings, examined.explained) if problem.key not in told)
        problems = [*examined.in_order((*problems, *names))]
    for problem in problems:
        if json:
            json_line(
                {
                    "file": problem.where.name,
                    "line": problem.where.line or None,
                    "key": problem.key,
                    "message": problem.message,
                    "allowed": problem.allowed,
                    "nearest": problem.nearest,
                }
            )
        else:
            data(str(problem))
    if problems:
        say(f"sayso: {len(problems)} problem{'s' if len(problems) > 1 else ''} in the configuration.")
        return ConfigError.exit_code
    say("sayso: the configuration is right.")
    return int(ExitCode.DONE)


def _wrong_names(settings: Settings, found: Sequence[Explained]) -> Iterator[Problem]:
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
    from textual.theme import BUILTIN_THEMES  # 0.1 s, and here alone outside of the console

    from tui.looks.themes import CONTRAST, DARK, LIGHT

    name, known = settings.console.theme, (*BUILTIN_THEMES, *(theme.name for theme in (DARK, LIGHT, CONTRAST)))
    if name not in known:
        near = difflib.get_close_matches(name, known, 1, 0.5)
        hint = f"Did you mean {near[0]}?" if near else f"There are: {', '.join(known)}."
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


def _as_yaml(settings: Sequence[Explained]) -> list[str]:
    """The settings as YAML that can be read back, apart from masked secrets."""
    lines: list[str] = []
    section: tuple[str, ...] = ()
    for setting in settings:
        *parents, name = setting.path
        common = 0
        while common < min(len(parents), len(section)) and parents[common] == section[common]:
            common += 1
        for depth in range(common, len(parents)):
            lines.append(f"{'  ' * depth}{_scalar(parents[depth])}:")
        section = tuple(parents)
        line = f"{'  ' * len(parents)}{_scalar(name)}: {_scalar(setting.value)}"
        lines.append(f"{line:<{_ORIGIN_COLUMN}}  # {setting.origin}")
    return lines


def _scalar(value: object) -> str:
    """A value on one line, quoted where YAML needs it."""
    text: str = yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=1 << 20)
    return text.removesuffix("\n").removesuffix("\n...")
