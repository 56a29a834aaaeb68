"""Records what a real engine tells in a whole task, for tests of the console: ``python -m tests.tui.record``.

Words are spoken into it, a model on loopback plans in two layers, an action fails, the robot asks back, and is
interrupted. Of what it tells everything is kept as it came, but poses only so often, and no process ids. Made again
when events have changed in what they mean; fields that were added need no new one.
"""

from __future__ import annotations

import base64
import json
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from engine.audio.wav import read_wav
from tests.e2e.engine import Engine, engine
from tests.e2e.platforms import configuration, platforms
from tests.tui.replay import RECORDINGS

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
RATE = 16_000
PIECE = RATE // 10
POSES_S = 0.5
"""Between two poses that are kept; the last before it rests is kept, too."""

ODD = "it would be lovely to see you roll over to the kitchen, have a look, and tidy away what you hold"
STEPS = {"steps": ["go to the kitchen", "look around", "put down what is held"]}
ROUNDS = (
    {"action": ["navigation(kitchen)", "seewhat()", "putdown()"], "response": "On my way."},
    {"action": ["report_pose()", "finishtask()"], "response": "I am in the kitchen, and my gripper is empty."},
    {"action": [], "response": "", "clarification": "Which thing do you mean?"},
    {"action": ["pick_object(red box)", "finishtask()"], "response": "I will fetch the red box."},
)


def perform(running: Engine) -> None:
    """The task, from the first word to the end of the session."""

    def turn_over() -> None:
        running.until("state.changed", lambda body: body["result"])

    def say(text: str) -> None:
        running.send(do="say", text=text)

    running.until_loaded()
    speak(running, "move_forward_one_metre")
    turn_over()
    running.send(do="end_task")
    turn_over()  # the arm is at home
    say(ODD)
    turn_over()
    say("pick up the thing")
    turn_over()
    say("the red box")
    running.until("robot.state", lambda body: body["twist"]["vx"] > 0.2)
    running.send(do="interrupt")
    turn_over()
    say("drive into the wall as fast as you can")
    turn_over()
    running.send(do="wake")  # and nobody says anything
    turn_over()
    running.send(do="quit")
    running.rest()


def speak(running: Engine, name: str) -> None:
    """Wake it and say this, no faster than one can speak."""
    noise = np.random.default_rng(0)
    room, pause = (noise.normal(0, 5, round(seconds * RATE)) for seconds in (0.4, 2.0))
    sound = np.concatenate((room, read_wav(SPEECH / f"{name}.wav"), pause)).astype("<i2")
    running.send(do="wake")
    began = time.monotonic()
    for at in range(0, len(sound), PIECE):
        running.send(do="audio", pcm=base64.b64encode(sound[at : at + PIECE].tobytes()).decode())
        time.sleep(max(0.0, began + (at + PIECE) / RATE - time.monotonic()))


def kept(events: Iterable[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """What a screen needs to show the same."""
    posed, waiting = float("-inf"), None
    for event in events:
        body = event["body"]
        if event["kind"] == "ack" and body["ok"]:
            continue
        if event["kind"] == "session.started":
            body["pid"] = 0
        if event["kind"] == "robot.state" and body["moving"] and event["t"] < posed + POSES_S:
            waiting = event
            continue
        if event["kind"] == "robot.state":
            posed, waiting = event["t"], None
        elif waiting is not None and event["kind"] == "action.finished":
            yield waiting
            waiting = None
        yield event


def main() -> None:
    with (
        tempfile.TemporaryDirectory() as folder,
        platforms("openai", decides=60.0, acts=60.0) as (decides, acts),
    ):
        option, file, environ = configuration(Path(folder), decision=[decides], execution=[acts])
        environ |= {"SAYSO_ROBOT__SPEED": "real"}
        del environ["SAYSO_CACHE_DIR"]  # the recogniser's model is there
        decides.answers(STEPS)
        acts.answers(*ROUNDS)
        with engine(Path(folder), "", option, file, environ=environ) as running:
            perform(running)
            told = running.seen
    lines = "".join(json.dumps(event, ensure_ascii=False, separators=(",", ":")) + "\n" for event in kept(told))
    secrets = (decides.key, acts.key, folder, str(Path.home()))
    assert not any(secret in lines for secret in secrets), "a recording tells no secrets and no folders"
    recording = RECORDINGS / "whole_task.jsonl"
    recording.write_text(lines, encoding="utf-8")
    print(f"{recording.name}: {lines.count(chr(10))} of {len(told)} events, {len(lines) // 1024} KiB")


if __name__ == "__main__":
    main()
