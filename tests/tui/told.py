"""What the engine behind a console in another process is told, a line each."""

from __future__ import annotations

import os
import select
from typing import Final

PATIENCE_S: Final = 30.0


class Told:
    """A console in another process."""

    told: int
    """The end of a pipe."""

    def next_command(self) -> str:
        """The next thing told that is no frame."""
        while (line := self.next_line()) == "frame":
            pass
        return line

    def next_line(self) -> str:
        """The next thing told."""
        assert select.select([self.told], [], [], PATIENCE_S)[0], "The engine was told nothing."
        line = b""
        while not line.endswith(b"\n"):
            line += os.read(self.told, 1)
        return line.decode().strip()
