"""The requests that wait: dropped, moved, and taken back into the line to be changed.

One that is taken back is dropped first, and comes into the line once the engine says so: in that moment it may have
begun. What is made of it waits again, in its old place, and interrupts nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from engine import events as ev
from engine.commands import Drop, Move, Say
from tui.words import strings
from tui.words.hints import hint_line

if TYPE_CHECKING:
    from tui.rooms.keeping import Keeping
    from tui.shown.facts import Waiting
    from tui.stage import Stage


class Queueing:
    """In the UI thread."""

    def __init__(self, stage: Stage, keeping: Keeping) -> None:
        self._stage = stage
        self._keeping = keeping
        self._wanted: Waiting | None = None  # it is to be taken back, and nobody has said that it is
        self._behind: str | None = None  # the request before which it stood
        self._changing = False  # it is in the line
        self._emptied = False  # nothing is in the line any more
        self._sent = ""  # the id of the command by which it was sent again

    def drop(self, request: Waiting) -> None:
        """It is not wanted any more."""
        self._stage.send(Drop(request.id))

    def move(self, request: Waiting, before: str | None) -> None:
        """It is to begin before another one, or after all of them."""
        self._stage.send(Move(request.id, before))

    def take_back(self, request: Waiting, before: str | None) -> None:
        """It is to be changed; it stood ``before`` another one, or was the last."""
        self._wanted, self._behind = request, before
        self._stage.send(Drop(request.id))

    def hear(self, body: ev.Body) -> None:
        """What has become of it."""
        match body:
            case ev.RequestEnded() if self._wanted is not None and body.request == self._wanted.id:
                text, self._wanted = self._wanted.text, None
                if body.outcome == "dropped":
                    self._changing, self._emptied = True, False
                    self._stage.main.type()
                    self._stage.main.line.write(text)
                    self._keeping.tell(hint_line(strings.TAKEN_BACK, self._stage.acting))
            case ev.Ack(do="drop", ok=False) if self._wanted is not None:
                self._wanted = None
                self._keeping.tell(strings.TAKEN_BACK_TOO_LATE)
            case ev.RequestsWaiting() if self._sent:
                sent = next((one for one in body.requests if one.sent_as == self._sent), None)
                if sent is not None:
                    self._sent = ""
                    if any(one.request == self._behind for one in body.requests):
                        self._stage.send(Move(sent.request, self._behind))

    def written(self, text: str) -> None:
        """This stands in the line now. Who empties it and begins anew asks for something else."""
        if not text:
            self._emptied = True
        elif self._emptied:
            self._changing = self._emptied = False

    def asked(self, text: str, *then: str, waits: bool = False) -> Say:
        """The command for what was in the line; ``waits``: it is done after all that was asked for before."""
        changing, self._changing, self._emptied = self._changing, False, False
        if not changing:
            return Say(text, then=then, wait=waits)
        from ulid import ULID  # which nobody needs before the first picture

        self._sent = str(ULID())
        return Say(text, self._sent, then, wait=True)
