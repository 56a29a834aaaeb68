"""Settings from all their layers, or a list of everything that is wrong with them.

Each layer wins over those before it: the defaults packaged with sayso; the files of the user's folder; files given
with ``--config``; environment variables (``SAYSO_ENDPOINT__SILENCE_S=0.8``); flags (``--set endpoint.silence_s=0.8``).
Any file may hold any section. Every value keeps the file and line it came from, for error messages and for
``sayso config show``.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from importlib import resources
from itertools import islice
from pathlib import Path
from typing import Any

from pydantic import BaseModel, SecretStr, ValidationError

from config import allowed
from config.errors import ConfigError, Problem, Where
from config.folders import FILES, RESERVED, paths
from config.merge import Filled, assignment, leave_out, merge, node_at, spelled
from config.mistakes import PACKAGED, Mistake, as_written, explained, misplaced, readable_secrets, wrong_booleans
from config.schema import Settings
from config.secrets import MASK, remember, without_secrets
from config.source import Node, SourceError, parse, parse_value, read

DEFAULTS = ("engine.yaml", "robot.yaml", "map.yaml", "people.yaml", "skills.yaml", "platforms.yaml", "profiles.yaml")
PREFIX = "SAYSO_"
FLAG = "--set"
MAX_TOLD = 50
"""Wrong keys and values that one run explains; whoever has more will come back."""
MAX_ROUNDS = 10
"""How often mistakes are left out to find what they hide."""

Plain = str | int | float | bool | list[Any] | dict[str, Any] | None


@dataclass(frozen=True, slots=True)
class Explained:
    """One setting in force."""

    path: tuple[str, ...]
    """Its keys from the top."""
    value: Plain
    """Secrets are masked, and where a variable was filled in its name stands instead of its value."""
    origin: str
    """File and line, variable or flag; ``default`` where nobody wrote anything."""

    @property
    def key(self) -> str:
        """Dotted name."""
        return ".".join(self.path)


@dataclass(frozen=True, slots=True)
class Examined:
    """Everything that is wrong, and what there is without that."""

    problems: tuple[Problem, ...]
    settings: Settings | None
    """Those in force where nothing is wrong; else with packaged ones for those that are wrong. None: there is no way
    to mend them."""
    explained: tuple[Explained, ...]
    layers: Mapping[str, int]
    """Files, variables and flags by their places in the reading order."""

    def in_order(self, problems: Iterable[Problem]) -> tuple[Problem, ...]:
        """As a person reads: layer by layer, line by line."""
        return tuple(sorted(problems, key=lambda it: (self.layers.get(it.where.name, -1), it.where.line)))


def load(
    files: Sequence[Path] = (),
    overrides: Sequence[str] = (),
    environ: Mapping[str, str] | None = None,
    user_folder: Path | None = None,
) -> Settings:
    """The settings in force.

    ``files`` are those of ``--config``, in order, and must exist; ``overrides`` are ``section.key=value``;
    ``environ`` stands for the process environment and ``user_folder`` for the configuration folder.
    Raises :class:`~config.errors.ConfigError` with all problems of all layers.
    """
    return _Load(files, overrides, environ, user_folder).settings()


def check(
    files: Sequence[Path] = (),
    overrides: Sequence[str] = (),
    environ: Mapping[str, str] | None = None,
    user_folder: Path | None = None,
) -> tuple[Problem, ...]:
    """Everything that is wrong; empty when :func:`load` would succeed."""
    return examine(files, overrides, environ, user_folder).problems


def examine(
    files: Sequence[Path] = (),
    overrides: Sequence[str] = (),
    environ: Mapping[str, str] | None = None,
    user_folder: Path | None = None,
) -> Examined:
    """Everything that is wrong, and the settings without it, of which other things may be wrong."""
    return _Load(files, overrides, environ, user_folder).examined()


def explain(
    files: Sequence[Path] = (),
    overrides: Sequence[str] = (),
    environ: Mapping[str, str] | None = None,
    user_folder: Path | None = None,
) -> tuple[Explained, ...]:
    """Every setting in force and where it was written. Raises ConfigError as :func:`load` does."""
    return _Load(files, overrides, environ, user_folder).explained()


def show(settings: Settings) -> dict[str, Any]:
    """The settings as plain data that YAML and JSON can hold, with secrets masked."""
    plain = _plain(settings)
    assert isinstance(plain, dict)
    return plain


class _Load:
    """One run through all layers."""

    def __init__(
        self, files: Sequence[Path], overrides: Sequence[str], environ: Mapping[str, str] | None, folder: Path | None
    ) -> None:
        self.environ = os.environ if environ is None else environ
        self.problems: list[Problem] = []
        self.tree = Node({}, Where("sayso"))
        self._order: dict[str, int] = {}
        for name in DEFAULTS:
            data = resources.files("config").joinpath(name).read_bytes()
            self._lay(parse(data, f"{PACKAGED}{name}"))
        self._packaged = Filled(self.tree, self.environ).data
        self._user_files(folder or paths(self.environ).config)
        for path in files:
            self._file(path, required=True)
        self._variables()
        for text in overrides:
            key, equals, value = text.partition("=")
            where = Where(f"{FLAG} {key}")
            if not equals or not all(key.split(".")):
                self.problems.append(Problem(where, "", "is no setting; write section.key=value"))
            else:
                self._assign(tuple(key.split(".")), value, where)
        self.filled = Filled(self.tree, self.environ)

    def settings(self) -> Settings:
        """Raises ConfigError with all problems."""
        examined = self.examined()
        if examined.problems:
            raise ConfigError(examined.problems)
        assert examined.settings is not None
        remember(examined.settings)
        return examined.settings

    def examined(self) -> Examined:
        """Validate, and go on without what is wrong, which may hide more."""
        found = [*self.problems, *self.filled.problems, *wrong_booleans(self.tree)]
        data, settings, mistakes = deepcopy(self.filled.data), None, list[Mistake]()
        for _ in range(MAX_ROUNDS):
            try:
                settings = Settings.model_validate(data)
                break
            except ValidationError as error:
                told = {(problem.where, problem.key) for problem in found}
                new = tuple(explained(error, self.tree, self.filled.raw))
                news = (mistake.problem for mistake in new if not mistake.follows_from(mistakes))
                found += islice((item for item in news if (item.where, item.key) not in told), MAX_TOLD)
                mistakes += new
                changes = [leave_out(data, mistake.path, self._packaged) for mistake in new]
                if not any(changes):
                    break
        chosen = () if settings is None else self._of(settings)
        examined = Examined((), settings, chosen, self._order)
        return replace(examined, problems=examined.in_order(dict.fromkeys(found)))

    def explained(self) -> tuple[Explained, ...]:
        return self._of(self.settings())

    def _of(self, settings: Settings) -> tuple[Explained, ...]:
        return tuple(self._explained(path, value) for path, value in _flat(show(settings)))

    def _explained(self, path: tuple[str, ...], value: Plain) -> Explained:
        node, depth = node_at(self.tree, path)
        raw = self.filled.raw
        if isinstance(value, list):
            value = [raw.get((*path, str(index)), item) for index, item in enumerate(value)]
        elif path in raw and value != MASK:
            value = without_secrets(raw[path])
        return Explained(path, value, str(node.where) if depth == len(path) else "default")

    def _user_files(self, folder: Path) -> None:
        for name in FILES:
            self._file(folder / name, required=False)
            misnamed = (folder / name).with_suffix(".yml")
            if os.path.lexists(misnamed):
                self.problems.append(Problem(Where(str(misnamed)), "", "is not read", nearest=name))

    def _file(self, path: Path, *, required: bool) -> None:
        try:
            layer = read(path)
            self.problems += readable_secrets(layer, path)
            self._lay(layer)
        except SourceError as error:
            self.problems.append(error.problem)
        except FileNotFoundError:
            if required:
                self.problems.append(Problem(Where(str(path)), "", "does not exist"))

    def _variables(self) -> None:
        names = sorted(name for name in self.environ if name.startswith(PREFIX) and name not in RESERVED)
        for name in names:
            words = name.removeprefix(PREFIX)
            where = Where(name)
            if "__" in words:
                self._assign(tuple(words.split("__")), self.environ[name], where)
            elif meant := _misspelled(words):
                nearest = as_written(meant, where)
                self.problems.append(Problem(where, "", "is no setting", nearest=nearest))

    def _assign(self, path: tuple[str, ...], text: str, where: Where) -> None:
        """Set one key from the text of a variable or a flag."""
        path = spelled(path, self.tree)
        try:
            text.encode()
            value = parse_value(text, where)
        except UnicodeEncodeError:
            self.problems.append(Problem(where, ".".join(path), "its value is not UTF-8 text"))
            return
        except SourceError as error:
            self.problems.append(error.problem)
            return
        self._lay(assignment(path, value))

    def _lay(self, layer: Node) -> None:
        """Put one more layer on top."""
        self._order.setdefault(layer.where.name, len(self._order))
        self.problems += misplaced(layer)
        self.tree = merge(self.tree, layer)


def _misspelled(words: str) -> tuple[str, ...] | None:
    """The setting that a variable with single underscores was meant for: ASR_MODEL is asr.model."""
    bare = words.replace("_", "").casefold()
    for name in allowed.settings():
        if name.replace(".", "").replace("_", "") == bare:
            return tuple(name.split("."))
    return None


def _plain(value: Any) -> Any:
    match value:
        case BaseModel():
            return {name: _plain(getattr(value, name)) for name in type(value).model_fields}
        case dict():
            return {key: _plain(item) for key, item in value.items()}
        case tuple() | list():
            return [_plain(item) for item in value]
        case SecretStr():
            return MASK
        case Path():
            return str(value)
        case str():
            return without_secrets(value)
    return value


def _flat(data: Mapping[str, Any], path: tuple[str, ...] = ()) -> Iterable[tuple[tuple[str, ...], Plain]]:
    for key, value in data.items():
        if isinstance(value, dict) and value:
            yield from _flat(value, (*path, key))
        else:
            yield (*path, key), value
