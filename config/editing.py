"""One setting changed in the text of a YAML file: everything else, comments and order too, stays as somebody wrote it.

The text is changed where the parser says that the value stands. What came of it is read again as settings are read,
and has to differ in that one value; a file in which that cannot be done is left to whoever wrote it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import yaml

from config.source import Leaf, Node, SourceError, parse

Value = Leaf | Sequence[Leaf]
_WIDTH = 1 << 20


class NotEditable(Exception):
    """The text is written so that a program had better not change it; the message says why."""


def with_value(text: str, path: tuple[str, ...], value: Value) -> str:
    """The text in which the setting at ``path`` has this value. Raises :class:`NotEditable`."""
    wanted = _with(_plain_of(text), path, list(value) if isinstance(value, list | tuple) else value)
    return _checked(_Text(text).set(path, as_yaml(value)), wanted)


def without(text: str, path: tuple[str, ...]) -> str:
    """The text in which nothing is said of the setting at ``path``. Raises :class:`NotEditable`."""
    return _checked(_Text(text).remove(path), _without(_plain_of(text), path))


class _Text:
    """A text and where its parts stand; positions are characters from its beginning."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._newline = "\r\n" if "\r\n" in text else "\n"
        self._root: Any = yaml.compose(text, Loader=yaml.SafeLoader)

    def set(self, path: tuple[str, ...], value: str) -> str:
        """With this value, as YAML on one line."""
        mapping, left = self._deepest(path)
        if mapping is None:
            return self._appended(path, value)
        found = _entry(mapping, left[0])
        if found is None:
            return self._entered(mapping, left, value)
        key, node = found
        if len(left) == 1:
            return self._replaced(node.start_mark.index, self._end(node), value, after=key)
        return self._opened(key, node, left[1:], value)

    def remove(self, path: tuple[str, ...]) -> str:
        """Without the entry."""
        mapping, left = self._deepest(path)
        found = _entry(mapping, left[0]) if mapping is not None and len(left) == 1 else None
        if mapping is None or found is None:
            return self._text
        key, node = found
        text, start, end = self._text, key.start_mark.index, self._end(node)
        if not mapping.flow_style:
            start, end = text.rfind("\n", 0, start) + 1, self._line_end(end)
            return text[:start] + text[end:].removeprefix("\r").removeprefix("\n")
        number = mapping.value.index(found)
        if number + 1 < len(mapping.value):
            end = mapping.value[number + 1][0].start_mark.index
        elif number:
            start = self._end(mapping.value[number - 1][1])
        return text[:start] + text[end:]

    def _deepest(self, path: tuple[str, ...]) -> tuple[Any, tuple[str, ...]]:
        """The last mapping on the way that is there, and which keys are left from it on; None where there is none."""
        node, left = self._root, path
        if not isinstance(node, yaml.MappingNode):
            return None, left
        while len(left) > 1 and (found := _entry(node, left[0])) and isinstance(found[1], yaml.MappingNode):
            node, left = found[1], left[1:]
        return node, left

    def _appended(self, path: tuple[str, ...], value: str) -> str:
        """At the end of a text that says nothing yet."""
        if self._root is not None and self._root.start_mark.index != self._root.end_mark.index:
            raise NotEditable("it holds no sections")
        text = self._text
        gap = "" if not text or text.endswith("\n") else self._newline
        return f"{text}{gap}{self._nested(path, value, 0)}{self._newline}"

    def _entered(self, mapping: Any, left: tuple[str, ...], value: str) -> str:
        """One entry more, behind the others."""
        text = self._text
        if mapping.flow_style:
            at = self._end(mapping.value[-1][1]) if mapping.value else mapping.start_mark.index + 1
            entry = _flow(left, value)
            return f"{text[:at]}{', ' if mapping.value else ''}{entry}{text[at:]}"
        at = self._line_end(self._end(mapping.value[-1][1]))
        return f"{text[:at]}{self._newline}{self._nested(left, value, mapping.start_mark.column)}{text[at:]}"

    def _opened(self, key: Any, node: Any, left: tuple[str, ...], value: str) -> str:
        """A section that was there without anything in it gets something."""
        if not isinstance(node, yaml.ScalarNode) or node.tag != "tag:yaml.org,2002:null":
            raise NotEditable(f"line {key.start_mark.line + 1} holds a value where a section belongs")
        text, start, end = self._text, node.start_mark.index, node.end_mark.index
        if "{" in text[text.rfind("\n", 0, key.start_mark.index) + 1 : key.start_mark.index]:
            return self._replaced(start, end, f"{{{_flow(left, value)}}}", after=key)
        text = text[:start] + text[end:]
        at = self._line_end(start, text)
        return f"{text[:at]}{self._newline}{self._nested(left, value, key.start_mark.column + 2)}{text[at:]}"

    def _replaced(self, start: int, end: int, value: str, *, after: Any) -> str:
        text = self._text
        if start == end:  # there was nothing: the value goes behind the colon
            start = end = text.index(":", after.end_mark.index) + 1
        elif text.count("\n", after.end_mark.index, start):  # it stood in lines of its own
            start = text.index(":", after.end_mark.index) + 1
            return f"{text[:start]} {value}{text[start : self._line_end(start)]}{text[end:]}"
        gap = "" if text[start - 1 : start].isspace() else " "
        return f"{text[:start]}{gap}{value}{text[end:]}"

    def _nested(self, path: tuple[str, ...], value: str, column: int) -> str:
        """Sections in one another and the value, a line each."""
        lines = [f"{' ' * (column + 2 * depth)}{as_yaml(key)}:" for depth, key in enumerate(path)]
        return f"{self._newline.join(lines)} {value}"

    def _end(self, node: Any) -> int:
        """Where it ends; the parser counts what follows a block as a part of it."""
        while isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
            node = node.value[-1][1] if isinstance(node, yaml.MappingNode) else node.value[-1]
        end: int = node.end_mark.index
        return len(self._text[:end].rstrip()) if getattr(node, "style", None) in ("|", ">") else end

    def _line_end(self, at: int, text: str | None = None) -> int:
        """Where the line ends, without its line break."""
        text = self._text if text is None else text
        end = text.find("\n", at)
        end = len(text) if end < 0 else end
        return end - 1 if text[end - 1 : end] == "\r" and end > at else end


