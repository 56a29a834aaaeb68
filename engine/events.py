"""The vocabulary: everything that happens, as frozen facts.

An :class:`Event` is an envelope (when, which session, turn and epoch) around a *body*, one small struct per
kind. The same JSON goes to stdout, into recordings and over the network; ``docs`` for outside tools are the
docstrings here. Fields may be added to a body; none is renamed or removed while ``v`` stays 1, and readers
ignore fields and kinds they do not know.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Literal, TypeVar

import msgspec

from engine.errors import UsageError

VERSION = 1

Value = str | bool | int | float
"""An argument of an action, as it stands in JSON."""

Outcome = Literal["ok", "failed", "interrupted", "uncertain"]
State = Literal[
    "IDLE",
    "LISTENING",
    "TRANSCRIBING",
    "DECIDING",
    "PLANNING",
    "CLARIFYING",
    "SPEAKING",
    "ACTING",
    "FEEDBACK",
    "WAITING",
]
Scope = Literal[
    "stop", "estop", "release", "interrupt", "wake", "end_task", "replaced", "by_hand", "halted", "shutdown"
]  # fmt: skip
"""Kinds of interruption; ``engine.states`` says what each one does. ``halted``: the robot stopped by itself."""
WakeSource = Literal["key", "serial", "word", "speech", "command", "demo", "file"]
"""``speech``: somebody goes on whose turn was ended in the middle of a sentence, or begins where no wake is needed."""
PlanSource = Literal["phrases", "reader", "local", "openai", "dify", "direct"]
RequestOutcome = Literal[
    "done",
    "failed",
    "clarify",
    "refused",
    "interrupted",
    "timeout",
    "replaced",
    "dropped",
    "rejected",
    "left",
    "answer",
]
"""How a request in words ends; :class:`RequestEnded` says what each of them means."""
Layer = Literal["decision", "execution", "vision"]
"""What a large model is asked for: steps in words, actions, or what a picture shows."""


class Body(msgspec.Struct, frozen=True):
    """Base of all event bodies; ``kind`` is the event's name on the wire."""

    kind: ClassVar[str]


BODIES: dict[str, type[Body]] = {}
B = TypeVar("B", bound=type[Body])


def kind(name: str) -> Callable[[B], B]:
    """Register a body class under its wire name."""

    def register(cls: B) -> B:
        cls.kind = name
        BODIES[name] = cls
        return cls

    return register


# Parts of bodies


class ActionView(msgspec.Struct, frozen=True):
    """One action of a plan: a registered skill's name and its typed arguments by name."""

    name: str
    args: Mapping[str, Value]
    alongside: bool = False  # it starts together with the action before it


class PoseView(msgspec.Struct, frozen=True):
    """Pose on the floor, map frame."""

    x: float  # m
    y: float  # m
    yaw: float  # rad, counter-clockwise


class TwistView(msgspec.Struct, frozen=True):
    """Velocity in the robot's frame."""

    vx: float  # m/s, forward
    vy: float  # m/s, to the left
    wz: float  # rad/s, counter-clockwise


class MessageView(msgspec.Struct, frozen=True):
    """One message of those that a large model was sent."""

    role: Literal["system", "user", "assistant"]
    text: str  # a picture is told as [picture 160×120], px; what was too long says how much of it is missing


class IntentView(msgspec.Struct, frozen=True):
    """What was wanted, in the words of pipelines that expect an intent: made from the plan, or from the question."""

    action: str  # pick_up, place, bring, navigate, clean_room, …; without a plan respond, clarify, refuse or error
    target: str | None = None  # the thing, or the place of a journey
    secondary_location: str | None = None  # where the thing is brought or put
    ambiguity: str | None = None  # what is unclear: target, location, amount or request
    clarification_question: str | None = None
    goal: str = ""  # all of it in one word: pick_up_red_box
    steps: tuple[str, ...] = ()  # what skills go through: locate, navigate, grasp, lift


class TurnResult(msgspec.Struct, frozen=True):
    """How a turn ended, in words and as the process exit code it means (see ``errors.ExitCode``)."""

    exit_code: int
    outcome: Literal["done", "failed", "clarify", "refused", "interrupted", "timeout", "unheard"]
    message: str


class WaitingRequest(msgspec.Struct, frozen=True):
    """A request that waits until what runs has ended."""

    request: str  # its id, unique in the session: what ``drop`` and ``move`` go by
    text: str
    sent_as: str | None = None  # the id that its sender gave to the command


# Session


@kind("session.started")
class SessionStarted(Body, frozen=True):
    """First event of a session."""

    version: str
    mode: str
    robot: str
    pid: int


@kind("session.ended")
class SessionEnded(Body, frozen=True):
    """Last event of a session."""

    reason: str


