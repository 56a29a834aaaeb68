"""YAML text as a tree of plain values in which every node remembers the line it was written on.

The reader is narrower than YAML on purpose. Keys are always text and unique in their mapping; ``true`` and ``false``
are the only booleans (``no`` is Norwegian, ``on`` a word); there are no dates, no tags, and no anchors or aliases,
with which a small file can stand for a huge one. Size and depth are limited. It works on the parser's events, which
come one by one, so that a hostile file costs no more than its own length.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from config.errors import Problem, Where

MAX_BYTES = 1 << 20
MAX_DEPTH = 16
"""The settings are four deep."""
_BREAKS = re.compile("[\x85\u2028\u2029]")
"""Ends of lines for libyaml, and for no editor: what follows would be on a line that nobody finds."""
MAX_EVENTS = 50_000
"""About as many values; a map of a thousand places has a fifth of that."""

Leaf = str | int | float | bool | None


@dataclass(frozen=True, slots=True)
class Node:
    """A value and where it was written. ``value`` is a leaf, a list of nodes, or a mapping of nodes by key."""

    value: Leaf | list[Node] | dict[str, Node]
    where: Where


class SourceError(Exception):
    """The text is not what a configuration may be."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(str(problem))
        self.problem = problem


def read(path: Path) -> Node:
    """The tree of a file. Raises SourceError for everything that keeps it from being one, FileNotFoundError alone
    excepted: whether a file must exist is the caller's business. Nothing exists in what is no folder."""
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise
    except NotADirectoryError as error:
        raise FileNotFoundError(*error.args) from error
    except OSError as error:
        raise SourceError(Problem(Where(str(path)), "", f"cannot be read: {error.strerror or error}")) from error
    return parse(data, str(path))


def parse(data: bytes, name: str) -> Node:
    """The tree of a document; an empty one is an empty mapping. ``name`` is the file in messages."""
    if len(data) > MAX_BYTES:
        raise _error(name, 0, "is larger than 1 MiB; this is no configuration")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise _error(name, line, "is not UTF-8 text; save the file as UTF-8") from error
    root = _tree(_BREAKS.sub(" ", text), name)
    if root is None or root.value is None:
        return Node({}, Where(name, 1))
    if not isinstance(root.value, dict):
        raise SourceError(Problem(root.where, "", f"holds {_kind(root)} where sections are expected, like `audio:`"))
    return root


def parse_value(text: str, where: Where) -> Node:
    """The value of an environment variable or a flag: a scalar, or what begins with ``[``, ``{`` or a quote."""
    if text[:1] in {"[", "{", '"', "'"}:
        if len(text) > MAX_BYTES:
            raise _error(where.name, 0, "is longer than 1 MiB")
        root = _tree(text, where.name)
        return _moved(root, where) if root else Node(None, where)
    return Node(_scalar(text.strip(), plain=True), where)


def _moved(node: Node, where: Where) -> Node:
    match node.value:
        case dict():
            return Node({key: _moved(child, where) for key, child in node.value.items()}, where)
        case list():
            return Node([_moved(child, where) for child in node.value], where)
    return Node(node.value, where)


def _error(name: str, line: int, message: str) -> SourceError:
    return SourceError(Problem(Where(name, line), "", message))


def _kind(node: Node) -> str:
    return "a list" if isinstance(node.value, list) else f"the value {node.value!r:.60}"


def _tree(text: str, name: str) -> Node | None:
    events = _events(text, name)
    root = None
    for event in events:
        if isinstance(event, yaml.DocumentStartEvent):
            if root is not None:
                raise _error(name, _line(event), "a second document begins; keep all in one")
            root = _node(next(events), events, name, 0)
    return root


def _events(text: str, name: str) -> Iterator[yaml.Event]:
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        for count, event in enumerate(yaml.parse(text, Loader=loader)):
            if count > MAX_EVENTS:
                raise _error(name, _line(event), "has too many values; this is no configuration")
            yield event
    except yaml.MarkedYAMLError as error:
        raise _error(name, *_mistake(text, error)) from error
    except yaml.YAMLError as error:
        position = getattr(error, "position", None)
        line = text.count("\n", 0, position) + 1 if isinstance(position, int) else 0
        reason = str(getattr(error, "reason", error))
        raise _error(name, line, f"YAML cannot be read: {reason}") from error


