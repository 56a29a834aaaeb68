"""What a person sets from within sayso: tested by the schema, and written into a file of the user's folder.

A setting goes where the user has written it before, or else into ``config.yaml``. What goes before the user's files (a
file of ``--config``, a variable, an option) still does; it is named, so that nobody wonders.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from config import allowed
from config.allowed import Path as Keys
from config.editing import NotEditable, Value, as_yaml, with_value, without
from config.errors import ConfigError
from config.folders import FILES, paths
from config.loader import Explained, explain, load
from config.merge import node_at
from config.mistakes import PACKAGED
from config.schema import Settings
from config.source import Node, SourceError, read
from config.writing import write_whole


class NotWritten(Exception):
    """A setting could not be set; the message is for people."""


@dataclass(frozen=True, slots=True)
class Layers:
    """Where settings come from, as :func:`config.load` is given it."""

    files: tuple[Path, ...] = ()
    overrides: tuple[str, ...] = ()
    environ: Mapping[str, str] | None = None
    folder: Path | None = None

    def load(self, *more: str) -> Settings:
        """The settings in force; ``more``: as if these options (``section.key=value``) were given, too."""
        return load(self.files, (*self.overrides, *more), self.environ, self.folder)

    def explain(self) -> dict[str, Explained]:
        """Every setting in force by its dotted name, and where it was written."""
        return {found.key: found for found in explain(self.files, self.overrides, self.environ, self.folder)}

    @property
    def own(self) -> tuple[Path, ...]:
        """The files of the user's folder, in reading order."""
        folder = self.folder or paths(self.environ).config
        return tuple(folder / name for name in FILES)

    def written_by(self, path: Keys) -> Path:
        """The user's file that says something of a setting, or in which it is to be said."""
        for file in reversed(self.own):
            if _node(file, path) is not None:
                return file
        return self.own[0]


@dataclass(frozen=True, slots=True)
class Changed:
    """A setting as it is now."""

    setting: Explained
    """What is in force; not what was written where something goes before the file."""
    file: Path | None
    """What was written; None where nothing had to be."""
    overridden: bool
    """Something goes before what the file says."""


def described(path: Keys) -> str:
    """What a setting means, in the schema's words."""
    return str((allowed.shape_at(path) or {}).get("description", ""))


def choices(path: Keys) -> tuple[str, ...]:
    """The words that may stand there, where they are few."""
    shape = allowed.shape_at(path) or {}
    return tuple(map(str, shape.get("enum", ("true", "false") if shape.get("type") == "boolean" else ())))


def change(layers: Layers, path: Keys, value: Value) -> Changed:
    """Set a setting. Raises :class:`NotWritten` when the schema does not allow it or the file cannot be written."""
    try:
        layers.load(f"{'.'.join(path)}={as_yaml(value)}")
    except NotEditable as error:
        raise NotWritten(str(error)) from error
    except ConfigError as error:
        raise NotWritten(_why(error, path)) from error
    file = layers.written_by(path)
    _edit(file, lambda text: with_value(text, path, value))
    setting = layers.explain()[".".join(path)]
    listed = list(value) if isinstance(value, list | tuple) else value
    return Changed(setting, file, not _is_from(setting, file) and setting.value != listed)


def give_back(layers: Layers, path: Keys) -> Changed:
    """Take a setting out of the user's files: what sayso comes with holds again. Raises :class:`NotWritten`."""
    written = [file for file in layers.own if _node(file, path) is not None]
    for file in written:
        _edit(file, lambda text: without(text, path))
    setting = layers.explain()[".".join(path)]
    return Changed(setting, next(iter(written), None), not is_packaged(setting))


def overriding(setting: Explained, layers: Layers) -> str:
    """What goes before the user's files here: a variable, an option, or a file that was given; nothing, where they
    hold."""
    return "" if is_packaged(setting) or any(_is_from(setting, file) for file in layers.own) else setting.origin


def _is_from(setting: Explained, file: Path) -> bool:
    return setting.origin.rpartition(":")[0] == str(file)


def is_packaged(setting: Explained) -> bool:
    """It is what sayso comes with."""
    return setting.origin == "default" or setting.origin.startswith(PACKAGED)


def _node(file: Path, path: Keys) -> Node | None:
    """What a file says of a setting, if anything."""
    with contextlib.suppress(FileNotFoundError, SourceError):
        node, depth = node_at(read(file), path)
        return node if depth == len(path) else None
    return None


def _why(error: ConfigError, path: Keys) -> str:
    """What is wrong with the value; or with other settings, while no value can be tested."""
    key = ".".join(path)
    own = [problem for problem in error.problems if problem.key == key]
    found = own[0] if own else error.problems[0]
    if not own:
        return str(found)
    allows = f"; allowed: {found.allowed}" if found.allowed else ""
    return f"{found.message}{allows}"


def _edit(file: Path, edit: Callable[[str], str]) -> None:
    """Write the file anew as a whole; the old one stands until the new one is whole. Raises :class:`NotWritten`."""
    real = Path(os.path.realpath(file))  # whoever keeps it elsewhere and links to it keeps the link
    try:
        mode, old = 0o600, ""
        with contextlib.suppress(FileNotFoundError), real.open(encoding="utf-8", newline="") as written:
            old, mode = written.read(), os.fstat(written.fileno()).st_mode & 0o777
        text = edit(old)
        if text == old:
            return
        write_whole(real, text.encode(), mode=mode)
    except NotEditable as error:
        raise NotWritten(f"{file} cannot be changed from here ({error}); edit it by hand") from error
    except UnicodeDecodeError as error:
        raise NotWritten(f"{file} is not UTF-8 text; save it as UTF-8") from error
    except OSError as error:
        raise NotWritten(f"{file} could not be written: {error.strerror or error}; it is as it was") from error
