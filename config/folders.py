"""Where sayso keeps what belongs to this user: settings, models, logs."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

FILES = ("config.yaml", "robot.yaml", "map.yaml", "people.yaml", "skills.yaml", "platforms.yaml", "profiles.yaml")
"""Files of the configuration folder, in reading order; all are optional and a later one wins."""

RESERVED = ("SAYSO_CONFIG_DIR", "SAYSO_CACHE_DIR", "SAYSO_STATE_DIR")
"""Environment variables that move the folders; they are no settings."""


@dataclass(frozen=True, slots=True)
class Paths:
    """The user's folders. None of them has to exist."""

    config: Path
    cache: Path
    state: Path

    @property
    def models(self) -> Path:
        """Model files, unless the setting ``models.folder`` says otherwise."""
        return self.cache / "models"

    @property
    def launch(self) -> Path:
        """Pictures that the console begins with."""
        return self.state / "launch"

    @property
    def robots(self) -> Path:
        """Descriptions of robots that this user wrote, or that were calibrated."""
        return self.config / "robots"

    @property
    def places(self) -> Path:
        """Places that the robot was told to remember, by house."""
        return self.config / "places"

    @property
    def people(self) -> Path:
        """People who told the robot their names, by house."""
        return self.config / "people"

    @property
    def words(self) -> Path:
        """Heads of wake words that the user trained."""
        return self.config / "wake"

    @property
    def logs(self) -> Path:
        """Session logs."""
        return self.state / "logs"

    @property
    def door(self) -> Path:
        """The socket at which a running sayso takes the sound of ``sayso mic``."""
        return self.state / "mic.sock"

    @property
    def estop(self) -> Path:
        """There while the emergency stop is pressed."""
        return self.state / "estop"

    @property
    def requests(self) -> Path:
        """What was typed in earlier sessions."""
        return self.state / "requests"

    @property
    def panes(self) -> Path:
        """How the panes of the console share the room."""
        return self.state / "panes.json"

    @property
    def toured(self) -> Path:
        """There once somebody has asked for something in the console, and needs no tour any more."""
        return self.state / "toured"

    @property
    def files(self) -> tuple[Path, ...]:
        """The configuration files that are read if they exist, in order."""
        return tuple(self.config / name for name in FILES)


def paths(environ: Mapping[str, str] | None = None) -> Paths:
    """The platform's own places, or what SAYSO_CONFIG_DIR, SAYSO_CACHE_DIR and SAYSO_STATE_DIR say instead."""
    import platformdirs

    variables = os.environ if environ is None else environ

    def folder(variable: str, usual: Path) -> Path:
        return Path(variables[variable]).expanduser() if variables.get(variable) else usual

    return Paths(
        config=folder("SAYSO_CONFIG_DIR", platformdirs.user_config_path("sayso", appauthor=False)),
        cache=folder("SAYSO_CACHE_DIR", platformdirs.user_cache_path("sayso", appauthor=False)),
        state=folder("SAYSO_STATE_DIR", platformdirs.user_state_path("sayso", appauthor=False)),
    )
