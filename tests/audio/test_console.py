"""The console at a real (virtual) microphone: it hears, loses its ears, goes on by keyboard, and hears again."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.audio.server import SoundServer
from tests.e2e.terminal import TO_THE_PANES, Terminal, console
from tests.e2e.test_console import driving, last

SPEECH = Path(__file__).parents[2] / "assets" / "speech"

pytestmark = pytest.mark.audio


@pytest.fixture(autouse=True)
def _here(server: SoundServer, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in server.environment.items():
        monkeypatch.setenv(name, value)


def about_the_microphone(terminal: Terminal) -> list[str]:
    """The lines about it so far."""
    logged = (event["body"] for event in terminal.events() if event["kind"] in ("log", "error"))
    return [body["message"] for body in logged if "microphone" in (body.get("source", ""), *body["message"].split())]


def ask(terminal: Terminal, server: SoundServer, recording: str) -> None:
    """Wake it with the key and say something."""
    before = len(terminal.events())
    terminal.type(" ")
    terminal.until(lambda: any(event["kind"] == "listen.started" for event in terminal.events()[before:]))
    server.play(SPEECH / recording)


@pytest.mark.model
def test_the_robot_drives_by_voice_and_survives_the_loss_of_its_microphone(server: SoundServer, tmp_path: Path) -> None:
    with console(state=tmp_path) as terminal:
        terminal.until(lambda: "microphone (default)" in terminal.text)
        terminal.until(lambda: any(e["body"].get("source") == "recogniser" for e in terminal.events()))
        ask(terminal, server, "go_to_the_kitchen.wav")
        terminal.until(lambda: "kitchen" in last(terminal, "transcript.final").get("text", "").lower())
        terminal.until(lambda: driving(terminal))
        server.play(SPEECH / "stop.wav")  # overheard, without a wake
        terminal.until(lambda: last(terminal, "interrupt.raised").get("scope") == "stop")
        terminal.until(lambda: last(terminal, "robot.state").get("moving") is False)
        assert about_the_microphone(terminal) == ["ready: microphone (default)"]

        server.kill()
        terminal.until(lambda: "No microphone" in terminal.text)
        terminal.type("/")
        terminal.type("turn left 90 degrees\r")
        terminal.until(lambda: last(terminal, "action.finished").get("outcome") == "ok")
        gone = about_the_microphone(terminal)[1:]
        assert len(gone) == 1, gone
        assert gone[0].startswith("The microphone (default) is gone.")

        server.start()
        # ALSA's default is PulseAudio if that ran when it was asked; the next moment it is called by its name
        back = (["ready: microphone (default)"], ["ready: microphone (pulse)"])
        terminal.until(lambda: about_the_microphone(terminal)[2:] in back)
        ask(terminal, server, "go_to_the_kitchen.wav")
        terminal.until(lambda: driving(terminal))
        terminal.type("\x1b")
        terminal.until(lambda: last(terminal, "robot.state").get("moving") is False)
        terminal.type(TO_THE_PANES + "q")
        assert terminal.wait() == 0
