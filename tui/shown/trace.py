"""What the microphone heard, as one trace: levels in a row, and between them marks that say what was made of them.

:func:`after` folds an event into the trace. Whoever looks at it sees why the robot did or did not hear: a wake, how
loud it was, what counted as speech, where the end of speech was found, and what the recogniser thought of it.
"""

from __future__ import annotations

from typing import Final, Literal

from msgspec import Struct
from msgspec.structs import replace

from engine import events as ev
from tui.shown.facts import Level, printable
from tui.words import strings

MAX_TRACE: Final = 240
"""Levels and marks that are kept: about 24 s at ten levels a second."""

Sign = Literal["wake", "endpoint", "understood", "rejected", "stopped"]


class Mark(Struct, frozen=True):
    """Something that happened between two levels: ``word`` in few words, ``detail`` in more."""

    sign: Sign
    word: str
    detail: str = ""
    turn: str | None = None


class Trace(Struct, frozen=True):
    """Levels and marks, oldest first."""

    items: tuple[Level | Mark, ...] = ()
    loudest_db: float | None = None  # of the present recording, or the last one
    listens: bool = False

    @property
    def last_mark(self) -> Mark | None:
        """What was made last of what was heard."""
        return next((item for item in reversed(self.items) if isinstance(item, Mark)), None)

    def marked(self, mark: Mark) -> Trace:
        return replace(self, items=(*self.items[1 - MAX_TRACE :], mark))


def after(trace: Trace, event: ev.Event) -> Trace:
    """The trace once ``event`` has happened."""
    match event.body:
        case ev.WakeHeard(source=source, phrase=phrase, angle_deg=angle):
            where = [] if angle is None else [strings.WOKEN_FROM.format(angle=angle)]
            named = [f"“{printable(phrase)}”"] if phrase else []
            word = strings.WAKE_BY.get(source, source)
            return trace.marked(Mark("wake", word, ", ".join([*named, *where])))
        case ev.ListenStarted():
            return replace(trace, listens=True, loudest_db=None)
        case ev.ListenLevel() as body if trace.listens:
            loudest = body.rms_db if trace.loudest_db is None else max(trace.loudest_db, body.rms_db)
            level = Level(body.rms_db, body.speech_probability, body.in_speech)
            return replace(trace, items=(*trace.items[1 - MAX_TRACE :], level), loudest_db=loudest)
        case ev.ListenEnded() as body if trace.listens:
            return replace(trace, listens=False).marked(_end(body, trace.loudest_db, event.turn))
        case ev.TranscriptFinal(source="speech") as body:
            sure = strings.CONFIDENCE.format(percent=100 * body.confidence)
            return trace.marked(Mark("understood", strings.UNDERSTOOD, sure, event.turn))
        case ev.TranscriptFinal(source="overheard") as body:
            said = f"“{printable(body.text)}”"
            return trace.marked(Mark("understood", strings.HOW_SAID["overheard"], said, event.turn))
        case ev.TranscriptRejected(reason=reason) as body:
            said = f" “{printable(body.text)}”" if body.text else ""
            return trace.marked(Mark("rejected", strings.REJECTED[reason], printable(body.detail) + said, event.turn))
        case ev.SessionEnded():
            return replace(trace, listens=False)
    return trace


def _end(body: ev.ListenEnded, loudest_db: float | None, turn: str | None) -> Mark:
    loudest = "" if loudest_db is None else strings.LOUDEST.format(db=f"{max(-99.0, loudest_db):.0f}".replace("-", "−"))
    match body.reason:
        case "no_speech":
            return Mark("rejected", strings.LISTEN_ENDS["no_speech"], loudest, turn)
        case "device_lost":
            return Mark("rejected", strings.LISTEN_ENDS["device_lost"], "", turn)
        case "cancelled":
            return Mark("stopped", strings.LISTEN_ENDS["cancelled"], "", turn)
    if not body.audio_s:
        return Mark("rejected", strings.LISTEN_ENDS["no_speech"], loudest, turn)
    return Mark("endpoint", strings.LISTEN_ENDS[body.reason], strings.SPEECH_FOR.format(seconds=body.speech_s), turn)
