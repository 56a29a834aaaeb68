"""A terminal driver that lets a key act the moment it arrives.

Textual's drivers read the keyboard in a thread of its own and queue each key for the user interface. When the link to
the terminal stalls, the interface waits for it, and so would a key in its queue. Stopping a robot cannot wait: this
driver shows each key to a callback in the reading thread, before it is queued.
"""

from __future__ import annotations

from collections.abc import Callable

from textual import events
from textual.driver import Driver
from textual.message import Message


def listening_driver(base: type[Driver], on_key: Callable[[str], None]) -> type[Driver]:
    """A driver like ``base`` that calls ``on_key`` with the name of each key, in the reading thread."""

    class ListeningDriver(base):  # type: ignore[valid-type,misc]
        def process_message(self, message: Message) -> None:
            if isinstance(message, events.Key):
                on_key(message.key)
            super().process_message(message)

    return ListeningDriver
