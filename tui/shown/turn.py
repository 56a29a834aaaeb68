"""One turn, from the wake to the last word: which stage took how long, what was thought, done and said, and why not.

A frozen value; :mod:`tui.shown.turns` makes it from events. All times are event time, s.
"""

from __future__ import annotations

from typing import Final, Literal

from msgspec import Struct

from engine import events as ev
from tui.shown.facts import Phase

Stage = Literal["wake", "record", "endpoint", "recognise", "decide", "plan", "act", "speak"]
"""``record`` is a recording up to the last sound of speech, ``endpoint`` the silence until it was clear that this was
all. For ``act`` and ``speak`` nobody waits, they are what was asked for."""
STAGES: Final[tuple[Stage, ...]] = ("wake", "record", "endpoint", "recognise", "decide", "plan", "act", "speak")
Question = Literal["answered", "declined", "replaced", "withdrawn", "no_order"]
"""``no_order``: nothing was open; else as in the event ``question.ended``."""
WAITED_FOR: Final[tuple[Stage, ...]] = ("wake", "endpoint", "recognise", "decide", "plan")

VOICE: Final = 0.5
"""Probability from which a level counts as speech."""
SAMPLE_S: Final = 0.1
"""About how long a level tells of, s; it comes at the end of that."""
SLOW_S: Final = 0.2
"""What is quicker than this is not called slow, s."""


class Span(Struct, frozen=True):
    """A stretch of a stage."""

    stage: Stage
    began: float
    ended: float | None = None  # None: it goes on
    outcome: ev.Outcome = "ok"
    of: str = ""  # id of the action


class Sample(Struct, frozen=True):
    """How loud it was, and whether somebody spoke, in the tenth of a second that ended at ``t``."""

    t: float
    rms_db: float
    peak_db: float
    voiced: bool


class Action(Struct, frozen=True):
    """One action of a plan, and its end."""

    id: str
    index: int
    call: str
    phase: Phase
    duration_s: float | None = None  # robot time
    error_code: str = ""
    message: str = ""
    data: str = ""  # what was found out


class Thought(Struct, frozen=True):
    """What a planner came to: steps in words, a plan, or why there is none."""

    kind: Literal["decision", "plan", "question", "refusal", "rejection"]
    text: str = ""
    source: str = ""
    steps: tuple[str, ...] = ()
    response: str = ""
    written: str = ""  # as JSON, indented


class Asked(Struct, frozen=True):
    """A call of a large model: what it was told, and what it wrote."""

    call: ev.ModelAsked
    late: bool  # the turn was cut or over when it ended


class Answer(Struct, frozen=True):
    """What the robot said, and what could be heard of it."""

    text: str
    audible: bool
    heard: str | None = None  # None: it still speaks
    outcome: ev.Outcome = "ok"


class Turn(Struct, frozen=True):
    """Everything that is known of one turn."""

    id: str
    number: int  # 1 is the first of the session
    began: float
    woken: str = ""  # by what
    listened: ev.ListenEnded | None = None
    heard: ev.TranscriptFinal | None = None
    unheard: ev.TranscriptRejected | None = None
    samples: tuple[Sample, ...] = ()
    spans: tuple[Span, ...] = ()
    thoughts: tuple[Thought | Asked, ...] = ()
    actions: tuple[Action, ...] = ()
    answers: tuple[Answer, ...] = ()
    remarks: tuple[str, ...] = ()  # errors, warnings, and what came late
    cut: ev.InterruptRaised | None = None
    result: ev.TurnResult | None = None
    ended: float | None = None
    moved: float | None = None  # when the robot first moved for it
    resting: float | None = None  # since when nobody thinks, acts or speaks between two plans
    question: Question | None = None  # what became of what it asked back; None: that is open, or it asked nothing

    @property
    def text(self) -> str:
        """What was asked, as far as that is known."""
        if self.heard is not None:
            return self.heard.text
        return self.unheard.text if self.unheard is not None else ""

    @property
    def open(self) -> bool:
        """The turn goes on."""
        return self.ended is None

    @property
    def outcome(self) -> str:
        """How it ended, if it has; where it asked back, what became of that."""
        if self.result is None:
            return "open" if self.open else "interrupted"
        return self.question if self.question and self.result.outcome == "clarify" else self.result.outcome

    def of(self, stage: Stage) -> tuple[Span, ...]:
        """The stretches of a stage, in the order in which they began."""
        return tuple(span for span in self.spans if span.stage == stage)

    def seconds(self, stage: Stage, now: float) -> float:
        """How long a stage has taken by ``now``; what ran side by side counts once."""
        total, reached = 0.0, float("-inf")
        for began, ended in sorted((span.began, now if span.ended is None else span.ended) for span in self.of(stage)):
            total += max(0.0, ended - max(began, reached))
            reached = max(reached, ended)
        return total

    @property
    def voice(self) -> tuple[float, float] | None:
        """When the first and the last sound of speech was heard, to a tenth of a second."""
        voiced = [sample.t for sample in self.samples if sample.voiced]
        return (voiced[0], voiced[-1]) if voiced else None

    @property
    def asked(self) -> float | None:
        """When somebody had asked: the end of speech, or the moment in which it was typed."""
        if self.heard is None:
            return None
        if self.heard.source != "speech":
            return self.began
        if self.voice is not None:
            return self.voice[1]
        return next((span.ended for span in self.of("record")), None)  # a file: it is heard in no time

    @property
    def to_motion(self) -> float | None:
        """From the end of speech to the first motion, s."""
        return None if self.asked is None or self.moved is None else max(0.0, self.moved - self.asked)

    @property
    def to_answer(self) -> float | None:
        """From the end of speech to the first word, s."""
        spoken = next((span.began for span in self.of("speak")), None)
        return None if self.asked is None or spoken is None else max(0.0, spoken - self.asked)

    def slowest(self, now: float) -> Stage | None:
        """The stage that was waited for longest; None where nothing was slow."""
        stage = max(WAITED_FOR, key=lambda stage: self.seconds(stage, now))
        return stage if self.seconds(stage, now) >= SLOW_S else None
