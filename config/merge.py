"""Layers of settings laid over one another, and the variables in them filled in.

Sections merge key by key, lists and values replace. A place or platform set to null is removed. One that gives all
its required keys stands alone and inherits nothing (a new living room must not keep the old one's other names); with
fewer keys, or where none is required, it amends the one below. A section with nothing in it, as when all its lines are
commented out, changes nothing.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from copy import deepcopy
from pathlib import Path as FilePath
from typing import Any

from config import allowed
from config.allowed import Path
from config.errors import Problem, Where
from config.source import Node

_VARIABLE = re.compile(r"\$(\$\{|\{([^}]*)(\}?))")
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def merge(below: Node, above: Node, path: Path = ()) -> Node:
    """``above`` laid over ``below``; neither is changed.

    A value where a section belongs is left out: it is a mistake, and would hide those in the layers above.
    """
    if not isinstance(below.value, dict):
        return above
    if not isinstance(above.value, dict):
        return below
    children = dict(below.value)
    for key, node in above.value.items():
        here, old = (*path, key), children.get(key)
        if node.value is None and path and allowed.is_open(path):
            children.pop(key, None)
        elif old is None or _stands_alone(here, node):
            children[key] = node
        else:
            children[key] = merge(old, node, here)
    return Node(children, above.where)


def _stands_alone(path: Path, node: Node) -> bool:
    """Environment and flags give one key at a time: they always amend."""
    if not isinstance(node.value, dict) or not node.where.line or not allowed.is_open(path[:-1]):
        return False
    required = allowed.required_at(path)
    return bool(required) and required <= node.value.keys()


def assignment(path: Path, value: Node) -> Node:
    """The tree that sets one key."""
    for key in reversed(path):
        value = Node({key: value}, value.where)
    return value


def spelled(path: Path, tree: Node) -> Path:
    """``path`` with each key in the spelling that the schema or the tree has: environment variables are upper case."""
    result: Path = ()
    node: Node | None = tree
    for key in path:
        mapping = node.value if node is not None and isinstance(node.value, dict) else {}
        known = (*allowed.keys_at(result), *mapping)
        same = [choice for choice in known if choice.casefold() == key.casefold()]
        invented = key if allowed.is_open(result) else key.lower()
        found = key if key in known else (*same, invented)[0]
        result, node = (*result, found), mapping.get(found)
    return result


def leaves(node: Node, path: Path = ()) -> Iterator[tuple[Path, Node]]:
    """All values that are neither mappings nor lists."""
    match node.value:
        case dict():
            for key, child in node.value.items():
                yield from leaves(child, (*path, key))
        case list():
            for index, child in enumerate(node.value):
                yield from leaves(child, (*path, str(index)))
        case _:
            yield path, node


def node_at(tree: Node, path: Path) -> tuple[Node, int]:
    """The deepest node on the way to ``path``, and how many keys of it were found."""
    node = tree
    for depth, key in enumerate(path):
        match node.value:
            case dict() if key in node.value:
                node = node.value[key]
            case list() if key.isdecimal() and int(key) < len(node.value):
                node = node.value[int(key)]
            case _:
                return node, depth
    return node, len(path)


def leave_out(data: Any, path: Path, instead: Any) -> bool:
    """Put in plain ``data`` what stands at ``path`` in ``instead`` there, or nothing; whether that changed anything. Of
    a list, all is left out."""
    for key in path[:-1]:
        if not isinstance(data, dict) or not isinstance(data.get(key), dict | list):
            return False
        if isinstance(data[key], list):
            path = path[: path.index(key) + 1]
            break
        data, instead = data[key], instead.get(key) if isinstance(instead, dict) else None
    if not path or not isinstance(data, dict) or path[-1] not in data:
        return False
    before = data.pop(path[-1])
    if isinstance(instead, dict) and path[-1] in instead:
        data[path[-1]] = deepcopy(instead[path[-1]])
    return path[-1] not in data or data[path[-1]] != before


class Filled:
    """A tree as plain data, with ``${VARIABLE}`` replaced and paths made absolute.

    ``raw`` keeps what was written where a variable stood: its value may be secret and is never shown.
    """

    def __init__(self, tree: Node, environ: Mapping[str, str]) -> None:
        self.raw: dict[Path, str] = {}
        self.problems: list[Problem] = []
        self._environ = environ
        self.data: Any = self._plain(tree, ())

    def _plain(self, node: Node, path: Path) -> Any:
        match node.value:
            case dict():
                return {key: self._plain(child, (*path, key)) for key, child in node.value.items()}
            case list():
                return [self._plain(child, (*path, str(index))) for index, child in enumerate(node.value)]
            case str(text):
                value = self._expanded(text, node.where, path) if "$" in text else text
                if value and "path" in allowed.types_at(path):
                    return _absolute(value, node.where)
                return value
        return node.value

    def _expanded(self, text: str, where: Where, path: Path) -> str | None:
        missing: list[str] = []

        def value(match: re.Match[str]) -> str:
            if match[1] == "${":
                return "${"  # written $${ to mean itself
            name, closed = match[2], match[3]
            if not closed or not _NAME.fullmatch(name):
                shown = "…" if path[:1] == ("platforms",) else f"{name:.40}"  # a key that somebody put in braces
                self._report(path, where, f"${{{shown}{closed} is no variable; write ${{NAME}}, or $${{ for the signs")
            elif name not in self._environ:
                missing.append(name[:40])
            else:
                self.raw[path] = text
                return self._environ[name]
            return match[0]

        result = _VARIABLE.sub(value, text)
        if missing and "password" in allowed.types_at(path):
            return None  # a platform that is not used must not keep sayso from starting
        for name in missing:
            self._report(path, where, f"the environment variable {name} is not set")
        return result

    def _report(self, path: Path, where: Where, message: str) -> None:
        self.problems.append(Problem(where, ".".join(path), message))


def _absolute(text: str, where: Where) -> str:
    """A path in a file is relative to that file; one from the environment or a flag, to the current folder."""
    path = FilePath(text).expanduser() if text.startswith("~/") or text == "~" else FilePath(text)
    base = FilePath(where.name).parent if where.line else FilePath()
    return str((base / path).absolute())
