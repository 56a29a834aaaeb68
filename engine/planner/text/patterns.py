"""Patterns as data files write them (``assets/refusals``, ``assets/rewordings``), so that people can read them.

A line break is nothing, a bracket only groups, and ``<part>`` stands for a pattern that has a name of its own, or for
any one of several words.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Final

_PART: Final = re.compile(r"(?<!\?P)<([a-z_]+)>")
"""And no group, which is ``(?P<name>…)``."""
_BRACKET: Final = re.compile(r"(?<!\\)\((?!\?)")
_NONE: Final[Mapping[str, str]] = MappingProxyType({})


def written_out(pattern: str, parts: Mapping[str, str | Sequence[str]], expressions: Mapping[str, str] = _NONE) -> str:
    """``pattern`` as a regular expression. ``expressions`` are parts that are one already; of the words of a part, the
    longest are tried first. Raises ``KeyError`` for a part that nobody knows."""

    def named(found: re.Match[str]) -> str:
        if (expression := expressions.get(found[1])) is not None:
            return f"(?:{expression})"
        part = parts[found[1]]
        words = (part,) if isinstance(part, str) else sorted(part, key=len, reverse=True)
        return f"(?:{'|'.join(written_out(word, parts, expressions) for word in words)})"

    return _PART.sub(named, _BRACKET.sub("(?:", pattern.replace("\n", "")))
