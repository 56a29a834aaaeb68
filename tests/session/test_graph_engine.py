"""A whole engine in a ROS graph: the simulated robot drives for a peer, stops for one, and hears the sound of one."""

from __future__ import annotations

import json
import queue
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile

from config import load
from engine.commands import Quit, Say
from engine.engine import Engine
from engine.events import ActionProgress, Event
from engine.parts.loading import Sound
from engine.ros.door import Message
from tests.session.graph import Client, Hand

LIMIT_S = 60


class Peer(Hand):
    """A door in the hand of a test that runs in another thread than the engine."""

    def __init__(self) -> None:
        super().__init__(echoes=False)
        self.came: queue.SimpleQueue[tuple[str, str]] = queue.SimpleQueue()

    def publish(self, topic: str, type: str, message: Message, *, every: bool = False) -> None:
        self.came.put((topic, message["data"]))

    def next(self, topic: str, kind: str = "") -> Any:
        """The next text on a topic; JSON of this kind, if any."""
        while True:
            name, data = self.came.get(timeout=LIMIT_S)
            if name == topic and (not kind or json.loads(data)["kind"] == kind):
                return json.loads(data) if data[0] == "{" else data


@contextmanager
def running(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *overrides: str) -> Iterator[tuple[Engine, Peer]]:
    peer = Peer()
    monkeypatch.setenv("SAYSO_STATE_DIR", str(tmp_path))
    monkeypatch.setattr("engine.parts.graph.open_door", lambda address: peer)
    told = ("ros.door=rclpy", "voice.when=never", "voice.sounds=false", "wake.words=[]", "robot.speed=max", *overrides)
    engine = Engine(load(overrides=told, environ={}), mode="engine", sound=Sound("none"))
    joined: queue.SimpleQueue[Event] = queue.SimpleQueue()
    engine.subscribe(joined.put)
    engine.start()
    try:
        while not any(part.name == "ros" and part.state == "ready" for part in engine.status()):
            joined.get(timeout=LIMIT_S)
        yield engine, peer
    finally:
        engine.send(Quit())
        assert engine.join(LIMIT_S)
        assert peer.closed
        assert not [part for part in engine.status() if part.name == "ros" and part.state != "ready"]


def test_the_simulated_robot_drives_for_a_peer_and_stops_for_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with running(tmp_path, monkeypatch) as (engine, peer):
        peer.say("move forward 40 cm")
        turn = peer.next("/outcome", "turn")
        assert (turn["outcome"], turn["actions"][0]["call"]) == ("done", "move_forward(0.4 m)")
        moves: queue.SimpleQueue[Event] = queue.SimpleQueue()
        engine.subscribe(lambda event: moves.put(event) if isinstance(event.body, ActionProgress) else None)
        client = Client({"plan": '["navigation(A)", "arm_nod()"]'})
        assert peer.works["/execute_plan"].begin(client)
        moves.get(timeout=LIMIT_S)
        peer.send("/stop", {})
        turn = peer.next("/outcome", "turn")
        assert turn["outcome"] == "interrupted"
        assert turn["never_started"] == ["arm_nod()"]
        ((how, result),) = client.ended
        assert (how, result["outcome"]) == ("aborted", "interrupted")
        assert client.told[0]["message"].startswith("executing step 1 of 2: navigation(")
        engine.send(Say("nod"))
        assert peer.next("/outcome", "turn")["outcome"] == "done"


@pytest.mark.model
def test_what_is_said_in_the_sound_of_a_peer_is_done_and_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with running(tmp_path, monkeypatch, "robot.speed=real") as (engine, peer):
        del engine
        speech, rate = soundfile.read(str(files("assets") / "speech" / "raise_your_arm.wav"), dtype="int16")
        sound = np.concatenate((np.zeros(rate, np.int16), speech, np.zeros(3 * rate, np.int16)))
        for start in range(0, len(sound), 1600):
            peer.say(sound[start : start + 1600].tolist(), "/audio_input/raw")
        assert peer.next("/speech_to_text/command") == "Raise your arm."
        assert peer.next("/outcome", "turn")["outcome"] == "done"
