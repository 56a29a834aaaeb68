"""Configuration: what a user edits, and the one place that reads it.

``config.load()`` gives the settings. The names below are imported when they are first used, so that a part which only
needs a folder's name, or a command that only prints its help, does not wait for pydantic.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from config.errors import ConfigError, Problem
    from config.folders import Paths, paths
    from config.loader import Examined, Explained, check, examine, explain, load, show
    from config.schema import Settings

_HOMES = {
    "ConfigError": "config.errors",
    "Examined": "config.loader",
    "Explained": "config.loader",
    "Paths": "config.folders",
    "Problem": "config.errors",
    "Settings": "config.schema",
    "check": "config.loader",
    "examine": "config.loader",
    "explain": "config.loader",
    "load": "config.loader",
    "paths": "config.folders",
    "show": "config.loader",
}

__all__ = [
    "ConfigError", "Examined", "Explained", "Paths", "Problem", "Settings", "check", "examine", "explain", "load",
    "paths", "show",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'config' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOMES[name]), name)
