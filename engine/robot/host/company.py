"""The people around a robot whose body plays them in its host: sentences go there through shared memory, and what they
do comes back the same way.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from engine.robot.company import Company, News
from engine.robot.host.memory import NEWS, SPEECH, Memory, Queue, clipped


class SharedCompany:
    """A :class:`engine.robot.company.Company`, as the engine holds it. Nobody hears a robot without a host."""

    def __init__(self, memory: Callable[[], Memory | None]) -> None:
        """``memory`` gives what is shared with the host by now."""
        self._memory = memory
        self._lock = threading.Lock()
        self._read_of: Memory | None = None
        self._seen = 0  # news of that memory

    def tell(self, text: str) -> None:
        if (memory := self._memory()) is None:
            return
        with self._lock:
            memory.speech.scratch["text"] = clipped(text, SPEECH, "text")
            memory.speech.put()

    def news(self) -> tuple[News, ...]:
        if (memory := self._memory()) is None:
            return ()
        with self._lock:
            if memory is not self._read_of:
                self._read_of, self._seen = memory, 0
            records, self._seen = memory.news.since(self._seen)
        return tuple(_news(record) for record in records)


class Relay:
    """The other end, in the host: hands on what the robot says, and shows what they do."""

    def __init__(self, company: Company, speech: Queue, news: Queue) -> None:
        self._company, self._speech, self._news = company, speech, news
        self._heard = speech.count  # what was said while there was no host, nobody hears

    def take(self) -> None:
        """Let them hear what is new."""
        if self._speech.count == self._heard:
            return
        records, self._heard = self._speech.since(self._heard)
        for record in records:
            self._company.tell(record["text"].item().decode(errors="replace"))

    def show(self) -> None:
        """Show what they have done."""
        for news in self._company.news():
            scratch = self._news.scratch
            scratch["t"], scratch["does"] = news.t, news.does.encode()
            scratch["who"], scratch["text"] = clipped(news.who, NEWS, "who"), clipped(news.text, NEWS, "text")
            self._news.put()


def _news(record: Any) -> News:
    who, does, text = (record[field].item().decode(errors="replace") for field in ("who", "does", "text"))
    return News(float(record["t"]), who, does, text)
