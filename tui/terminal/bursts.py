"""Lines that come all at once, from a terminal that does not mark what is pasted: they are one submission.

A person presses enter and then goes on: text right behind an enter was pasted, or has waited together with the enter on
a slow line. Sent one after the other, each of these requests would replace the one before it. A paste may come in one
read or in many, and it may hold lines without any text: an enter that came faster than anybody presses it is held for a
moment, in case more comes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final

from textual import events
from textual.keys import Keys
from textual.message import Message

_ENTER: Final = frozenset({"enter", "ctrl+j"})
"""What ends a line, as a terminal's parser names it."""


FAST_S: Final = 0.012
"""Nobody presses enter so soon after another key."""


class Burst(Message):
    """Several lines that were typed or pasted at once, in a terminal that does not say which."""

    def __init__(self, keys: Sequence[events.Key], text: str) -> None:
        super().__init__()
        self.keys = tuple(keys)
        self.text = text


class Bursts:
    """Takes bursts out of what the parser makes of each read. One goes on as long as more text comes without a pause.
    For one reading thread; ``clock`` is monotonic seconds."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._keys: list[events.Key] = []
        self._read_at = -math.inf  # when text was read last
        self._behind_text = False  # text that is queued already stands before the first key

    @property
    def held(self) -> bool:
        """One waits for its end."""
        return bool(self._keys)

    def taken(self, messages: Iterable[Message]) -> Iterator[Message]:
        """What is to be queued of this read. Nothing is held at its end but a burst, or what may become one."""
        now = self._clock()
        fast = now - self._read_at < FAST_S
        for message in messages:
            if isinstance(message, events.Key) and message.key == Keys.Ignore:
                yield message
            elif isinstance(message, events.Key) and (message.key in _ENTER or message.is_printable):
                if not self._keys:
                    self._behind_text = fast
                self._keys.append(message)
                self._read_at, fast = now, True
            else:
                yield from self.overdue()
                yield message
                self._read_at, fast = -math.inf, False
        if not self._may_go_on():
            yield from self.overdue()

    def overdue(self) -> Iterator[Message]:
        """Nothing more has come for a while, or something else."""
        keys, self._keys = self._keys, []
        if _is_burst(keys, behind_text=self._behind_text):
            yield Burst(keys, "".join("\n" if key.key in _ENTER else key.character or "" for key in keys))
        else:
            yield from keys

    def _may_go_on(self) -> bool:
        """Whether more would belong to it: to a burst, and to an enter right behind text."""
        ended = bool(self._keys) and self._keys[-1].key in _ENTER and (self._behind_text or len(self._keys) > 1)
        return ended or _is_burst(self._keys, behind_text=self._behind_text)


def _is_burst(keys: list[events.Key], *, behind_text: bool) -> bool:
    """Whether text stands behind a line that is not empty; ``behind_text``: the first key is not at the beginning of
    one."""
    text = "".join("\n" if key.key in _ENTER else "x" for key in keys)
    _, ended, behind = (text if behind_text else text.lstrip("\n")).partition("\n")
    return bool(ended and behind.strip())
