"""What the schema allows at a key, in words, and which key a wrong one was probably meant to be.

Reads the JSON schema that pydantic derives from :mod:`config.schema`, so there is no second list of settings to keep
in step. A *path* is the tuple of keys from the top: ``("endpoint", "silence_s")``.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any

from config.nearest import nearest
from config.schema import Settings

Path = tuple[str, ...]
Shape = dict[str, Any]


@functools.cache
def _schema() -> Shape:
    return Settings.model_json_schema()


def _resolved(shape: Shape) -> Shape:
    reference = shape.get("$ref")
    if reference is None:
        return shape
    target: Shape = _schema()["$defs"][reference.rpartition("/")[2]]
    return target | {key: value for key, value in shape.items() if key != "$ref"}


def shape_at(path: Path) -> Shape | None:
    """The JSON schema of a key, or None where the schema knows no such key."""
    shape = _schema()
    for key in path:
        shape = _resolved(shape)
        if key in shape.get("properties", {}):
            shape = shape["properties"][key]
        elif isinstance(shape.get("additionalProperties"), dict):
            shape = shape["additionalProperties"]
        elif isinstance(shape.get("items"), dict) and key.isdecimal():
            shape = shape["items"]
        else:
            return None
    return _resolved(shape)


def keys_at(path: Path) -> tuple[str, ...]:
    """The keys that a section may have; empty for free-form mappings (places, platforms) and for values."""
    return tuple((shape_at(path) or {}).get("properties", ()))


def required_at(path: Path) -> frozenset[str]:
    """The keys that a section must have."""
    return frozenset((shape_at(path) or {}).get("required", ()))


def is_open(path: Path) -> bool:
    """Whether the user names the entries of this mapping: places, platforms."""
    return isinstance((shape_at(path) or {}).get("additionalProperties"), dict)


def types_at(path: Path) -> frozenset[str]:
    """JSON types and formats that a key takes: string, number, boolean, null, path, password, …"""
    shape = shape_at(path) or {}
    found = set()
    for option in map(_resolved, shape.get("anyOf", [shape])):
        found |= {option.get("type", ""), option.get("format", "")}
        if "enum" in option or "const" in option:
            found.add("enum")
    return frozenset(found - {""})


@functools.cache
def settings() -> tuple[str, ...]:
    """Dotted names of all settings whose names are fixed."""

    def leaves(path: Path) -> Iterator[str]:
        for key in keys_at(path):
            below = (*path, key)
            if keys_at(below):
                yield from leaves(below)
            elif not is_open(below):
                yield ".".join(below)

    return tuple(leaves(()))


def describe(path: Path) -> str:
    """What may stand at a key, for the sentence "allowed: …"."""
    shape = shape_at(path)
    if shape is None:
        return ""
    words = _words(shape)
    return f"{words} ({shape['description'].rstrip('.')})" if shape.get("description") and words else words


def _words(shape: Shape) -> str:
    shape = _resolved(shape)
    if "anyOf" in shape:
        return " or ".join(_words(option) for option in shape["anyOf"])
    if "enum" in shape or "const" in shape:
        return " | ".join(map(str, shape.get("enum", [shape.get("const")])))
    match shape.get("type"):
        case "boolean":
            return "true | false"
        case "integer":
            return "a whole number" + _range(shape)
        case "number":
            return "a number" + _range(shape)
        case "string":
            return "a path" if shape.get("format") == "path" else "text"
        case "null":
            return "null"
        case "array":
            return f"a list of {_words(shape['items'])}" if "items" in shape else "a list"
        case "object" if "properties" in shape:
            return "a section with " + ", ".join(shape["properties"])
        case "object":
            return "a section"
    return ""


def _range(shape: Shape) -> str:
    low, above = shape.get("minimum"), shape.get("exclusiveMinimum")
    high, below = shape.get("maximum"), shape.get("exclusiveMaximum")
    parts = []
    if above is not None and (low is None or above >= low):
        parts.append(f"above {above:g}")
    elif low is not None:
        parts.append(f"from {low:g}")
    if below is not None and (high is None or below <= high):
        parts.append(f"below {below:g}")
    elif high is not None:
        parts.append(f"up to {high:g}")
    return (" " + " ".join(parts)) if parts else ""


def nearest_setting(path: Path) -> Path:
    """The setting that an unknown path was probably meant to be: a sibling, or a namesake in another section."""
    for depth, key in enumerate(path):
        if shape_at(path[: depth + 1]) is None:
            sibling = nearest(key, keys_at(path[:depth]))
            if sibling and shape_at(fixed := (*path[:depth], sibling, *path[depth + 1 :])) is not None:
                return fixed
            break
    dotted = nearest(".".join(path), settings(), 0.75)
    if not dotted:
        last = path[-1].casefold()
        namesakes = [name for name in settings() if last in {name, name.rpartition(".")[2]}]
        dotted = namesakes[0] if len(namesakes) == 1 else ""
    return tuple(dotted.split(".")) if dotted else ()
