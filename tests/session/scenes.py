"""The ten states of a session, each reached for real: somebody wakes it, asks, and time passes.

A scene also says what is on its way in its state, and how that ends if it is left alone.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from engine import events
from engine.commands import Say, Wake
from engine.events import State
from engine.robot.arm import ARM_UP
from tests.session.conversation import Conversation

STAGE_S = 8.0
"""How long thinking and decoding take."""


# Ways into the states


async def rest(talk: Conversation) -> None:
    """In IDLE there is nothing behind it, in WAITING a raised arm."""


async def listen(talk: Conversation) -> None:
    talk.send(Wake())
    await talk.until(events.ListenStarted)
    await talk.pass_time(1.0)


async def decode(talk: Conversation) -> None:
    await listen(talk)
    talk.hearing.decode_s = STAGE_S
    assert talk.hearing.speak("beep")
    await talk.until_state("TRANSCRIBING")
    await talk.pass_time(1.0)


async def decide(talk: Conversation) -> None:
    talk.planner.decide_s = STAGE_S
    talk.send(Say("beep"))
    await talk.until_state("DECIDING")
    await talk.pass_time(1.0)


async def plan(talk: Conversation) -> None:
    talk.planner.plan_s = STAGE_S
    talk.send(Say("beep"))
    await talk.until_state("PLANNING")
    await talk.pass_time(1.0)


async def ask_back(talk: Conversation) -> None:
    talk.send(Say("go forward"))
    await talk.until_state("CLARIFYING")
    await talk.pass_time(1.0)


async def answer(talk: Conversation) -> None:
    talk.send(Say("go to the moon"))
    await talk.until_state("SPEAKING")
    await talk.pass_time(1.0)


async def drive(talk: Conversation) -> None:
    talk.send(Say("go forward 2 metres then beep"))
    await talk.until_state("ACTING")
    await talk.pass_time(1.0)
    assert not talk.robot.state().twist.is_zero


async def report(talk: Conversation) -> None:
    talk.send(Say("go forward 20 centimetres"))
    await talk.until_state("FEEDBACK")
    await talk.pass_time(0.8)


@dataclass(frozen=True, slots=True)
class Scene:
    """How a session comes into a state, and what is on its way there."""

    reach: Callable[[Conversation], Awaitable[None]]
    heard: str = ""
    """What could be heard until then of the sentence that is being said."""
    done: tuple[str, ...] = ()
    """Actions of the turn that have ended by then."""
    running: str = ""
    """The action that runs."""
    never: str = ""
    """The action that would come next."""
    path: tuple[State, ...] = ()
    """The states that follow where the turn is left alone."""
    outcome: str = ""
    """How it ends then."""


SCENES: dict[State, Scene] = {
    "IDLE": Scene(rest),
    "LISTENING": Scene(listen, path=("WAITING",), outcome="unheard"),
    "TRANSCRIBING": Scene(decode, path=("PLANNING", "ACTING", "FEEDBACK", "WAITING"), outcome="done"),
    "DECIDING": Scene(decide, path=("PLANNING", "ACTING", "FEEDBACK", "WAITING"), outcome="done"),
    "PLANNING": Scene(plan, path=("ACTING", "FEEDBACK", "WAITING"), outcome="done"),
    "CLARIFYING": Scene(ask_back, heard="How far? Say for", path=("WAITING",), outcome="clarify"),
    "SPEAKING": Scene(answer, heard="I don't know a", path=("WAITING",), outcome="failed"),
    "ACTING": Scene(
        drive,
        heard="Driving 2 metres",
        running="move_forward",
        never="beep(0.2)",
        path=("FEEDBACK", "WAITING"),
        outcome="done",
    ),
    "FEEDBACK": Scene(report, heard="Moved 0.20 m", done=("move_forward",), path=("WAITING",), outcome="done"),
    "WAITING": Scene(rest),
}


async def prepare(talk: Conversation, state: State) -> None:
    """Bring the session into ``state``, its arm raised."""
    if state == "IDLE":
        talk.robot.move_arm(ARM_UP, talk.epoch.current)
    else:
        talk.send(Say("raise your arm"))
        assert (await talk.result()).outcome == "done"
    await SCENES[state].reach(talk)
    assert talk.session.state == state
    talk.planner.decide_s = talk.planner.plan_s = 0.0  # for what is asked from now on
