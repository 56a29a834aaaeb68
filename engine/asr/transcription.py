"""One piece of work for the recogniser's thread, which somebody else may stop needing at any moment."""

from __future__ import annotations

import threading
from collections.abc import Callable

from engine.asr.recogniser import Rejected, Transcript
from engine.errors import SaysoError

Found = Transcript | Rejected | SaysoError


class Transcription:
    """One transcription. Its result is either used or late: never both, never neither."""

    def __init__(self, work: Callable[[Callable[[], bool]], Transcript | Rejected]) -> None:
        """``work`` may ask what it is given whether it is still needed."""
        self._work = work
        self._lock = threading.Lock()
        self._late: Callable[[Found], None] | None = None
        self._found: Found | None = None
        self.has_begun = False

    @property
    def is_cancelled(self) -> bool:
        """Nobody waits for the result any more."""
        return self._late is not None

    def run(self) -> Found:
        """In the recogniser's thread. An error is a result too: raised, nobody might be there to see it."""
        found: Found
        self.has_begun = True
        if self.is_cancelled:
            found = Rejected("empty", "It was cancelled before it began.")
        else:
            try:
                found = self._work(lambda: self.is_cancelled)
            except SaysoError as error:
                found = error
        with self._lock:
            self._found = found
            late = self._late
        if late is not None:
            late(found)
        return found

    def cancel(self, late: Callable[[Found], None] = lambda found: None) -> None:
        """Nobody waits for the result any more. ``late`` is told of it, in any thread. Thread-safe."""
        with self._lock:
            self._late = late
            found = self._found
        if found is not None:
            late(found)


def deserves_another_look(found: Found) -> bool:
    """It is the result of a quick pass, and a thorough one may find something else."""
    return not isinstance(found, SaysoError) and found.decoding is not None and found.decoding.doubtful