def _entry(mapping: Any, key: str) -> tuple[Any, Any] | None:
    return next((entry for entry in mapping.value if entry[0].value == key), None)


def _flow(path: tuple[str, ...], value: str) -> str:
    """``a: {b: value}``."""
    for key in reversed(path[1:]):
        value = f"{{{as_yaml(key)}: {value}}}"
    return f"{as_yaml(path[0])}: {value}"


def as_yaml(value: Value) -> str:
    """A value or a key on one line, as settings are read: text is quoted where something else would be read."""
    plain = list(value) if isinstance(value, list | tuple) else value
    for quoted in (None, '"'):
        text: str = yaml.safe_dump(
            plain, default_flow_style=True, default_style=quoted, allow_unicode=True, width=_WIDTH
        )
        text = text.removesuffix("\n").removesuffix("\n...")
        if "\n" not in text and _plain_of(f"x: {text}\n") == {"x": plain}:
            return text
    raise NotEditable("this value cannot be written on one line")


def _plain_of(text: str) -> dict[str, Any]:
    """What a text says, read as settings are. Raises :class:`NotEditable`."""
    try:
        plain = _plain(parse(text.encode(), "text"))
    except (SourceError, UnicodeEncodeError) as error:
        raise NotEditable(str(getattr(error, "problem", error)).removeprefix("text:")) from error
    assert isinstance(plain, dict)
    return plain


def _plain(node: Node) -> Any:
    match node.value:
        case dict():
            return {key: _plain(child) for key, child in node.value.items()}
        case list():
            return [_plain(child) for child in node.value]
    return node.value


def _checked(text: str, wanted: dict[str, Any]) -> str:
    if _meant(_plain_of(text)) != _meant(wanted):
        raise NotEditable("its lines are arranged in a way that sayso does not know")
    return text


def _meant(plain: Any, path: tuple[str, ...] = ()) -> list[tuple[tuple[str, ...], str]]:
    """Its values one by one; sections that hold nothing do not count, and 1 is not true."""
    if isinstance(plain, dict):
        return sorted(found for key, child in plain.items() for found in _meant(child, (*path, key)))
    return [(path, repr(plain))] if plain is not None or len(path) > 1 else []


def _with(plain: dict[str, Any], path: tuple[str, ...], value: Any) -> dict[str, Any]:
    here = plain.get(path[0])
    below = _with(here if isinstance(here, dict) else {}, path[1:], value) if len(path) > 1 else value
    return plain | {path[0]: below}


def _without(plain: dict[str, Any], path: tuple[str, ...]) -> dict[str, Any]:
    here = plain.get(path[0])
    if len(path) > 1:
        return plain | {path[0]: _without(here, path[1:])} if isinstance(here, dict) else plain
    return {key: child for key, child in plain.items() if key != path[0]}