@kind("state.changed")
class StateChanged(Body, frozen=True):
    """The session moved to another state. ``result`` is set by the change that ends a turn."""

    previous: State
    state: State
    reason: str
    result: TurnResult | None = None


@kind("task.ended")
class TaskEnded(Body, frozen=True):
    """A task cycle ended: history and arm are reset and a new cycle begins."""

    reason: str


@kind("interrupt.raised")
class InterruptRaised(Body, frozen=True):
    """Something was interrupted. The envelope's epoch is the new one."""

    scope: Scope
    source: str
    state: State


@kind("requests.waiting")
class RequestsWaiting(Body, frozen=True):
    """What was asked for and waits until the running turn has ended, next first; told whenever that changes."""

    texts: tuple[str, ...]
    requests: tuple[WaitingRequest, ...] = ()  # the same, with their ids


@kind("requests.dropped")
class RequestsDropped(Body, frozen=True):
    """An interruption came while these waited: none of them was begun, and none will be."""

    texts: tuple[str, ...]


@kind("request.ended")
class RequestEnded(Body, frozen=True):
    """A request in words has come to its end; each one does so exactly once. The envelope's turn is the one that it
    became, if any, with the outcome of that turn.

    ``replaced``: a newer request came in its place, before or while it was planned or done. ``dropped``: somebody took
    it out of what waited. ``rejected``: the robot was busy, and ``session.busy`` is ``reject``. ``left``: what it was
    to follow was not done. ``answer``: the robot had asked something, and took it for the answer."""

    request: str  # its id
    text: str
    outcome: RequestOutcome
    by: Scope | None = None  # what interrupted it
    sent_as: str | None = None  # the id that its sender gave to the command


@kind("question.ended")
class QuestionEnded(Body, frozen=True):
    """What the robot asked about a request is not open any more. The envelope's turn is the one that asked.

    ``answered``: what was said next is the answer. ``declined``: it says no, or is no order, and the request is given
    up. ``replaced``: another request came in its place.
    ``withdrawn``: it was interrupted, or what was said next asks for nothing; or it was not understood or named nothing
    here, for the second time: the first time that happens the question is put once more, and stays open."""

    text: str  # the request that it was asked about
    outcome: Literal["answered", "declined", "replaced", "withdrawn"]
    by: Scope | None = None  # what interrupted it


@kind("offers.made")
class OffersMade(Body, frozen=True):
    """What may be asked about the past in a word; told whenever that changes. Each is the turn that it is about, by its
    id, or None where it is not offered. "Continue" does what a stop cut off, "undo" goes back from what was done, and
    "again" does the plan once more."""

    resume: str | None = None
    undo: str | None = None
    again: str | None = None
    acted: str | None = None  # the turn in which something was done last
    no_undo: str = ""  # why that cannot be undone, for people


# Hearing


@kind("wake.heard")
class WakeHeard(Body, frozen=True):
    """Somebody wants the robot's attention."""

    source: WakeSource
    phrase: str = ""
    angle_deg: float | None = None  # direction of the speaker, when the module tells


@kind("listen.started")
class ListenStarted(Body, frozen=True):
    """The recording began."""

    source: str
    restarted: bool = False


@kind("listen.level")
class ListenLevel(Body, frozen=True):
    """Loudness and voice activity of the last stretch of sound, about ten times a second while listening."""

    rms_db: float  # dB relative to full scale
    peak_db: float  # dB relative to full scale
    speech_probability: float  # 0…1
    in_speech: bool  # the endpointer is inside an utterance


@kind("listen.ended")
class ListenEnded(Body, frozen=True):
    """The recording ended."""

    reason: Literal["silence", "max_length", "source_ended", "no_speech", "cancelled", "device_lost"]
    audio_s: float  # length of the utterance with pre-roll, s
    speech_s: float  # confirmed speech within it, s


@kind("transcript.partial")
class TranscriptPartial(Body, frozen=True):
    """Words so far; may still change."""

    text: str
    stable_words: int


@kind("transcript.final")
class TranscriptFinal(Body, frozen=True):
    """What was said (or typed, or overheard without a wake: ``source`` tells; only speech has all the figures)."""

    text: str
    source: Literal["speech", "text", "overheard"]
    language: str
    confidence: float  # 0…1, mean token probability; 1 for typed text
    avg_logprob: float
    no_speech_probability: float
    audio_s: float
    decode_s: float


@kind("transcript.rejected")
class TranscriptRejected(Body, frozen=True):
    """Sound that was not taken for a command, with the reason."""

    reason: Literal["no_speech", "low_confidence", "too_short", "empty", "late", "artefact"]
    detail: str
    text: str = ""


# Thinking


