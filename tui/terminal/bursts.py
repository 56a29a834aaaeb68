"""Lines that come all at once, from a terminal that does not mark what is pasted: they are one submission.

A person presses enter and then goes on: text right behind an enter in the same read was pasted, or has waited together
with the enter on a slow line. Sent one after the other, each of these requests would replace the one before it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from textual import events
from textual.keys import Keys
from textual.message import Message

_ENTER: Final = frozenset({"enter", "ctrl+j"})
"""What ends a line, as a terminal's parser names it."""


class Burst(Message):
    """Several lines that were typed or pasted at once, in a terminal that does not say which."""

    def __init__(self, keys: Sequence[events.Key], text: str) -> None:
        super().__init__()
        self.keys = tuple(keys)
        self.text = text


class Bursts:
    """Takes bursts out of what the parser makes of each read. One goes on as long as more text comes without a pause.
    For one reading thread."""

    def __init__(self) -> None:
        self._keys: list[events.Key] = []

    @property
    def held(self) -> bool:
        """One waits for its end."""
        return bool(self._keys)

    def taken(self, messages: Iterable[Message]) -> Iterator[Message]:
        """What is to be queued of this read. Nothing is held but a burst at its end."""
        for message in messages:
            if isinstance(message, events.Key) and message.key == Keys.Ignore:
                yield message
            elif isinstance(message, events.Key) and (message.key in _ENTER or message.is_printable):
                self._keys.append(message)
            else:
                yield from self.overdue()
                yield message
        if not _is_burst(self._keys):
            yield from self.overdue()

    def overdue(self) -> Iterator[Message]:
        """Nothing more has come for a while, or something else."""
        keys, self._keys = self._keys, []
        if _is_burst(keys):
            yield Burst(keys, "".join("\n" if key.key in _ENTER else key.character or "" for key in keys))
        else:
            yield from keys


def _is_burst(keys: list[events.Key]) -> bool:
    """Whether text stands behind a line that is not empty."""
    _, ended, behind = "".join("\n" if key.key in _ENTER else "x" for key in keys).lstrip("\n").partition("\n")
    return bool(ended and behind.strip())
