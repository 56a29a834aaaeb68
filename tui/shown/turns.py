"""The turns of a session, told from its events alone.

:meth:`Turns.after` folds an event into what is known of the turns. A turn is told by the id in the event's envelope, so
that what comes late is a remark in the turn it belongs to and never a stage of another one: once a turn is cut or over,
nothing begins in it any more.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Final, TypeVar

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from engine import events as ev
from engine.robot.geometry import heading_in_degrees
from tui.shown.facts import call, figure, in_words, printable, printable_lines
from tui.shown.turn import STAGES, VOICE, Action, Answer, Asked, Question, Sample, Span, Stage, Thought, Turn
from tui.words import strings

MAX_TURNS: Final = 40
"""Turns that are kept."""
MAX_SAMPLES: Final = 400
"""Levels of one turn that are kept: 38 s of sound."""
MAX_PARTS: Final = 200
"""Stretches, actions, thoughts, answers or remarks of one turn that are kept, each."""
MAX_CALLS: Final = 20
"""Calls of large models in one turn that are kept: each may hold as much as a page of a book."""
MAX_JSON: Final = 20_000
"""Characters of a plan that are kept."""

_Body = TypeVar("_Body", bound=Struct)


class Turns(Struct, frozen=True):
    """The turns of a session, oldest first, and the wake that waits for its turn."""

    kept: tuple[Turn, ...] = ()
    count: int = 0
    wake: tuple[float, str] | None = None  # when, and by what

    @property
    def open(self) -> Turn | None:
        """The turn that goes on."""
        return self.kept[-1] if self.kept and self.kept[-1].open else None

    @property
    def running(self) -> bool:
        """A stage is under way, whose time grows."""
        return self.open is not None and any(span.ended is None for span in self.open.spans)

    def after(self, event: ev.Event) -> Turns:
        """What is known once ``event`` has happened."""
        body = event.body
        if isinstance(body, ev.WakeHeard):
            return replace(self, wake=(event.t, body.source))
        if isinstance(body, ev.SessionEnded):
            return replace(
                self, kept=tuple(turn if turn.ended is not None else _over(turn, event.t) for turn in self.kept)
            )
        if isinstance(body, ev.RobotStateView):
            return self._moving(body, event.t)
        if isinstance(body, ev.QuestionEnded):  # which may have been put in two turns
            return replace(self, kept=tuple(_settled(turn, body.outcome) for turn in self.kept))
        if event.turn is None:
            return self
        turn = next((turn for turn in reversed(self.kept) if turn.id == event.turn), None)
        if turn is None:
            return self._opened(event)._with(event) if _begins(body) else self
        return self._with(event)

    def _with(self, event: ev.Event) -> Turns:
        kept = tuple(_fold(event.body, turn, event) if turn.id == event.turn else turn for turn in self.kept)
        return self if all(new is old for new, old in zip(kept, self.kept, strict=True)) else replace(self, kept=kept)

    def _opened(self, event: ev.Event) -> Turns:
        """With one turn more. A turn that listens begins with its wake; of one before it that is open no end came."""
        assert event.turn is not None
        listens = isinstance(event.body, ev.ListenStarted | ev.StateChanged) and self.wake is not None
        began, woken = self.wake if listens and self.wake is not None else (event.t, "")
        turn = Turn(event.turn, self.count + 1, min(began, event.t), printable(woken))
        if listens:
            turn = _begun(turn, "wake", turn.began)
        before = tuple(_over(old, event.t) if old.open else old for old in self.kept)
        return Turns((*before, turn)[-MAX_TURNS:], self.count + 1)

    def _moving(self, body: ev.RobotStateView, t: float) -> Turns:
        turn = self.open
        if turn is None or turn.moved is not None or not body.moving or not turn.of("act"):
            return self
        return replace(self, kept=(*self.kept[:-1], replace(turn, moved=t)))


def _begins(body: ev.Body) -> bool:
    """Whether a turn may become known by this: not by the last of one that nobody here has seen."""
    if isinstance(body, ev.StateChanged):
        return body.result is None
    if isinstance(body, ev.ListenStarted | ev.TranscriptFinal | ev.ActionQueued | ev.ActionStarted | ev.SpeechStarted):
        return True
    return isinstance(body, ev.DecisionMade | ev.PlanMade | ev.ClarificationAsked | ev.RefusalMade)


# Stretches


def _begun(turn: Turn, stage: Stage, t: float, of: str = "") -> Turn:
    """With a stretch that begins at ``t``; nothing begins in a turn that is cut or over."""
    if turn.cut is not None or not turn.open or len(turn.spans) >= MAX_PARTS:
        return turn
    return replace(turn, spans=(*turn.spans, Span(stage, max(turn.began, t), of=of)))


def _done(turn: Turn, t: float, *stages: Stage, outcome: ev.Outcome = "ok", of: str = "") -> Turn:
    """Without open stretches of these stages (of this action, when one is given)."""
    if not any(_concerns(span, stages, of) for span in turn.spans):
        return turn
    ended = tuple(
        replace(span, ended=max(span.began, t), outcome=outcome) if _concerns(span, stages, of) else span
        for span in turn.spans
    )
    return replace(turn, spans=ended)


def _concerns(span: Span, stages: tuple[Stage, ...], of: str) -> bool:
    return span.ended is None and span.stage in stages and (not of or span.of == of)


def _over(turn: Turn, t: float, result: ev.TurnResult | None = None) -> Turn:
    """The turn at its end: whatever still goes on has been cut by it."""
    whole = result is not None and result.outcome not in ("interrupted", "timeout", "failed")
    turn = _done(turn, t, *STAGES, outcome="ok" if whole else "interrupted")
    actions = tuple(replace(a, phase="interrupted") if a.phase in ("queued", "running") else a for a in turn.actions)
    return replace(turn, ended=max(turn.began, t), actions=actions, result=result, resting=None)


def _settled(turn: Turn, question: Question) -> Turn:
    """What it asked back, if it did, is not open any more."""
    if turn.result is None or turn.result.outcome != "clarify" or turn.question is not None:
        return turn
    return replace(turn, question=question)


# One function per kind of event


@singledispatch
def _fold(body: ev.Body, turn: Turn, event: ev.Event) -> Turn:
    return turn


@_fold.register
def _(body: ev.StateChanged, turn: Turn, event: ev.Event) -> Turn:
    t = event.t
    if not turn.open:
        return turn
    if body.result is not None:
        return _over(turn, t, _clean(body.result))
    match body.state:
        case "DECIDING" | "PLANNING":
            return _thinking(turn, t, "decide" if body.state == "DECIDING" else "plan")
        case "FEEDBACK":
            return replace(_done(turn, t, "decide", "plan"), resting=t)
        case "LISTENING" | "TRANSCRIBING":
            return turn
        case _:
            return replace(_done(turn, t, "decide", "plan"), resting=None)


def _thinking(turn: Turn, t: float, stage: Stage) -> Turn:
    """Thinking begins where the work before it ended: the state only changes once a planner says what it does."""
    last = turn.spans[-1] if turn.spans else None
    if last is not None and last.ended is None and last.stage == "plan":
        return replace(turn, spans=(*turn.spans[:-1], replace(last, stage=stage)))
    turn = _done(turn, t, "decide", "plan")
    return replace(_begun(turn, stage, t if turn.resting is None else turn.resting), resting=None)


@_fold.register
def _(body: ev.InterruptRaised, turn: Turn, event: ev.Event) -> Turn:
    if not turn.open or turn.cut is not None:
        return turn
    turn = _done(turn, event.t, "wake", "record", "recognise", "decide", "plan", outcome="interrupted")
    return replace(turn, cut=_clean(body), resting=None)


@_fold.register
def _(body: ev.ListenStarted, turn: Turn, event: ev.Event) -> Turn:
    return _begun(_done(turn, event.t, "wake"), "record", event.t)


@_fold.register
def _(body: ev.ListenLevel, turn: Turn, event: ev.Event) -> Turn:
    if not any(_concerns(span, ("record",), "") for span in turn.spans):
        return turn
    sample = Sample(event.t, body.rms_db, body.peak_db, body.speech_probability >= VOICE)
    return replace(turn, samples=(*turn.samples[1 - MAX_SAMPLES :], sample))


@_fold.register
def _(body: ev.ListenEnded, turn: Turn, event: ev.Event) -> Turn:
    if not turn.open:
        return turn
    heard = body.reason in ("silence", "max_length", "source_ended") and body.audio_s > 0
    outcome: ev.Outcome = "ok" if heard else "interrupted" if body.reason == "cancelled" else "failed"
    if heard and turn.voice is not None:
        turn = _begun(_done(turn, turn.voice[1], "record"), "endpoint", turn.voice[1])
    turn = replace(_done(turn, event.t, "wake", "record", "endpoint", outcome=outcome), listened=body)
    return _begun(turn, "recognise", event.t) if heard else turn


@_fold.register
def _(body: ev.TranscriptFinal, turn: Turn, event: ev.Event) -> Turn:
    if not turn.open or turn.heard is not None:
        return _remarked(turn, f"transcript.final: {body.text}")
    turn = replace(_done(turn, event.t, "wake", "record", "recognise"), heard=_clean(body))
    return _begun(turn, "plan", event.t)


@_fold.register
def _(body: ev.TranscriptRejected, turn: Turn, event: ev.Event) -> Turn:
    if not turn.open or body.reason == "late":
        return _remarked(turn, f"{body.detail} {body.text}".rstrip())
    return replace(_done(turn, event.t, "recognise", outcome="failed"), unheard=_clean(body))


@_fold.register
def _(body: ev.DecisionMade, turn: Turn, event: ev.Event) -> Turn:
    return _thought(turn, Thought("decision", source=body.source, steps=tuple(map(printable, body.steps))))


@_fold.register
def _(body: ev.ModelAsked, turn: Turn, event: ev.Event) -> Turn:
    asked = [thought for thought in turn.thoughts if isinstance(thought, Asked)]
    if len(asked) >= MAX_CALLS:
        turn = replace(turn, thoughts=tuple(thought for thought in turn.thoughts if thought is not asked[0]))
    messages = tuple(ev.MessageView(message.role, printable_lines(message.text)) for message in body.messages)
    texts = {"messages": messages, "reply": printable_lines(body.reply)}  # of the others, each is one line
    clean = replace(_clean(body), **texts)
    return _thought(turn, Asked(clean, late=turn.cut is not None or not turn.open))


@_fold.register
def _(body: ev.PlanMade, turn: Turn, event: ev.Event) -> Turn:
    steps = tuple(map(printable, body.steps)) or tuple(call(action.name, action.args) for action in body.actions)
    response = printable(body.response)
    thought = Thought("plan", printable(body.goal), body.source, steps, response, written(body))
    return _thought(_done(turn, event.t, "decide", "plan"), thought)


@_fold.register
def _(body: ev.PlanRejected, turn: Turn, event: ev.Event) -> Turn:
    if body.code == "late":
        return _remarked(turn, body.reason)
    found = Thought("rejection", printable(body.reason), printable(body.code), tuple(map(printable, body.suggestions)))
    return _thought(_done(turn, event.t, "decide", "plan", outcome="failed"), found)


@_fold.register
def _(body: ev.ClarificationAsked, turn: Turn, event: ev.Event) -> Turn:
    unclear = body.about or (body.intent.ambiguity if body.intent is not None else "") or ""
    turn = replace(_done(turn, event.t, "decide", "plan"), question=None if body.leaves_open else "no_order")
    return _thought(turn, Thought("question", printable(body.question), unclear))


@_fold.register
def _(body: ev.RefusalMade, turn: Turn, event: ev.Event) -> Turn:
    return _thought(_done(turn, event.t, "decide", "plan"), Thought("refusal", printable(body.reason)))


@_fold.register
def _(body: ev.ActionQueued, turn: Turn, event: ev.Event) -> Turn:
    return _acted(turn, Action(body.action, body.index, in_words(body), "queued")) if turn.open else turn


@_fold.register
def _(body: ev.ActionStarted, turn: Turn, event: ev.Event) -> Turn:
    old = _action(turn, body.action)
    if not turn.open or (old is not None and old.phase != "queued"):
        return turn
    turn = _acted(turn, Action(body.action, body.index, in_words(body), "running"))
    return _begun(replace(turn, resting=None), "act", event.t, body.action)


@_fold.register
def _(body: ev.ActionFinished, turn: Turn, event: ev.Event) -> Turn:
    old = _action(turn, body.action) or Action(body.action, 0, call(body.name, body.args), "queued")
    data = ", ".join(_found(key, value) for key, value in (body.data or {}).items())
    ended = replace(
        old,
        phase=body.outcome,
        duration_s=body.duration_s,
        error_code=printable(body.error_code or ""),
        message=printable(body.message),
        data=printable(data),
    )
    return _acted(_done(turn, event.t, "act", outcome=body.outcome, of=body.action), ended)


@_fold.register
def _(body: ev.SpeechStarted, turn: Turn, event: ev.Event) -> Turn:
    if not turn.open:
        return turn
    answers = (*turn.answers, Answer(printable(body.text), body.audible))[-MAX_PARTS:]
    return _begun(_done(replace(turn, answers=answers), event.t, "decide", "plan"), "speak", event.t)


@_fold.register
def _(body: ev.SpeechEnded, turn: Turn, event: ev.Event) -> Turn:
    if not turn.answers or turn.answers[-1].heard is not None:
        return turn
    last = replace(turn.answers[-1], heard=printable(body.heard), outcome=body.outcome)
    turn = replace(turn, answers=(*turn.answers[:-1], last))
    turn = _done(turn, event.t, "speak", outcome=body.outcome)
    return turn if turn.resting is None else replace(turn, resting=event.t)


@_fold.register
def _(body: ev.ErrorRaised, turn: Turn, event: ev.Event) -> Turn:
    return _remarked(turn, f"{body.code}: {body.message}")


@_fold.register
def _(body: ev.Log, turn: Turn, event: ev.Event) -> Turn:
    return _remarked(turn, f"{body.source}: {body.message}") if body.level in ("warning", "error") else turn


# Parts


def written(body: ev.Body) -> str:
    """An event as indented JSON that a terminal can show."""
    text = msgspec.json.format(msgspec.json.encode(body), indent=2).decode("utf-8", "replace")
    return "\n".join(map(printable, text[:MAX_JSON].splitlines()))


def _action(turn: Turn, action: str) -> Action | None:
    return next((known for known in turn.actions if known.id == action), None)


def _acted(turn: Turn, action: Action) -> Turn:
    if _action(turn, action.id) is None:
        return replace(turn, actions=(*turn.actions, action)[-MAX_PARTS:])
    return replace(turn, actions=tuple(action if old.id == action.id else old for old in turn.actions))


def _thought(turn: Turn, thought: Thought | Asked) -> Turn:
    return replace(turn, thoughts=(*turn.thoughts, thought)[-MAX_PARTS:])


def _remarked(turn: Turn, text: str) -> Turn:
    return replace(turn, remarks=(*turn.remarks, printable(text))[-MAX_PARTS:])


def _found(key: str, value: ev.Value) -> str:
    """What an action has found out, by the name it has on the wire; a heading as people read it."""
    if key == "yaw" and isinstance(value, float):
        return f"{strings.HEADING} {heading_in_degrees(value):.0f}°"
    return f"{key} {_figure(value)}"


def _figure(value: ev.Value) -> str:
    return figure(value) if isinstance(value, float) else str(value)


def _clean(body: _Body) -> _Body:
    """The same with texts that cannot disturb a terminal."""
    texts = {
        name: printable(value)
        for name in body.__struct_fields__
        if isinstance(value := getattr(body, name), str) and printable(value) != value
    }
    return replace(body, **texts) if texts else body
