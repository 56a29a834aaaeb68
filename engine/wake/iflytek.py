"""The microphone ring, and the six-microphone array, of iFlytek: they tell from which direction they were called.

A frame is ``A5 01 TYPE LEN LEN ID ID data CHECK`` with 16-bit numbers, low byte first, and a check that makes the sum
of all bytes 0 (mod 256). The module shakes hands and waits for an acknowledgement, of that and of each message, under
the same number. Messages are JSON, packed with gzip by some; the wake is an ``aiui_event`` with ``eventType`` 4, whose
``info`` (JSON once more, in a string) has the angle. It plays no phrases. 115200 baud.
"""

from __future__ import annotations

import zlib
from typing import Any, Final

import msgspec

from config.schema import WakeProtocol
from engine.wake.module import Called, Frame, Told

HEADER: Final = b"\xa5\x01"
HANDSHAKE: Final = 0x01
MESSAGE: Final = 0x04
COMMAND: Final = 0x05
ACK: Final = 0xFF
CONFIRM: Final = b"\xa5\x00\x00\x00"
"""The data of a handshake and of an acknowledgement."""
HEAD: Final = 7
MAX_DATA: Final = 4096
"""Longest data that are read, bytes: a wake has a few hundred. Results of the maker's own cloud can be longer."""
MAX_JSON: Final = 65536
"""Longest message when unpacked, bytes."""
WOKEN: Final = 4
"""``eventType`` of a wake."""
MAX_PHRASE: Final = 60


def frame(kind: int, number: int, data: bytes) -> bytes:
    """The bytes of a frame, in either direction; ``number`` is that of the message, from 0 to 65535."""
    body = HEADER + bytes((kind,)) + len(data).to_bytes(2, "little") + number.to_bytes(2, "little") + data
    return body + bytes((-sum(body) & 0xFF,))


class IflytekRing:
    """The module."""

    name: WakeProtocol = "iflytek"
    header = HEADER
    head = HEAD
    longest = HEAD + MAX_DATA + 1
    greeting = frame(HANDSHAKE, 0, CONFIRM)

    def length(self, head: bytes) -> int | None:
        kind, data = head[2], int.from_bytes(head[3:5], "little")
        if kind in (HANDSHAKE, ACK):
            return HEAD + data + 1 if data == len(CONFIRM) else None
        return HEAD + data + 1 if kind in (MESSAGE, COMMAND) and data <= MAX_DATA else None

    def read(self, frame: bytes) -> Frame | None:
        if sum(frame) & 0xFF:
            return None
        kind, data = frame[2], frame[HEAD:-1]
        if kind in (HANDSHAKE, ACK):
            if data != CONFIRM:
                return None
            return Told("acknowledged") if kind == ACK else Told("handshake", _ack(frame))
        message = _json(data)  # what is none was no frame: one byte of check is soon guessed by garbage
        if message is None:
            return None
        return _meaning(message, _ack(frame) if kind == MESSAGE else b"")

    def play(self, phrase: int) -> bytes | None:
        return None


def _ack(received: bytes) -> bytes:
    return frame(ACK, int.from_bytes(received[5:7], "little"), CONFIRM)


def _json(data: bytes) -> dict[str, Any] | None:
    """The JSON object in these bytes; None when there is none."""
    try:
        if data[:2] == b"\x1f\x8b":
            unpacking = zlib.decompressobj(wbits=31)
            data = unpacking.decompress(data, MAX_JSON)
            if not unpacking.eof:
                return None
        found = msgspec.json.decode(data)
    except (zlib.error, msgspec.DecodeError, UnicodeError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def _meaning(message: dict[str, Any], reply: bytes) -> Frame:
    kind, content = message.get("type"), message.get("content")
    if kind != "aiui_event" or not isinstance(content, dict):
        return Told(f"message {_words(kind)}", reply)
    event = content.get("eventType")
    if event != WOKEN or isinstance(event, bool):
        return Told(f"event {_words(event)}", reply)
    info = content.get("info")
    if isinstance(info, str):
        info = _json(info.encode())
    if isinstance(info, dict) and isinstance(info.get("ivw"), dict):
        info = info["ivw"]
    if not isinstance(info, dict):
        return Called(reply=reply)
    keyword = info.get("keyword")
    phrase = keyword[:MAX_PHRASE] if isinstance(keyword, str) else ""
    return Called(phrase, _angle(info.get("angle")), reply)


def _angle(value: object) -> float | None:
    """A direction that can be one, degrees from 0 to 360."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 360:
        return None
    return float(value) % 360


def _words(value: object) -> str:
    """What a message calls something, for people."""
    if isinstance(value, str):
        return value[:MAX_PHRASE]
    return str(value) if isinstance(value, int) and abs(value) < 1e6 else "of an unknown kind"
