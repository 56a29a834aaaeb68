"""From command-line options to settings."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from config.schema import Settings

_SHORTCUTS = {"scene": "robot.scene", "speed": "robot.speed", "model": "asr.model"}


def overrides(arguments: Namespace) -> list[str]:
    """``section.key=value`` for every option that stands for a setting; later ones win."""
    given = list(arguments.set or [])
    for option, key in _SHORTCUTS.items():
        if (value := getattr(arguments, option)) is not None:
            given.append(f"{key}={value}")
    return given


def load_settings(arguments: Namespace) -> Settings:
    """The settings for this command. Raises ``ConfigError``."""
    from config import load

    return load(files=arguments.config or (), overrides=overrides(arguments))
