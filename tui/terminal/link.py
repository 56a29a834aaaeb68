"""The line to the terminal: what it bears is measured, and no more than that is sent.

Behind a frame the terminal is asked for a report (DSR, ECMA-48 8.3.35: ``CSI 5 n``), which it gives when it has drawn
what came before. Until then nothing more is drawn: a slow line gets fewer frames, each of them as new as can be, and
never a queue of old ones. A terminal that never reports gets frames at the fixed pace. Where reports come late for a
while, what costs most is left out, until they come early for a longer while.

Nothing here reads a clock or touches a terminal. All times are monotonic seconds.
"""

from __future__ import annotations

from collections import deque
from statistics import median
from typing import Final, Literal, NamedTuple

from msgspec import Struct

ASK: Final = "\x1b[5n"
"""Asks a terminal how it is."""
REPORT: Final = ("\x1b[0n", "\x1b[3n")
"""It is well; it is not. Either has come all the way."""

TRIES: Final = 3
"""Who has not reported after so many requests is taken for a terminal that never does."""
LIMIT_S: Final = 1.0
"""For so long a report is waited for before the next frame; twice as long after each that did not come."""
MAX_LIMIT_S: Final = 60.0

WINDOW_S: Final = 4.0
"""The meter tells about so many seconds."""
FEW: Final = 3
"""Fewer delays than these say nothing about a line."""
STALL_S: Final = 2.0
"""A report that is awaited for so long says that the line is bad before it has come."""
CALM_S: Final = 10.0
"""A line is good again after so long; after twice that time whenever it was so for less than ``RELAPSE_S``."""
MAX_CALM_S: Final = 300.0
RELAPSE_S: Final = 60.0
BETTER: Final = 0.6
"""The share of a threshold below which a delay counts as good, so that nothing flickers at the threshold."""

Fare = Literal["full", "spare", "bare"]
"""What is sent: everything; fewer frames and pictures; only what one has to know."""
_FARES: Final[tuple[Fare, ...]] = ("full", "spare", "bare")
_DELAYS: Final = (0.0, 0.4, 1.0)
"""From such delays on, s, each of them is the right one."""


class Reports:
    """Which frames the terminal has reported as drawn, and whether it is time for another one."""

    def __init__(self, *, patient: bool = False) -> None:
        """``patient``: the first reports are waited for, too, before anybody knows whether they ever come."""
        self._patient = patient
        self._asked: deque[float] = deque()  # when each report that is still to come was asked for
        self._tries = 0
        self._limit = LIMIT_S
        self._until = 0.0  # the reports are waited for
        self._last: float | None = None  # when one came

    @property
    def come(self) -> bool:
        """The terminal is one that reports."""
        return self._last is not None

    def busy(self, now: float) -> bool:
        """Something is on its way, and the next frame has to wait."""
        return (self.come or self._patient) and bool(self._asked) and now < self._until

    def overdue(self, now: float) -> float:
        """For how long the oldest report has been awaited, s."""
        return now - self._asked[0] if self.come and self._asked else 0.0

    def sent(self, now: float) -> bool:
        """A frame was sent; True when a report is to be asked for behind it."""
        if self._last is None:
            if self._tries >= TRIES or now < self._until:
                return False
            self._tries += 1
        elif self._asked:  # the limit has passed
            if self._last > self._asked[-1]:  # reports went on coming, but fewer than were asked for: some were lost
                self._asked.clear()
            else:
                self._limit = min(2 * self._limit, MAX_LIMIT_S)
        self._until = now + self._limit
        self._asked.append(now)
        return True

    def came(self, now: float) -> float | None:
        """A report came; gives the time since the frame before it was sent, s. None: nobody asked for it."""
        if not self._asked or now < self._asked[0]:  # late news, of a frame whose report was given up
            return None
        self._last, self._limit, self._until = now, LIMIT_S, now + LIMIT_S
        return now - self._asked.popleft()


class Thrift:
    """Which fare a line can pay, by its delays. It sinks soon and rises late, later each time it was wrong."""

    def __init__(self) -> None:
        self.fare: Fare = "full"
        self._good_since: float | None = None
        self._rose = float("-inf")
        self._calm = CALM_S

    def look(self, now: float, delay: float | None) -> bool:
        """Whether the fare has changed; ``delay`` is what is usual now, s, None when nobody knows."""
        if delay is None:
            return False
        at = _FARES.index(self.fare)
        right = max(index for index, least in enumerate(_DELAYS) if delay >= least)
        if right > at:
            self._calm = min(2 * self._calm, MAX_CALM_S) if now - self._rose < RELAPSE_S else CALM_S
            self._good_since = None
            self.fare = _FARES[right]
            return True
        if at == 0 or delay >= BETTER * _DELAYS[at]:
            self._good_since = None
            return False
        if self._good_since is None:
            self._good_since = now
        if now - self._good_since < self._calm:
            return False
        self._good_since, self._rose = None, now
        self.fare = _FARES[at - 1]
        return True


class Sample(NamedTuple):
    """What had been sent at one moment."""

    t: float
    written: int  # bytes since the beginning
    frames: int  # since the beginning


class LinkFigures(Struct, frozen=True):
    """The line in the last seconds."""

    delay: float | None  # s, from a frame to the report that it is drawn, usually; None: there was no report
    bytes_per_s: float  # taken by the terminal or what lies before it
    frames_per_s: float
    reports: bool  # the terminal is one that reports


class Link:
    """One line to one terminal."""

    def __init__(self, *, far: bool = False) -> None:
        """``far``: the terminal is on another machine, so that what is sent too early may lie about for long."""
        self._reports = Reports(patient=far)
        self._thrift = Thrift()
        self._delays: deque[tuple[float, float]] = deque(maxlen=64)  # when it was known, s
        self._samples: deque[Sample] = deque(maxlen=64)
        self._frames = 0

    @property
    def fare(self) -> Fare:
        """What is to be sent."""
        return self._thrift.fare

    def busy(self, now: float) -> bool:
        """The next frame has to wait."""
        return self._reports.busy(now)

    def sent(self, now: float) -> bool:
        """A frame was sent; True when a report is to be asked for behind it."""
        self._frames += 1
        return self._reports.sent(now)

    def reported(self, now: float) -> None:
        """The terminal says that it has drawn what was sent."""
        delay = self._reports.came(now)
        if delay is not None:
            self._delays.append((now, delay))

    def look(self, now: float, written: int) -> bool:
        """To be called about twice a second with the bytes written so far. True when the fare has changed."""
        self._samples.append(Sample(now, written, self._frames))
        while len(self._samples) > 2 and now - self._samples[1].t >= WINDOW_S:
            self._samples.popleft()
        return self._thrift.look(now, self._usual(now, FEW))

    def figures(self, now: float) -> LinkFigures:
        """The line as it is now."""
        first, last = (self._samples[0], self._samples[-1]) if self._samples else (Sample(0, 0, 0), Sample(0, 0, 0))
        span = last.t - first.t
        return LinkFigures(
            self._usual(now, 1),
            (last.written - first.written) / span if span else 0.0,
            (last.frames - first.frames) / span if span else 0.0,
            self._reports.come,
        )

    def _usual(self, now: float, least: int) -> float | None:
        """The usual delay of late, s, if there were at least so many; a report that is long awaited counts as late."""
        waiting = self._reports.overdue(now)
        if waiting >= STALL_S:
            return waiting
        delays = [delay for t, delay in self._delays if now - t <= WINDOW_S]
        return median(delays) if len(delays) >= least else None
