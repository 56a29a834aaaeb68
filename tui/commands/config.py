"""``sayso config``: the settings in force and where each was written, the files, and what is wrong with them."""

from __future__ import annotations

import contextlib
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

import yaml

from config import ConfigError, Explained, examine, explain, load, paths
from engine.errors import ExitCode
from tui.checking import wrong_names
from tui.commands.settings import overrides
from tui.output import data, json_line, say

_ORIGIN_COLUMN = 44


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
        names = (problem for problem in wrong_names(settings, examined.explained) if problem.key not in told)
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
