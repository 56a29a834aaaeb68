"""What the console shows, as one frozen value: :meth:`ConsoleModel.after` folds an event into the next one.

Nothing here knows a terminal or a clock. Widgets draw from the model alone, so a test posts events and looks, and a
recording shows the same screen as the session it was made from.
"""

from __future__ import annotations

import math
from functools import singledispatch
from typing import Final, Literal

from msgspec import Struct, field
from msgspec.structs import replace

from engine import events as ev
from engine.states import EXPRESSING, REST
from tui.shown.facts import Ended, Line, LogLine, Path, Plan, Problem, Row, Waiting, call, in_words, printable
from tui.shown.trace import Trace
from tui.shown.trace import after as trace_after
from tui.shown.turn import Turn
from tui.shown.turns import Turns
from tui.words import strings

MAX_LINES: Final = 300
"""Conversation and log lines that are kept."""
MAX_ENDS: Final = 50
"""Ends of requests that were not done, and are kept."""
MAX_ROWS: Final = 100
"""Actions of one turn that are kept."""
MAX_TRAIL: Final = 400
"""Corners of the way behind the robot that are kept."""
TRAIL_STEP: Final = 0.1
"""m between them."""

_WELL: Final = frozenset({"done", "clarify", "answer"})
"""How requests end that were done, or that the robot has asked about."""
BUSY: Final = frozenset({"TRANSCRIBING", "DECIDING", "PLANNING", "SPEAKING", "ACTING", "FEEDBACK"})
"""States in which the robot is at work on what was asked."""


class ConsoleModel(Struct, frozen=True):
    """Everything the console shows, at one moment."""

    t: float = 0.0  # s, time of the newest event
    mode: str = ""
    state: ev.State = "IDLE"
    cycle: int = 1  # the how-manieth task
    conversation: tuple[Line, ...] = ()
    partial: str = ""  # words heard so far…
    stable: int = 0  # …and how many of them, from the first, will hardly change any more
    plan: Plan | None = None
    queue: tuple[Row, ...] = ()
    ends: tuple[Ended, ...] = ()  # of requests that were not done
    waiting: tuple[Waiting, ...] = ()  # requests that are not begun yet, next first
    taken_back: str = ""  # the id of one that this console drops only to have it in the line
    offers: ev.OffersMade = field(default_factory=ev.OffersMade)  # what may be asked about the past in a word
    log: tuple[LogLine, ...] = ()
    listening: bool = False
    trace: Trace = field(default_factory=Trace)
    turns: Turns = field(default_factory=Turns)
    robot: ev.RobotStateView | None = None
    trail: Path = ()  # where it has been since the task began, map frame, m
    problem: Problem | None = None
    ended: str | None = None  # why the session ended

    def after(self, event: ev.Event) -> ConsoleModel:
        """The model once ``event`` has happened. Kinds that show nowhere only move the time."""
        trace, turns = trace_after(self.trace, event), self.turns.after(event)
        return _fold(event.body, replace(self, t=max(self.t, event.t), trace=trace, turns=turns), event)

    @property
    def running(self) -> Row | None:
        """The action that runs now."""
        return next((row for row in self.queue if row.phase == "running"), None)

    @property
    def path(self) -> Path:
        """The planned way ahead, map frame, m."""
        return next((row.path for row in self.queue if row.phase == "running" and row.path), ())

    @property
    def pressed(self) -> bool:
        """The emergency stop is."""
        return self.robot is not None and self.robot.estop

    @property
    def busy(self) -> bool:
        """A task is under way that quitting would break off."""
        return self.state in BUSY or self.running is not None

    @property
    def asks(self) -> bool:
        """A question of the robot about a request is open."""
        return self.state in REST and self.plan is not None and self.plan.stage == "question" and self.plan.open

    @property
    def unfinished(self) -> bool:
        """Something runs, waits, or has been asked: who leaves loses it."""
        return self.busy or self.asks or bool(self.waiting)

    @property
    def asking(self) -> bool:
        """Such a question is open, or is asked just now."""
        return self.asks or self.state == "CLARIFYING"

    @property
    def held(self) -> bool:
        """What waits begins when a question of the robot has been answered."""
        return bool(self.waiting) and self.asks

    @property
    def moving(self) -> bool:
        """Something changes from moment to moment without being an event of its own."""
        if self.listening or self.running is not None or self.turns.running:
            return True
        return self.robot is not None and self.robot.moving

    def with_line(self, line: Line) -> ConsoleModel:
        return replace(self, conversation=(*self.conversation[1 - MAX_LINES :], line))

    def with_end(
        self, text: str, message: str = "", note: str = "", by: str = "", *, halted: bool = False, done: bool = False
    ) -> ConsoleModel:
        """A request has ended, as in :class:`Ended`."""
        number = self.ends[-1].number + 1 if self.ends else 1
        return replace(self, ends=(*self.ends[1 - MAX_ENDS :], Ended(number, text, message, note, by, halted, done)))

    def with_log(
        self,
        level: Literal["debug", "info", "warning", "error"],
        source: str,
        text: str,
        turn: str | None = None,
        *,
        t: float | None = None,
    ) -> ConsoleModel:
        """One more line; it was written at event time ``t``, or with the newest event."""
        line = LogLine(self.t if t is None else t, level, printable(source), printable(text), turn)
        return replace(self, log=(*self.log[1 - MAX_LINES :], line))

    def with_row(self, row: Row) -> ConsoleModel:
        """The row in place of the one of the same action, or as the last of its turn."""
        if any(old.action == row.action for old in self.queue):
            return replace(self, queue=tuple(row if old.action == row.action else old for old in self.queue))
        return replace(self, queue=(*(old for old in self.queue if old.turn == row.turn), row)[-MAX_ROWS:])


