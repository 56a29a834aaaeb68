"""The requests that wait: dropped, moved, and taken back into the line to be changed.

One that is taken back is dropped first, and comes into the line once the engine says so: in that moment it may have
begun. What is made of it waits again, in its old place or behind all others, and interrupts nothing. Who empties the
line leaves it out, which has a row. What stood in the line before comes back into it afterwards.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from engine import events as ev
from engine.commands import Drop, Move, Say
from tui.widgets.ask import requests_of
from tui.words import strings
from tui.words.hints import hint_line

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tui.rooms.drawing import Drawing
    from tui.rooms.early import Early
    from tui.rooms.keeping import Keeping
    from tui.shown.facts import Waiting
    from tui.stage import Stage


@dataclass(slots=True)
class _Taken:
    """A request that is taken back into the line."""

    request: Waiting
    behind: tuple[str, ...]
    """Those that waited behind it, next first: each by its id, or by the id of the command that asked for it."""
    draft: str = ""
    """What stood in the line before."""
    written: bool = False
    """The line has told that it is there."""
    has_place: bool = True
    """Nothing has dropped what waited beside it."""


class Queueing:
    """In the UI thread."""

    def __init__(self, stage: Stage, drawing: Drawing, keeping: Keeping, early: Early) -> None:
        self._stage = stage
        self._early = early
        self._drawing = drawing
        self._keeping = keeping
        self._wanted: _Taken | None = None  # it is to be taken back, and nobody has said that it is
        self._changing: _Taken | None = None  # it is in the line
        self._told = ""  # how that goes back
        self._sent: dict[str, tuple[str, ...]] = {}  # what waited behind those that are sent again, by their commands

    def drop(self, request: Waiting) -> None:
        """It is not wanted any more."""
        self._leaves(request)
        if (text := self._early.drop(request.id)) is not None:
            self._drawing.left_out(text, strings.LOST["dropped"])
        else:
            self._stage.send(Drop(request.id))

    def move(self, request: Waiting, before: str | None) -> None:
        """It is to begin before another one, or after all of them."""
        if not self._early.move(request.id, before):
            self._stage.send(Move(request.id, before))

    def take_back(self, request: Waiting) -> None:
        """It is to be changed. One that is in the line already goes back as it was: nobody has sent what became of
        it."""
        if self._wanted is not None and self._wanted.request.id == request.id:
            return
        ids = [one.id for one in self._stage.shown.model.waiting]
        behind = tuple(ids[ids.index(request.id) + 1 :]) if request.id in ids else ()
        if (before := self._changing) is not None:
            self._end()
            self._stage.main.line.write(before.draft)
            sent = self._again(before, requests_of(before.request.text) or (before.request.text,))
            if self._stage.handle is None:
                self._early.add(sent, self.place_of(sent))
            else:
                self._stage.send(sent)
            if sent.id is not None and before.behind[:1] == behind[:1]:  # it stood between this one and the next
                behind = (sent.id, *behind)
        self._leaves(request)
        if self._early.drop(request.id) is not None:
            self._change(_Taken(request, behind))
            return
        self._wanted = _Taken(request, behind)
        self._drawing.taken_back(request.id)
        self._stage.send(Drop(request.id))

    def hear(self, body: ev.Body) -> None:
        """What has become of it."""
        match body:
            case ev.RequestEnded() if self._wanted is not None and body.request == self._wanted.request.id:
                taken, self._wanted = self._wanted, None
                if body.outcome == "dropped":
                    self._change(taken)
            case ev.InterruptRaised() | ev.TaskEnded():
                self.stopped()
            case ev.Ack(do="drop", ok=False) if self._wanted is not None:
                self._wanted = None
                self._keeping.tell(strings.TAKEN_BACK_TOO_LATE)
            case ev.RequestsWaiting() if self._sent:
                for one in body.requests:
                    if one.sent_as is not None and one.sent_as in self._sent:
                        self._put(one.sent_as, body.requests)

    def _change(self, taken: _Taken) -> None:
        """It is in the line from now on."""
        line = self._stage.main.line
        taken.draft, self._changing = line.value, taken
        self._drawing.puts_back = True
        self._stage.main.type()
        line.write(taken.request.text)
        self._told = hint_line(strings.TAKEN_BACK, self._stage.acting)
        self._keeping.tell(
            self._told, holds=lambda view: self._changing is taken and self._stage.focused is line and taken.has_place
        )

    def stopped(self) -> None:
        """All that waited is dropped: what is in the line has no place any more to which it would go back."""
        if self._changing is not None:
            self._changing.has_place = False
            self._stage.redraw()

    def _leaves(self, request: Waiting) -> None:
        """It waits no more: nothing that was sent again can wait before it."""
        for sent, behind in self._sent.items():
            self._sent[sent] = tuple(mark for mark in behind if mark != request.id)

    def _put(self, sent: str, waiting: Sequence[ev.WaitingRequest]) -> None:
        """What was sent again waits: have it do so before the first that still does of those that were behind it."""
        behind = self._sent.pop(sent)
        following = (one.request for mark in behind for one in waiting if mark in (one.request, one.sent_as))
        if (before := next(following, None)) is not None:
            for one in waiting:
                if one.sent_as == sent:
                    self._stage.send(Move(one.request, before))

    def written(self, text: str) -> None:
        """This stands in the line now. Who empties it leaves out what was taken back."""
        taken = self._changing
        if taken is None:
            return
        if text:
            taken.written = True
        elif taken.written:  # else it was empty before
            self._end()
            self._drawing.left_out(taken.request.text, strings.LOST["dropped"])
            if not self._stage.main.line.value:
                self._stage.main.line.write(taken.draft)

    def asked(self, text: str, *then: str, waits: bool = False, here: bool = True) -> Say:
        """The command for what was asked for; ``waits``: it is done after all that was asked for before; ``here``: it
        was in the line, where what was taken back to be changed stands."""
        taken = self._changing if here else None
        if taken is None:
            return Say(text, then=then, wait=waits)
        self._end()
        if not self._stage.main.line.value:
            self._stage.main.line.write(taken.draft)
        return Say(text, then=then, wait=True) if waits else self._again(taken, (text, *then))

    def place_of(self, sent: Say) -> tuple[str, ...]:
        """The ids of those before which it waits in its old place, next first; for whoever puts it there."""
        return self._sent.pop(sent.id or "", ())

    def _again(self, taken: _Taken, texts: Sequence[str]) -> Say:
        """The command that has these wait in its place."""
        from ulid import ULID  # which nobody needs before the first picture

        id = str(ULID())
        self._sent[id] = taken.behind
        return Say(texts[0], id, tuple(texts[1:]), wait=True, requests=(id,))

    def _end(self) -> None:
        """What was taken back is not in the line any more, and nothing says so any longer."""
        self._changing, self._drawing.puts_back = None, False
        self._keeping.take_away(self._told)
