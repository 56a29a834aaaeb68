"""The voice interaction module with a CSK4002: six letters a frame, no checksum, 115200 baud.

``$B000#`` is the wake; ``$Bnnn#`` with any other number is a command word of the module's own, and ``$Annn#``, which
the host sends, makes it say phrase nnn.
"""

from __future__ import annotations

from typing import Final

from config.schema import WakeProtocol
from engine.wake.module import Called, Frame, Told

LENGTH: Final = 6
WAKE: Final = b"$B000#"
_DIGITS: Final = frozenset(b"0123456789")


class Csk4002:
    """The module."""

    name: WakeProtocol = "csk4002"
    header = b"$"
    head = LENGTH
    longest = LENGTH
    greeting = b""

    def length(self, head: bytes) -> int | None:
        return LENGTH if head[1] in b"AB" and head[-1:] == b"#" and _DIGITS.issuperset(head[2:5]) else None

    def read(self, frame: bytes) -> Frame | None:
        if frame == WAKE:
            return Called()
        number = int(frame[2:5])
        return Told(f"command word {number}" if frame[1:2] == b"B" else f"phrase {number}")

    def play(self, phrase: int) -> bytes | None:
        return f"$A{phrase:03d}#".encode() if 0 <= phrase <= 999 else None
