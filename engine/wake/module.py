"""What a kind of wake module is: how its frames look, what they mean, and what it wants to be told.

A module is known by its bytes alone. Nothing here reads or writes a port, and no bytes make any of it raise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from config.schema import WakeProtocol
from engine.framing import Format


@dataclass(frozen=True, slots=True)
class Called:
    """Somebody said the wake word."""

    phrase: str = ""  # which one, if the module tells
    angle_deg: float | None = None  # where the speaker stands: degrees around the module, 0 ≤ angle < 360
    reply: bytes = b""  # what the module waits for


@dataclass(frozen=True, slots=True)
class Told:
    """A frame that wakes nobody: a greeting, another volume, a command word of the module's own."""

    what: str
    reply: bytes = b""


Frame = Called | Told


class Module(Format[Frame], Protocol):
    """One kind of module."""

    @property
    def name(self) -> WakeProtocol:
        """What settings call it."""
        ...

    @property
    def greeting(self) -> bytes:
        """What the host says first, to a port of which somebody has said that this module hangs on it."""
        ...

    def play(self, phrase: int) -> bytes | None:
        """What makes the module say one of its phrases; None when it cannot."""
        ...