# One function per kind of event; the envelope comes last


@singledispatch
def _fold(body: ev.Body, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    return model


@_fold.register
def _(body: ev.SessionStarted, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    model = replace(model, mode=body.mode, ended=None)
    return model.with_log("info", "session", f"sayso {body.version}, {body.robot}, {body.mode}", event.turn)


@_fold.register
def _(body: ev.SessionEnded, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    return replace(model, ended=printable(body.reason), listening=False, waiting=())


@_fold.register
def _(body: ev.StateChanged, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    result = body.result
    over = result is not None and model.plan is not None and model.plan.stage == "thinking"
    model = replace(model, state=body.state, plan=None if over else model.plan)
    if result is not None:  # the turn is over: what still waits in it will not start
        model = replace(model, queue=tuple(_never_started(row, event.turn) for row in model.queue))
    if result is None or not result.message or result.outcome in ("clarify", "refused", "unheard", "interrupted"):
        return model
    text = printable(result.message)
    if model.conversation and model.conversation[-1].text == text:  # the robot has just said so
        return model
    return model.with_line(Line("done" if result.outcome == "done" else "problem", text))


def _never_started(row: Row, turn: str | None) -> Row:
    if row.phase != "queued" or row.turn != turn:
        return row
    return replace(row, phase="interrupted", message=strings.NOT_STARTED)


@_fold.register
def _(body: ev.TaskEnded, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    model = replace(model, cycle=model.cycle + 1, plan=None, queue=(), partial="", trail=())
    return model.with_line(Line("mark", strings.NEW_TASK, printable(body.reason)))


@_fold.register
def _(body: ev.InterruptRaised, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    plan = None if model.plan and model.plan.stage == "thinking" else model.plan
    model = replace(model, partial="", plan=plan)
    stopped = body.scope == "wake" and body.state in EXPRESSING
    ran = body.state not in REST or event.turn is not None  # a turn that waits for the robot has no state yet
    if stopped or (body.scope in ("stop", "interrupt", "release") and ran):
        return model.with_line(Line("mark", strings.STOPPED, printable(body.source)))
    if body.scope == "estop":  # it stays, whatever it stopped
        return model.with_line(Line("mark", strings.STOPPED, "estop"))
    if body.scope == "halted":
        return model.with_line(Line("mark", strings.HALTED))
    turn = next((turn for turn in model.turns.kept if turn.id == event.turn), None)
    if turn is None or not turn.text:
        return model
    by = strings.STOPPED_BY.format(reason=strings.REASONS[body.scope])
    return model.with_line(Line("lost", turn.text, _replaced(body.state) if body.scope == "replaced" else by))


@_fold.register
def _(body: ev.RequestsWaiting, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    if not body.requests:  # told by an engine that gives them no ids
        return replace(model, waiting=tuple(Waiting("", printable(text)) for text in body.texts))
    return replace(model, waiting=tuple(Waiting(one.request, printable(one.text)) for one in body.requests))


@_fold.register
def _(body: ev.RequestEnded, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    if event.turn is not None:  # what became a turn has said so there
        turn = next((turn for turn in model.turns.kept if turn.id == event.turn), None)
        if body.outcome in _WELL:
            message = turn.result.message if turn is not None and turn.result is not None else ""
            told = body.outcome != "clarify" and bool(message)
            return model.with_end(printable(body.text), message, done=True) if told else model
        halted = turn is not None and body.outcome == "failed" and _was_halted(turn)
        return _with_end(model, body, *_how_it_ended(body, turn), halted=halted)
    if body.outcome not in strings.LOST:
        return model
    if body.outcome == "dropped" and body.request == model.taken_back:  # it stands in the line
        return model
    note = strings.LOST[body.outcome]
    if body.by is not None and body.outcome == "interrupted":
        note = strings.LOST_BY.format(reason=strings.REASONS[body.by])
    return _with_end(model, body, "", note).with_line(Line("lost", printable(body.text), note))


def _how_it_ended(body: ev.RequestEnded, turn: Turn | None) -> tuple[str, str]:
    """How a request that became a turn ended: in the robot's words, or in ours."""
    if body.outcome == "replaced":
        return "", _replaced(turn.cut.state if turn is not None and turn.cut is not None else "ACTING")
    if turn is not None and turn.result is not None and turn.result.message:
        return turn.result.message, ""
    return "", strings.OUTCOMES.get(body.outcome, strings.OUTCOMES["failed"])


def _was_halted(turn: Turn) -> bool:
    """Whether the robot could not be moved in this turn, or stopped by itself."""
    stopped = turn.cut is not None and turn.cut.scope == "halted"
    return stopped or any(action.error_code == "robot_halted" for action in turn.actions)


def _replaced(state: ev.State) -> str:
    """How a request ended that a newer one replaced in this state."""
    return strings.REPLACED_PLANNING if state in ("DECIDING", "PLANNING") else strings.REPLACED


def _with_end(
    model: ConsoleModel, body: ev.RequestEnded, message: str, note: str, *, halted: bool = False
) -> ConsoleModel:
    return model.with_end(printable(body.text), message, note, body.by or "", halted=halted)


@_fold.register
def _(body: ev.QuestionEnded, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    if body.outcome == "answered":
        return model
    if model.plan is not None and model.plan.stage == "question":
        model = replace(model, plan=None)
    text, by = printable(body.text), body.by or ""
    if body.outcome == "declined":
        return model.with_end(text, note=strings.DECLINED, by=by).with_line(Line("lost", text, strings.DECLINED))
    note = strings.UNANSWERED if body.by is None else strings.QUESTION_WITHDRAWN.format(reason=strings.REASONS[body.by])
    if body.outcome == "replaced":
        note = strings.REPLACED_ASKED
    return model.with_end(text, note=note, by=by).with_line(Line("lost", text, note))


@_fold.register
def _(body: ev.OffersMade, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    return replace(model, offers=replace(body, no_undo=printable(body.no_undo)))


@_fold.register
def _(body: ev.WakeHeard, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    model = _without_problem(model)
    if body.source not in strings.WOKEN:  # a key or a command: whoever gave it knows
        return model
    where = [] if body.angle_deg is None else [strings.WOKEN_FROM.format(angle=body.angle_deg)]
    phrase = [f"“{body.phrase}”"] if body.phrase else []
    return model.with_log("info", "wake", ", ".join([strings.WOKEN[body.source], *phrase, *where]), event.turn)


@_fold.register
def _(body: ev.ListenStarted, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    return replace(model, listening=True, partial="")


@_fold.register
def _(body: ev.ListenEnded, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    return replace(model, listening=False, partial="" if body.reason == "cancelled" else model.partial)


@_fold.register
def _(body: ev.TranscriptPartial, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    return replace(model, partial=printable(body.text), stable=body.stable_words)


@_fold.register
def _(body: ev.TranscriptFinal, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    model = replace(_without_problem(model), partial="", plan=Plan("thinking", goal=printable(body.text)))
    return model.with_line(Line("you", printable(body.text), strings.HOW_SAID[body.source]))


@_fold.register
def _(body: ev.TranscriptRejected, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    text = printable(body.text) or strings.NOT_HEARD
    return replace(model, partial="").with_line(Line("unheard", text, strings.REJECTED[body.reason]))


@_fold.register
def _(body: ev.DecisionMade, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    goal = model.plan.goal if model.plan else ""
    return replace(model, plan=Plan("thinking", goal, tuple(map(printable, body.steps)), source=body.source))


@_fold.register
def _(body: ev.PlanMade, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    actions = tuple(call(action.name, action.args) for action in body.actions)
    steps = tuple(map(printable, body.steps))
    return replace(model, plan=Plan("made", printable(body.goal), steps, actions, body.source))


@_fold.register
def _(body: ev.PlanRejected, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    goal, reason = printable(body.text), printable(body.reason)
    plan = Plan("rejected", goal, message=reason, suggestions=tuple(map(printable, body.suggestions)))
    return replace(model, plan=plan)


@_fold.register
def _(body: ev.ClarificationAsked, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    goal = printable(body.about) or (model.plan.goal if model.plan else "")
    return replace(model, plan=Plan("question", goal, message=printable(body.question), open=body.leaves_open))


@_fold.register
def _(body: ev.RefusalMade, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    goal = printable(body.text) or (model.plan.goal if model.plan else "")
    return replace(model, plan=Plan("refused", goal, message=printable(body.reason)))


@_fold.register
def _(body: ev.ActionQueued, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    return model.with_row(Row(body.action, event.turn, body.index, in_words(body), "queued"))


@_fold.register
def _(body: ev.ActionStarted, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    row = Row(body.action, event.turn, body.index, in_words(body), "running", started=event.t, began=body.robot_t)
    return model.with_row(row)


@_fold.register
def _(body: ev.ActionProgress, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    row = _row(model, body.action)
    if row is None or row.phase != "running":  # late news of an action that has ended
        return model
    path = row.path if body.path is None else tuple(point for point in body.path if all(map(math.isfinite, point)))
    return model.with_row(replace(row, fraction=body.fraction, message=printable(body.message), path=path))


@_fold.register
def _(body: ev.ActionFinished, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    row = _row(model, body.action) or Row(body.action, event.turn, 0, call(body.name, body.args), "queued")
    message = "" if body.outcome == "ok" else printable(body.message)
    return model.with_row(
        replace(
            row, phase=body.outcome, duration_s=body.duration_s, started=None, fraction=None, message=message, path=()
        )
    )


@_fold.register
def _(body: ev.SpeechStarted, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    return model.with_line(Line("robot", printable(body.text)))


@_fold.register
def _(body: ev.SpeechEnded, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    last = model.conversation[-1] if model.conversation else None
    if body.heard == body.text or last is None or last.text != printable(body.text):
        return model
    return replace(model, conversation=(*model.conversation[:-1], replace(last, note=strings.CUT_OFF)))


@_fold.register
def _(body: ev.RobotStateView, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    here, trail = (body.pose.x, body.pose.y), model.trail
    if all(map(math.isfinite, here)) and (not trail or math.dist(trail[-1], here) >= TRAIL_STEP):
        trail = (*trail[1 - MAX_TRAIL :], here)
    return replace(model, robot=body, trail=trail)


@_fold.register
def _(body: ev.MotionPaused, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    return model.with_log("info", "stop", strings.MOTION_PAUSED.format(phrase=printable(body.phrase)), event.turn)


@_fold.register
def _(body: ev.MotionResumed, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    told = strings.MOTION_RESUMED.format(seconds=body.paused_s, number=body.false_pauses)
    return model.with_log("info", "stop", told, event.turn)


@_fold.register
def _(body: ev.PerceptionResult, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    return model.with_log("info", "camera", body.description, event.turn) if body.description else model


@_fold.register
def _(body: ev.Log, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    return model.with_log(body.level, body.source, body.message, event.turn)


@_fold.register
def _(body: ev.ErrorRaised, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    model = model.with_log("error", body.code, body.message, event.turn)
    if model.problem is not None and model.problem.fatal:  # what comes after the end explains less than the end
        return model
    return replace(model, problem=_problem(body))


@_fold.register
def _(body: ev.Timing, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    if body.stage != "paused":
        return model
    return model.with_line(Line("mark", strings.PAUSED.format(seconds=body.duration_s)))


@_fold.register
def _(body: ev.Ack, model: ConsoleModel, event: ev.Event) -> ConsoleModel:
    if body.ok or body.do == "say":  # how a request in words ended has a row that names it
        return model
    return model.with_log("warning", "session", body.message, event.turn)


def _problem(body: ev.ErrorRaised) -> Problem:
    return Problem(printable(body.message), printable(body.hint), fatal=body.fatal, code=body.code)


def _row(model: ConsoleModel, action: str) -> Row | None:
    return next((row for row in model.queue if row.action == action), None)


def _without_problem(model: ConsoleModel) -> ConsoleModel:
    return model if model.problem is None or model.problem.fatal else replace(model, problem=None)