def _mistake(text: str, error: yaml.MarkedYAMLError) -> tuple[int, str]:
    """Line and description. libyaml finds an unclosed bracket behind the end of the file; people look where it opens,
    or at what they wrote last."""
    lines = text.rstrip().splitlines()
    mark, message = error.problem_mark or error.context_mark, f"YAML cannot be read: {error.problem or 'syntax error'}"
    if error.context:
        message += f" ({error.context})"
    if error.context_mark and mark and mark.line >= len(lines):
        mark = error.context_mark
    number = min(mark.line, len(lines) - 1) if mark else -1
    written = lines[number] if 0 <= number < len(lines) else ""
    if "\t" in written[: len(written) - len(written.lstrip())]:
        message += "; indent with spaces, not tabs"
    if "${" in written:
        message += '; inside { } a variable needs quotes: "${NAME}"'
    return number + 1, message


def _line(event: yaml.Event) -> int:
    return event.start_mark.line + 1 if event.start_mark else 0


def _node(event: yaml.Event, events: Iterator[yaml.Event], name: str, depth: int) -> Node:
    where = Where(name, _line(event))
    if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None):
        raise SourceError(Problem(where, "", "anchors and aliases (& and *) are not read here; write the value again"))
    if getattr(event, "tag", None) not in {None, "!"}:
        raise SourceError(Problem(where, "", "tags (!) are not read here; write the plain value"))
    if depth > MAX_DEPTH:
        raise SourceError(Problem(where, "", f"is nested more than {MAX_DEPTH} deep"))
    if isinstance(event, yaml.SequenceStartEvent):
        items: list[Node] = []
        while not isinstance(event := next(events), yaml.SequenceEndEvent):
            items.append(_node(event, events, name, depth + 1))
        return Node(items, where)
    if isinstance(event, yaml.MappingStartEvent):
        return Node(_mapping(events, name, depth), where)
    assert isinstance(event, yaml.ScalarEvent)
    return Node(_scalar(event.value, plain=event.implicit[0]), where)


def _mapping(events: Iterator[yaml.Event], name: str, depth: int) -> dict[str, Node]:
    children: dict[str, Node] = {}
    while not isinstance(event := next(events), yaml.MappingEndEvent):
        line = _line(event)
        if not isinstance(event, yaml.ScalarEvent):
            raise _error(name, line, "a key must be a word, not a list, a mapping or an alias")
        key = event.value
        if key in children:
            message = f"{key!r} is given twice, first on line {children[key].where.line}"
            raise SourceError(Problem(Where(name, line), "", message))
        value = _node(next(events), events, name, depth + 1)
        # What is wrong with a mapping is reported at its key, which is where a person looks.
        children[key] = Node(value.value, Where(name, line)) if isinstance(value.value, dict) else value
    return children


# The scalars of YAML 1.2's core schema; PyYAML's own are those of 1.1, where `no` is false and 1:30 is ninety.
_WORDS: dict[str, Any] = {"": None, "~": None, "null": None, "Null": None, "NULL": None}
_WORDS |= {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}
_INTEGER = re.compile(r"[-+]?[0-9]{1,30}")
_PREFIXED = re.compile(r"0[xo][0-9a-fA-F]{1,30}")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_SPECIAL = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")


def _scalar(text: str, *, plain: bool) -> Leaf:
    """What an unquoted scalar means; a quoted one is always text."""
    if not plain:
        return text
    if text in _WORDS:
        value: Leaf = _WORDS[text]
        return value
    if _INTEGER.fullmatch(text):
        return int(text)
    if _PREFIXED.fullmatch(text):
        try:
            return int(text, 0)
        except ValueError:
            return text
    if _FLOAT.fullmatch(text):
        return float(text)
    if _SPECIAL.fullmatch(text):
        return float(text.replace(".", "", 1))
    return text