@kind("decision.made")
class DecisionMade(Body, frozen=True):
    """The decision layer's steps, in words."""

    steps: tuple[str, ...]
    source: PlanSource


@kind("meaning.read")
class MeaningRead(Body, frozen=True):
    """What a reader understood of a request: acts with their roles, each with the characters that it came from."""

    text: str
    reader: Literal["certain", "learned", "large"]
    confidence: float  # 0…1
    nodes: tuple[dict[str, Any], ...]  # as ``engine/understanding/meaning.py`` describes them


@kind("model.asked")
class ModelAsked(Body, frozen=True):
    """A call of a large model is over, whatever became of it. One that was broken off, or was answered when nobody
    waited any more, is told too and has no effect: it may come after its turn, whose id and epoch it carries."""

    layer: Layer
    platform: str  # as the configuration calls it
    round: int  # 1; 2 when an answer that was no good was given back
    head: str  # of the messages that many questions begin with, only this: the first 16 digits of a SHA-256…
    head_length: int  # …and their characters
    messages: tuple[MessageView, ...]  # the rest, oldest first; Dify keeps a conversation and gets the new ones only
    reply: str  # as it came, or what had come until it broke off
    duration_s: float  # s, with the loading of a local model that had to be loaded first
    model: str = ""  # that the platform runs, where the configuration names it
    error_code: str | None = None
    error: str = ""
    prompt_tokens: int = 0  # 0 where the service does not say
    cached_tokens: int = 0  # of the prompt, those that needed no computing
    reply_tokens: int = 0
    cut_off: bool = False  # the reply reached its greatest length
    cancelled: bool = False  # it was broken off before it was answered


@kind("plan.made")
class PlanMade(Body, frozen=True):
    """A validated plan."""

    goal: str
    steps: tuple[str, ...]
    actions: tuple[ActionView, ...]
    response: str
    source: PlanSource
    intent: IntentView | None = None  # the same for programs that expect an intent


@kind("plan.rejected")
class PlanRejected(Body, frozen=True):
    """No plan came of it; nothing moves."""

    text: str
    reason: str
    code: str
    suggestions: tuple[str, ...] = ()


@kind("clarification.asked")
class ClarificationAsked(Body, frozen=True):
    """The request is ambiguous; the next utterance answers this question. Or it was no order, and the robot asks what
    it shall do: that leaves nothing open."""

    question: str
    about: str = ""
    intent: IntentView | None = None  # what is known of the request, and what is unclear about it
    leaves_open: bool = True  # an answer completes the request


@kind("refusal.made")
class RefusalMade(Body, frozen=True):
    """The request was refused by the safety rules."""

    reason: str
    text: str = ""


# Acting


@kind("action.queued")
class ActionQueued(Body, frozen=True):
    """An action of a validated plan waits for its turn."""

    action: str  # id, unique in the session
    index: int  # 1-based position in the plan
    total: int
    name: str
    args: Mapping[str, Value]
    told: str = ""  # what is to be done, for people, in English: "Go to the kitchen"


@kind("action.started")
class ActionStarted(Body, frozen=True):
    """An action began; exactly one ``action.finished`` follows."""

    action: str
    index: int
    total: int
    name: str
    args: Mapping[str, Value]
    told: str = ""  # as when it was queued
    robot_t: float | None = None  # s, robot time, by which its duration is measured as well; None: nobody knows


@kind("action.progress")
class ActionProgress(Body, frozen=True):
    """A running action says how far it is."""

    action: str
    name: str
    fraction: float | None  # 0…1, None when it cannot be known
    message: str = ""
    path: tuple[tuple[float, float], ...] | None = None  # planned way ahead, map frame, m; None: unchanged


@kind("action.finished")
class ActionFinished(Body, frozen=True):
    """A started action ended, exactly once. Actions that were queued and never started have no such event: the
    change of state that ends the turn ends them."""

    action: str
    name: str
    args: Mapping[str, Value]
    outcome: Outcome
    error_code: str | None
    message: str
    duration_s: float  # s, robot time
    data: Mapping[str, Value] | None = None  # what was found out, e.g. a pose


@kind("speech.started")
class SpeechStarted(Body, frozen=True):
    """The robot answers. ``audible`` is False in text mode: the answer is shown, not played."""

    text: str
    audible: bool


@kind("speech.ended")
class SpeechEnded(Body, frozen=True):
    """The answer ended; ``heard`` is what was played (or shown) of it."""

    text: str
    heard: str
    outcome: Outcome


# The robot


