"""The AI voice module (SU-03T, CI1302 and their kin), as it is sold with many small robots.

Frames have five bytes, ``AA 55 what number FB``, and no checksum. Exactly one of them is the wake, ``AA 55 03 00 FB``;
its neighbours mean that the module greets, changes its volume or goes to sleep. The host makes it say a phrase with
``AA 55 FF number FB``. 115200 baud.

A bilingual firmware uses the same frames otherwise: 1…3 is a wake in Chinese, 4 and above one in English. Nothing in
its frames tells it apart, so it has a name of its own in the settings and is never guessed.
"""

from __future__ import annotations

from typing import Final

from config.schema import WakeProtocol
from engine.wake.module import Called, Frame, Told

HEADER: Final = b"\xaa\x55"
TAIL: Final = 0xFB
LENGTH: Final = 5
WAKE: Final = (0x03, 0x00)
SLEEP: Final = (0x02, 0x6F)
COMMAND_WORD: Final = 0x00
PHRASE: Final = 0xFF
LAST_CHINESE: Final = 3
_WHAT: Final = {0x01: "welcome", 0x02: "sleep", 0x04: "louder", 0x05: "quieter"}


def frame(what: int, number: int) -> bytes:
    """The bytes of a frame, in either direction."""
    return bytes((*HEADER, what, number, TAIL))


class AiVoice:
    """The module with its usual firmware, or with the bilingual one."""

    header = HEADER
    head = LENGTH
    longest = LENGTH
    greeting = b""

    def __init__(self, *, bilingual: bool = False) -> None:
        self.name: WakeProtocol = "ai_voice_bilingual" if bilingual else "ai_voice"
        self._bilingual = bilingual

    def length(self, head: bytes) -> int | None:
        return LENGTH if head[-1] == TAIL else None

    def read(self, frame: bytes) -> Frame | None:
        what, number = frame[2], frame[3]
        if what == COMMAND_WORD:
            return Told(f"command word {number}")
        if what == PHRASE:
            return Told(f"phrase {number}")
        if self._bilingual and (what, number) != SLEEP:
            return Called("Chinese wake word" if what <= LAST_CHINESE else "English wake word")
        if (what, number) == WAKE:
            return Called()
        return Told(_WHAT.get(what, f"frame {what:02X} {number:02X}"))

    def play(self, phrase: int) -> bytes | None:
        return frame(PHRASE, phrase) if 0 <= phrase <= 0xFF else None
