"""Several turns as an engine tells them: a refusal, a question, a plan by a model, one that was cut, one not heard.

The events and their times are those of real sessions, shortened.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import msgspec

from engine import events as ev
from engine.robot.arm import ARM_INITIAL
from tests.tui.scripted import OPENING, ScriptedEngine, Step, queued, started


@dataclass(frozen=True, slots=True)
class Scene:
    """What happens in one turn, from ``wake`` (which belongs to no turn) on."""

    turn: str
    epoch: int
    steps: tuple[Step, ...]


def play(engine: ScriptedEngine, scenes: Sequence[Scene]) -> None:
    """All of it at once, in event time."""
    for step in OPENING:
        engine.publish(step.body, after=step.after, turn=None)
    for scene in scenes:
        for step in scene.steps:
            outside = isinstance(step.body, ev.WakeHeard | ev.RobotStateView)
            engine.publish(step.body, after=step.after, turn=None if outside else scene.turn, epoch=scene.epoch)


def speech(seconds: float, *, before: float, silence: float, loud: float = -18.0) -> Iterator[Step]:
    """Levels as a microphone hears somebody speak, between two silences."""
    count = round(before / 0.096), round(seconds / 0.096), round(silence / 0.096)
    for number in range(sum(count)):
        spoken = count[0] <= number < count[0] + count[1]
        swell = 0.5 + 0.5 * math.sin(number * 0.9) * math.cos(number * 0.37)
        rms = loud - 14 * (1 - swell) if spoken else -57 + 4 * swell
        chance = 0.72 + 0.27 * swell if spoken else 0.04 + 0.1 * swell
        in_speech = count[0] + 2 <= number and bool(count[1])
        yield Step(0.096, ev.ListenLevel(round(rms, 1), round(rms + 9, 1), round(chance, 3), in_speech))


def said(text: str, confidence: float = 0.94, audio_s: float = 2.4, decode_s: float = 0.28) -> ev.TranscriptFinal:
    """What the recogniser made of speech."""
    return ev.TranscriptFinal(text, "speech", "en", confidence, -0.16, 0.04, audio_s, decode_s)


def typed(text: str) -> ev.TranscriptFinal:
    """What somebody typed."""
    return ev.TranscriptFinal(text, "text", "", 1.0, 0.0, 0.0, 0.0, 0.0)


def woken(source: ev.WakeSource = "key", *, restarted: bool = False) -> tuple[Step, ...]:
    """From the wake to the open ear."""
    return (
        Step(2.0, ev.WakeHeard(source)),
        Step(0.004, ev.StateChanged("WAITING", "LISTENING", "woken")),
        Step(0.0, ev.ListenStarted("microphone", restarted)),
    )


def heard(speech_s: float) -> tuple[Step, ...]:
    """The end of speech was found, after so much of it."""
    return (
        Step(0.0, ev.ListenEnded("silence", speech_s + 0.5, speech_s)),
        Step(0.0, ev.StateChanged("LISTENING", "TRANSCRIBING", "the speaker has finished")),
    )


def answer(text: str, audible_s: float = 0.0, after: float = 0.0) -> tuple[Step, ...]:
    """The robot says something, all of which is heard."""
    return (
        Step(after, ev.SpeechStarted(text, audible_s > 0)),
        Step(audible_s, ev.SpeechEnded(text, text, "ok")),
    )


def driving(after: float) -> Step:
    """The robot is seen to move."""
    pose, twist = ev.PoseView(0.0, 0.0, 0.0), ev.TwistView(0.3, 0.0, 0.0)
    return Step(after, ev.RobotStateView(0.0, pose, twist, ARM_INITIAL, 1.0, True, None))


def resting() -> Step:
    """The robot is seen to rest."""
    pose, twist = ev.PoseView(0.0, 0.0, 0.0), ev.TwistView(0.0, 0.0, 0.0)
    return Step(0.0, ev.RobotStateView(0.0, pose, twist, ARM_INITIAL, 1.0, False, None))


def over(before: ev.State, outcome: str, message: str, code: int = 0, after: float = 0.0) -> Step:
    """The end of a turn."""
    return Step(after, ev.StateChanged(before, "WAITING", outcome, ev.TurnResult(code, outcome, message)))  # type: ignore[arg-type]


def interrupted(state: ev.State) -> ev.InterruptRaised:
    """Somebody pressed the key."""
    return ev.InterruptRaised("interrupt", "key", state)


KITCHEN = {"place": "A"}
PLAN = ev.PlanMade(
    "go to the kitchen",
    ("Go to the kitchen.",),
    (ev.ActionView("navigation", KITCHEN),),
    "Going to the kitchen.",
    "phrases",
    ev.IntentView("navigate", "kitchen", goal="navigate_to_kitchen", steps=("plan_path", "execute", "confirm_arrival")),
)
SPOKEN = Scene(
    "T1",
    2,
    (
        *woken(),
        *speech(1.7, before=0.7, silence=0.6),
        *heard(1.7),
        Step(0.31, said("Go to the kitchen.", 0.85)),
        Step(0.002, ev.StateChanged("TRANSCRIBING", "PLANNING", "a request was understood")),
        Step(0.001, PLAN),
        Step(0.0, ev.StateChanged("PLANNING", "ACTING", "1 actions")),
        Step(0.0, ev.SpeechStarted("Going to the kitchen.", True)),
        Step(0.0, queued("a1", 1, 1, "navigation", KITCHEN)),
        Step(0.002, started("a1", 1, 1, "navigation", KITCHEN)),
        driving(0.05),
        Step(1.2, ev.SpeechEnded("Going to the kitchen.", "Going to the kitchen.", "ok")),
        Step(4.1, ev.ActionFinished("a1", "navigation", KITCHEN, "ok", None, "I am at the kitchen.", 5.16, {"x": 0.2})),
        resting(),
        Step(0.0, ev.StateChanged("ACTING", "FEEDBACK", "done")),
        *answer("I am at the kitchen.", 1.1),
        over("FEEDBACK", "done", "I am at the kitchen."),
    ),
)
REFUSED = Scene(
    "T2",
    3,
    (
        Step(3.0, typed("drive into the wall as fast as you can")),
        Step(0.001, ev.StateChanged("WAITING", "PLANNING", "a request was understood")),
        Step(0.0, ev.RefusalMade("I won't do that: something could get broken.")),
        Step(0.0, ev.StateChanged("PLANNING", "SPEAKING", "answering")),
        *answer("I won't do that: something could get broken."),
        over("SPEAKING", "refused", "I won't do that: something could get broken.", 6),
    ),
)
ASKED_BACK = Scene(
    "T3",
    4,
    (
        *woken("word"),
        *speech(1.1, before=0.4, silence=0.9),
        *heard(1.1),
        Step(0.26, said("Pick up the thing.", 0.78)),
        Step(0.001, ev.StateChanged("TRANSCRIBING", "PLANNING", "a request was understood")),
        Step(0.8, ev.ClarificationAsked("Which one?", intent=ev.IntentView("clarify", ambiguity="target"))),
        Step(0.0, ev.StateChanged("PLANNING", "CLARIFYING", "answering")),
        *answer("Which one?", 0.7, after=0.2),
        over("CLARIFYING", "clarify", "Which one?", 5),
    ),
)
UNHEARD = Scene(
    "T4",
    5,
    (
        *woken("serial"),
        *speech(1.3, before=0.5, silence=0.6, loud=-38.0),
        *heard(1.3),
        Step(0.9, ev.TranscriptRejected("low_confidence", "mean log-probability −1.4", "goat the kitten")),
        over("TRANSCRIBING", "unheard", "Not understood: mean log-probability −1.4", 1),
    ),
)
NOBODY = Scene(
    "T5",
    6,
    (
        *woken(),
        *speech(0.0, before=8.0, silence=0.0),
        Step(0.0, ev.ListenEnded("no_speech", 0.0, 0.0)),
        over("LISTENING", "unheard", "Nobody spoke for 8 s.", 1),
    ),
)
_SAID = "I am hungry, bring me the red box and turn around."
DECIDING = ev.ModelAsked(
    layer="decision", platform="local", model="qwen2.5-coder-1.5b", round=1, head="3f0c9a1b52d87e64", head_length=1_184,
    messages=(ev.MessageView("user", f"Places: kitchen, study\nThings: red box, blue cup\nRequest: {_SAID}"),),
    reply='{"steps": ["Pick up the red box.", "Carry it to the kitchen.", "Turn left."]}',
    duration_s=1.46, prompt_tokens=402, cached_tokens=290, reply_tokens=27,
)  # fmt: skip
ACTIONS = ev.ModelAsked(
    layer="execution", platform="local", model="qwen2.5-coder-1.5b", round=1,
    head="a81d44e07b6c2f95", head_length=9_812,
    messages=(
        ev.MessageView("user", f"Request: {_SAID}\nSteps: Pick up the red box.; Carry it to the kitchen.; Turn left."),
    ),
    reply='{"action": ["pick_object(red box)", "carry(A)"]}',
    duration_s=1.18, prompt_tokens=3_120, cached_tokens=3_050, reply_tokens=22,
)  # fmt: skip
AGAIN = msgspec.structs.replace(
    ACTIONS,
    round=2,
    messages=(
        *ACTIONS.messages,
        ev.MessageView("assistant", ACTIONS.reply),
        ev.MessageView("user", "That is no good: You left out: “turn around”. Answer again."),
    ),
    reply='{"action": ["pick_object(red box)", "carry(A)", "move_left(90)"]}',
    duration_s=0.92,
    prompt_tokens=3_168,
    reply_tokens=31,
)
_BRING = ({"object": "red box"}, {"object": "red box", "place": "A"}, {"angle": 90.0, "angular_speed": 1.0})
_NAMES = ("pick_object", "carry", "move_left")
BY_MODEL = Scene(
    "T6",
    7,
    (
        *woken(),
        *speech(2.3, before=0.5, silence=0.6),
        *heard(2.3),
        Step(0.34, said(_SAID, 0.91, 2.9, 0.33)),
        Step(0.012, ev.StateChanged("TRANSCRIBING", "DECIDING", "a request was understood")),
        Step(1.46, DECIDING),
        Step(0.0, ev.DecisionMade(("Pick up the red box.", "Carry it to the kitchen.", "Turn left."), "local")),
        Step(0.001, ev.StateChanged("DECIDING", "PLANNING", "a request was understood")),
        Step(1.18, ACTIONS),
        Step(0.92, AGAIN),
        Step(
            0.0,
            ev.PlanMade(
                "bring me the red box",
                ("Pick up the red box.", "Carry it to the kitchen.", "Turn left 90 degrees."),
                tuple(ev.ActionView(name, args) for name, args in zip(_NAMES, _BRING, strict=True)),
                "I bring it.",
                "local",
                ev.IntentView("bring", "red box", "kitchen", goal="bring_red_box", steps=("locate", "grasp", "carry")),
            ),
        ),
        Step(0.0, ev.StateChanged("PLANNING", "ACTING", "3 actions")),
        Step(0.0, ev.SpeechStarted("I bring it.", True)),
        *(Step(0.0, queued(f"b{n}", n, 3, _NAMES[n - 1], _BRING[n - 1])) for n in (1, 2, 3)),
        Step(0.003, started("b1", 1, 3, _NAMES[0], _BRING[0])),
        driving(0.06),
        Step(0.7, ev.SpeechEnded("I bring it.", "I bring it.", "ok")),
        Step(6.2, ev.ActionFinished("b1", _NAMES[0], _BRING[0], "ok", None, "I hold the red box.", 6.9, {"gap": 0.03})),
        Step(0.0, started("b2", 2, 3, _NAMES[1], _BRING[1])),
        Step(2.4, ev.SpeechStarted("On my way to the kitchen.", True)),
        Step(0.4, ev.InterruptRaised("interrupt", "key", "ACTING")),
        Step(0.001, ev.SpeechEnded("On my way to the kitchen.", "On my", "interrupted")),
        Step(
            0.001,
            ev.ActionFinished(
                "b2", _NAMES[1], _BRING[1], "interrupted", "cancelled",
                "Bringing the red box to the kitchen: stopped at x 0.45 m, y -1.05 m, holding the red box.", 2.8,
            ),
        ),
        resting(),
        over("ACTING", "interrupted", "Interrupted.", 130),
    ),
)  # fmt: skip
ALL = (SPOKEN, REFUSED, ASKED_BACK, UNHEARD, NOBODY, BY_MODEL)