@kind("robot.state")
class RobotStateView(Body, frozen=True):
    """Where the robot is and what it does; several times a second while it moves, else once when it rests."""

    robot_t: float  # s, the robot's own clock
    pose: PoseView
    twist: TwistView
    arm: tuple[float, ...]  # rad, joints from base to wrist
    gripper: float  # 0 closed … 1 open
    moving: bool
    blocked: str | None  # what holds the robot back, if anything
    estop: bool = False  # the emergency stop is pressed: nothing moves until it is released
    volts: float | None = None  # of the battery, where something measures it


@kind("motion.paused")
class MotionPaused(Body, frozen=True):
    """Somebody may have said stop: the robot rests until that is known. What follows is ``interrupt.raised`` when they
    did (or nobody could tell), else ``motion.resumed``."""

    source: Literal["word"]
    phrase: str  # what was spotted


@kind("motion.resumed")
class MotionResumed(Body, frozen=True):
    """Nobody had said stop: a false pause."""

    reason: Literal["not_a_stop"]
    paused_s: float  # s
    false_pauses: int  # in this session, with this one


@kind("camera.frame")
class CameraFrame(Body, frozen=True):
    """A picture was taken; its pixels travel by other means."""

    width: int
    height: int
    path: str | None = None


@kind("perception.result")
class PerceptionResult(Body, frozen=True):
    """What was seen."""

    description: str
    objects: tuple[Mapping[str, Value], ...] = ()


@kind("person.asked")
class PersonAsked(Body, frozen=True):
    """The robot has asked somebody something, and waits for the answer: what is typed now is that."""

    question: str


@kind("person.answered")
class PersonAnswered(Body, frozen=True):
    """What was answered; empty where nobody has answered in time."""

    question: str
    answer: str
    source: Literal["typed", "company", "heard", "nobody"]


@kind("person.acted")
class PersonActed(Body, frozen=True):
    """What one of the people of a simulation has done: heard something, said something, come along."""

    who: str
    does: str
    text: str
    robot_t: float  # s


# Everything else


@kind("log")
class Log(Body, frozen=True):
    """A line for people."""

    level: Literal["debug", "info", "warning", "error"]
    source: str
    message: str


@kind("error")
class ErrorRaised(Body, frozen=True):
    """Something failed; ``hint`` says what to do."""

    code: str
    message: str
    hint: str = ""
    fatal: bool = False


@kind("timing")
class Timing(Body, frozen=True):
    """How long a stage took."""

    stage: str
    duration_s: float


@kind("ack")
class Ack(Body, frozen=True):
    """The answer to one command in (see ``engine.commands``); ``id`` repeats the command's own."""

    do: str
    ok: bool
    message: str = ""
    id: str | None = None
    snapshot: Mapping[str, Any] | None = None


class Event(msgspec.Struct, frozen=True):
    """One thing that happened."""

    seq: int  # 1, 2, 3… within the session
    t: float  # s since the session started
    wall: str  # ISO 8601 UTC
    session: str  # ULID
    turn: str | None  # ULID
    epoch: int
    body: Body

    @property
    def kind(self) -> str:
        return self.body.kind


def to_json(event: Event) -> bytes:
    """One JSON object, no newline. Text that is not Unicode (a raw byte from a command line) becomes ``?``."""
    try:
        return msgspec.json.encode(to_dict(event))
    except UnicodeEncodeError:
        return json.dumps(to_dict(event), ensure_ascii=False, separators=(",", ":")).encode("utf-8", "replace")


def to_dict(event: Event) -> dict[str, Any]:
    """The event as JSON-ready builtins, in wire order."""
    return {
        "v": VERSION,
        "seq": event.seq,
        "t": round(event.t, 6),
        "wall": event.wall,
        "session": event.session,
        "turn": event.turn,
        "epoch": event.epoch,
        "kind": event.body.kind,
        "body": msgspec.to_builtins(event.body),
    }


class _Envelope(msgspec.Struct):
    v: int
    seq: int
    t: float
    wall: str
    session: str
    turn: str | None
    epoch: int
    kind: str
    body: msgspec.Raw


def from_json(line: bytes | str) -> Event:
    """Read one event back. Raises :class:`UsageError` for anything that is not one."""
    try:
        raw = msgspec.json.decode(line, type=_Envelope)
        if raw.v != VERSION:
            raise UsageError(f"Not a version {VERSION} event: {line[:80]!r}")
        if raw.kind not in BODIES:
            raise UsageError(f"Not an event: the kind {raw.kind!r} is unknown in {line[:80]!r}")
        body = msgspec.json.decode(raw.body, type=BODIES[raw.kind])
    except (msgspec.MsgspecError, UnicodeError, RecursionError) as error:
        raise UsageError(f"Not an event: {error} in {line[:80]!r}") from error
    return Event(raw.seq, raw.t, raw.wall, raw.session, raw.turn, raw.epoch, body)
