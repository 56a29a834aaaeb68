"""From command-line options to settings."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

from engine.errors import StorageError

if TYPE_CHECKING:
    from config.schema import Settings

_SHORTCUTS = {"scene": "robot.scene", "speed": "robot.speed", "model": "asr.model", "theme": "console.theme"}


def overrides(arguments: Namespace) -> list[str]:
    """``section.key=value`` for every option that stands for a setting; later ones win."""
    given = list(arguments.set or [])
    for option, key in _SHORTCUTS.items():
        if (value := getattr(arguments, option, None)) is not None:
            given.append(f"{key}={value}")
    return given


def make_state_folder() -> None:
    """Make the state folder, for this user alone. One that cannot be written is told where something is; raises
    ``StorageError`` for one that is not this user's."""
    from config.folders import paths
    from config.private import NotPrivate, private_folder

    ours = {"logs", "launch", "mic.sock", "mic.lock", "requests", "panes.json", "toured", "saved", "estop"}
    try:
        private_folder(paths().state, ours)
    except NotPrivate as error:
        raise StorageError(f"The state folder {error.filename} cannot be used: {error.strerror}.") from error
    except OSError:
        pass


def load_settings(arguments: Namespace) -> Settings:
    """The settings for this command. Raises ``ConfigError``."""
    from config import load

    return load(files=arguments.config or (), overrides=overrides(arguments))
