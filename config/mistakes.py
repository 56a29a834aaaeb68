"""From what pydantic rejects to sentences that name the line, what is allowed there and what was probably meant."""

from __future__ import annotations

import re
import stat
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Any, Final, Literal

from pydantic import ValidationError

from config import allowed
from config.allowed import Path
from config.errors import Problem, Where
from config.merge import leaves, node_at
from config.nearest import nearest
from config.schema import Unfit
from config.secrets import secrets_of_url
from config.source import Node

PACKAGED = "packaged "
"""How the names of sayso's own files begin; a mistake is hardly there."""

_VARIABLE = re.compile(r"(?<!\$)\$\{[A-Za-z_][A-Za-z0-9_]*\}")


_PROFILE: Final = ("planner", "profile")


@dataclass(frozen=True, slots=True)
class Mistake:
    """A problem that validation found, and the setting without which it would not be there."""

    problem: Problem
    path: Path
    kind: Literal["unknown", "missing", "value", "together"]
    """``together``: several settings do not fit each other."""
    rests_on: frozenset[str] = frozenset()
    """Whole sections that have to fit each other."""

    def follows_from(self, earlier: Collection[Mistake]) -> bool:
        """Whether it may be there only because settings with mistakes of their own were left out."""
        match self.kind:
            case "missing":
                return any(".".join(mistake.path) == self.problem.key for mistake in earlier)
            case "together" if self.rests_on:
                return any(mistake.path[0] in self.rests_on for mistake in earlier if mistake.kind != "unknown")
            case "together":
                values = (mistake.path for mistake in earlier if mistake.kind == "value")
                return any(path[: len(self.path)] == self.path for path in values)
        return False


def explained(error: ValidationError, tree: Node, raw: Mapping[Path, str]) -> Iterator[Mistake]:
    """One mistake for each place that is wrong, however many alternatives pydantic tried there."""
    told: set[Path] = set()
    for item in error.errors(include_url=False, include_input=False):
        location = tuple(map(str, item["loc"]))
        if item["type"] == "missing":
            path = location
            found = Mistake(_missing(path, tree), path[:-1], "missing")
        else:
            node, depth = node_at(tree, location)
            path = location[:depth]
            reason = item.get("ctx", {}).get("error")
            together = isinstance(reason, Unfit) or (reason is not None and isinstance(node.value, dict))
            kind: Literal["unknown", "value", "together"] = "together" if together else "value"
            kind = "unknown" if item["type"] == "extra_forbidden" else kind
            found = Mistake(_rejected(path, node, item, tree, raw), path, kind)
            if isinstance(reason, Unfit):
                services = set() if reason.path == _PROFILE else {"platforms", reason.path[0]}
                found = replace(found, path=reason.path, rests_on=frozenset({"planner", "profiles"} | services))
        if path not in told:
            told.add(path)
            yield found


def wrong_booleans(tree: Node) -> Iterator[Problem]:
    """true and false where a number is expected, which pydantic would read as 1 and 0."""
    for path, node in leaves(tree):
        types = allowed.types_at(path)
        if isinstance(node.value, bool) and types & {"number", "integer"} and "boolean" not in types:
            yield Problem(node.where, ".".join(path), _rejection(node), allowed.describe(path))


def misplaced(layer: Node, path: Path = ()) -> Iterator[Problem]:
    """Values where a section is expected. Nothing at all may stand there: a section without entries."""
    if isinstance(layer.value, dict):
        for key, child in layer.value.items():
            yield from misplaced(child, (*path, key))
    elif layer.value is not None and (allowed.keys_at(path) or allowed.is_open(path)):
        yield Problem(layer.where, ".".join(path), _rejection(layer, secret=_secret(path)), allowed.describe(path))


def readable_secrets(layer: Node, file: FilePath) -> Iterator[Problem]:
    """Keys that are written out in a file which others may read."""
    if not file.stat().st_mode & (stat.S_IRWXG | stat.S_IRWXO):
        return
    for path, node in leaves(layer):
        if not isinstance(node.value, str):
            continue
        written = _VARIABLE.sub("", node.value)  # what a variable holds does not stand here
        literal = written.strip() if "password" in allowed.types_at(path) else next(secrets_of_url(written), "")
        if literal:
            message = "a key stands here, and others may read this file; write ${VARIABLE}, or `chmod 600` the file"
            yield Problem(node.where, ".".join(path), message)


def as_written(path: Path, where: Where) -> str:
    """A setting's name in the way that it is written at that kind of place."""
    if where.name.startswith("SAYSO_") and not where.line:
        return "SAYSO_" + "__".join(path).upper()
    return ".".join(path)


def _missing(path: Path, tree: Node) -> Problem:
    parent, _ = node_at(tree, path[:-1])
    return Problem(parent.where, ".".join(path), "is missing", allowed.describe(path))


def _rejected(path: Path, node: Node, item: Any, tree: Node, raw: Mapping[Path, str]) -> Problem:
    key = ".".join(path)
    if item["type"] == "extra_forbidden":
        return _unknown(path, node)
    if item["type"] in {"value_error", "assertion_error"}:
        reason = item["ctx"]["error"]
        if isinstance(reason, Unfit):
            node, _ = node_at(tree, reason.path)
            near = nearest(str(node.value), reason.choices)
            return Problem(node.where, ".".join(reason.path), str(reason), nearest=near)
        nodes = [node_at(tree, (*path, symbol))[0] for symbol in reversed(getattr(reason, "symbols", ()))]
        by_user = [place for place in nodes if not place.where.name.startswith(PACKAGED)]
        where = (by_user or nodes or [node])[0].where
        return Problem(where, key, str(reason))
    shape = allowed.shape_at(path) or {}
    choices = [str(choice) for choice in shape.get("enum", ())]
    near = nearest(str(node.value), choices) if isinstance(node.value, str) else ""
    shown = _rejection(node, raw.get(path), secret=_secret(path))
    return Problem(node.where, key, shown, allowed.describe(path), near)


def _secret(path: Path) -> bool:
    """Whether a key may stand there, if only by mistake: one line too high, or in the wrong line."""
    return path[:1] == ("platforms",) or "password" in allowed.types_at(path)


def _unknown(path: Path, node: Node) -> Problem:
    parent, last = path[:-1], path[-1]
    whole = path
    while not node.where.line and isinstance(node.value, dict) and len(node.value) == 1:  # a variable or a flag
        [(key, node)] = node.value.items()
        whole = (*whole, key)
    meant = allowed.nearest_setting(whole)
    if node.where.line and meant[:-1] == parent:
        near = meant[-1] if meant else ""
    else:
        near = as_written(meant, node.where) if meant else ""
    keys = ", ".join(allowed.keys_at(parent))
    where = "a section" if not parent else f"a key of {'.'.join(parent)}"
    return Problem(node.where, ".".join(path), f"{last} is not {where}", keys, near)


def _rejection(node: Node, raw: str | None = None, *, secret: bool = False) -> str:
    match node.value:
        case dict():
            shown = "a section"
        case list():
            shown = "a list"
        case None:
            shown = "nothing (null)"
        case bool():
            shown = str(node.value).lower()
        case _ if secret:
            shown = "this value"
        case value:
            shown = f"{raw if raw is not None else value!r:.80}"
    return f"{shown} is not allowed here"
