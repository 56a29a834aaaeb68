"""A wake module on a serial line, through the whole engine: bytes on a terminal in, the robot listens."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.e2e.engine import Engine, engine
from tests.wake_module import AI_VOICE_WAKE, WakeModule, ring_wake

pytestmark = pytest.mark.model


def until_listening_to(running: Engine, module: WakeModule) -> None:
    """Wait until the module is open, which may have been said while something else was waited for."""

    def told(event: dict[str, Any]) -> bool:
        body = event["body"]
        return event["kind"] == "log" and body["source"] == "wake" and str(module.path) in body["message"]

    if not any(told(event) for event in running.seen):
        running.until("log", lambda body: told({"kind": "log", "body": body}))


def test_a_wake_module_wakes_and_is_found_again_after_it_was_unplugged(tmp_path: Path) -> None:
    with (
        WakeModule(tmp_path) as module,
        engine(tmp_path, "", "--set", f"wake.serial.port={module.path}") as running,
    ):
        running.until_loaded()
        until_listening_to(running, module)
        wake = ring_wake(137)
        module.say(*(wake[i : i + 1] for i in range(len(wake))))
        heard = running.until("wake.heard")
        assert (heard["source"], heard["phrase"], heard["angle_deg"]) == ("serial", "hello", 137)
        assert running.until("listen.started")["restarted"] is False
        module.say(AI_VOICE_WAKE)
        assert running.until("wake.heard")["angle_deg"] is None
        assert running.until("listen.started")["restarted"] is True

        module.unplug()
        gone = running.until("log", lambda body: body["level"] == "warning")
        assert gone["source"] == "wake"
        assert "was unplugged" in gone["message"]
        module.plug()
        running.until("log", lambda body: body["source"] == "wake" and body["message"].startswith("ready"))
        module.say(AI_VOICE_WAKE)
        running.until("wake.heard", lambda body: body["source"] == "serial")
        running.until("listen.started")
        running.send(do="quit")
        events = running.rest()
    warnings = [event["body"] for event in events if event["kind"] == "log" and event["body"]["level"] == "warning"]
    assert warnings == [gone], "one line about it"


def test_a_wake_stops_a_robot_in_mid_drive_and_it_listens(tmp_path: Path) -> None:
    with (
        WakeModule(tmp_path) as module,
        engine(tmp_path, "", "--set", f"wake.serial.port={module.path}") as running,
    ):
        running.until_loaded()
        until_listening_to(running, module)
        running.send(do="say", text="go to the kitchen")
        running.until("robot.state", lambda body: body["moving"])
        module.say(b"\xaa\x55\x01\x00\xfb" + b"$B00" + b"\xaa\x55\x04\x00\xfb")  # a greeting, half a wake, more volume
        module.say(AI_VOICE_WAKE)
        assert running.until("wake.heard")["source"] == "serial"
        finished = running.until("action.finished")
        assert (finished["outcome"], finished["error_code"]) == ("interrupted", "cancelled")
        running.until("listen.started")
        running.send(do="quit")
        assert [event["kind"] for event in running.rest()].count("wake.heard") == 1
