"""Frames out of a stream of bytes: split anywhere, several at once, with garbage before, between and inside them.

Whatever looks like a beginning is followed up until as many bytes are there as it promises, and the first of them that
turns out to be a frame is one. So a beginning that was cut off, or that lies about its length, never keeps the frame
behind it waiting: that one is found with its last byte, as if nothing had been before it. Nothing depends on where the
stream was cut, or on time.
"""

from __future__ import annotations

from heapq import heappop, heappush
from typing import Generic, Protocol, TypeVar

Frame_co = TypeVar("Frame_co", covariant=True)
Frame = TypeVar("Frame")


class Format(Protocol[Frame_co]):
    """How frames look, and what they mean. It keeps nothing between two calls, and no bytes make it raise."""

    @property
    def header(self) -> bytes:
        """What every frame begins with."""
        ...

    @property
    def head(self) -> int:
        """Bytes after which the length of a frame is known, the header among them."""
        ...

    @property
    def longest(self) -> int:
        """Length of the longest frame, bytes."""
        ...

    def length(self, head: bytes) -> int | None:
        """The length of the frame that begins so, bytes; None when none does."""
        ...

    def read(self, frame: bytes) -> Frame_co | None:
        """What these bytes mean; None when they are no frame after all."""
        ...


class Framer(Generic[Frame]):
    """Finds the frames of one format. Holds as many bytes as its longest frame has, and one piece more."""

    def __init__(self, format: Format[Frame]) -> None:
        self.format = format
        self._bytes = bytearray()
        self._first = 0  # where in the stream they begin
        self._looked = 0  # up to where in the stream beginnings have been looked for
        self._begun: list[tuple[int, int]] = []  # a heap: where frames would end and begin, in the stream

    def push(self, data: bytes) -> list[Frame]:
        """The frames that end within ``data``, in order."""
        self._bytes += data
        self._look()
        found: list[Frame] = []
        there = self._first + len(self._bytes)
        while self._begun and self._begun[0][0] <= there:
            end, start = heappop(self._begun)
            if start < self._first:  # a frame was found that it overlaps
                continue
            frame = self.format.read(bytes(self._bytes[start - self._first : end - self._first]))
            if frame is not None:
                found.append(frame)
                self._drop(end)
        self._drop(max(self._first, there - self.format.longest))  # what began before that has ended by now
        return found

    def _look(self) -> None:
        """Note every beginning of which enough is there to know where it would end."""
        header, head = self.format.header, self.format.head
        at = max(self._looked - self._first, 0)
        while at + head <= len(self._bytes):
            at = self._bytes.find(header, at)
            if at < 0:  # its first bytes may be there already
                at = len(self._bytes) - len(header) + 1
                break
            if at + head > len(self._bytes):
                break
            length = self.format.length(bytes(self._bytes[at : at + head]))
            if length is not None:
                heappush(self._begun, (self._first + at + length, self._first + at))
            at += 1
        self._looked = max(self._looked, self._first + at)

    def _drop(self, end: int) -> None:
        del self._bytes[: end - self._first]
        self._first = end
