"""The voice of an engine: there is one when it is ready, and one clear line where there is none."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from config import ConfigError
from config import load as load_settings
from config.schema import Settings
from engine.audio.clocked import ClockedOutput
from engine.audio.player import Player
from engine.audio.portaudio import Unusable
from engine.engine import Engine
from engine.errors import DeviceError, ModelError, SaysoError
from engine.events import Log
from engine.handle import PartStatus
from engine.parts import loading
from engine.parts import voice as voice_part
from engine.parts.loading import Sound
from engine.parts.part import Part
from engine.parts.voice import VoicePart
from engine.speaking import SpokenVoice
from engine.tts import piper
from engine.tts.synthesis import VoiceLost
from tests import virtual_time
from tests.unit.test_speaking import Tones
from tui.commands.models import needed
from tui.doctor.diagnosis import _voice
from tui.doctor.finding import Finding

LIMIT_S = 30.0


class NoDevice(ClockedOutput):
    async def open(self, pull: Any, lost: Any, *, patient: bool = False) -> None:
        if patient:
            await asyncio.Event().wait()
        raise DeviceError("There is no loudspeaker.", hint="Answers are shown without one.")


class Mouth:
    """A voice part, and what it said about itself."""

    def __init__(self, settings: Settings, output: ClockedOutput) -> None:
        self.statuses: list[PartStatus] = []
        self.logs: list[Log] = []
        self.player = Player(output)
        self.voice = SpokenVoice(self.player)
        self.settled = asyncio.Event()
        settle = self.voice.settle

        def noted(synthesiser: Any) -> None:
            settle(synthesiser)
            self.settled.set()

        self.voice.settle = noted  # type: ignore[method-assign]
        self.part = VoicePart(settings, self.player, self.voice, self._make, self.logs.append)  # type: ignore[arg-type]
        self.parts = 0

    def _make(self) -> Part[str]:
        self.parts += 1
        return Part("voice", self.statuses.append)


@asynccontextmanager
async def kept(
    monkeypatch: pytest.MonkeyPatch,
    made: Tones | SaysoError,
    *overrides: str,
    output: Callable[[], ClockedOutput] = ClockedOutput,
) -> AsyncIterator[Mouth]:
    def make(settings: Settings, tell: object) -> Tones:
        del settings, tell
        if isinstance(made, SaysoError):
            raise made
        return made

    monkeypatch.setattr(voice_part, "make_synthesiser", make)
    monkeypatch.setattr(piper, "is_installed", lambda: "models.fetch=true" in overrides)
    settings = load_settings(overrides=overrides, environ={}, user_folder=Path("no-such-folder"))
    mouth = Mouth(settings, output())
    keeping = asyncio.create_task(mouth.part.keep())
    try:
        async with asyncio.timeout(LIMIT_S):
            await mouth.settled.wait()
        yield mouth
    finally:
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)
        assert not mouth.player.usable


def test_a_voice_that_loads_is_a_part_that_is_ready_and_is_closed_with_the_engine(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def scenario() -> None:
        tones = Tones()
        async with kept(monkeypatch, tones) as mouth:
            assert [status.state for status in mouth.statuses] == ["ready"]
            assert mouth.statuses[0].detail == "tones"
            assert mouth.voice.audible
        assert tones.closed
        assert not mouth.voice.audible

    asyncio.run(scenario())


@pytest.mark.parametrize("wanting", ["voice", "loudspeaker"])
def test_where_nothing_was_asked_for_a_machine_without_one_says_so_in_one_line_and_has_no_such_part(
    monkeypatch: pytest.MonkeyPatch, wanting: str
) -> None:
    async def scenario() -> None:
        made = (
            ModelError("There is no voice on this machine.", hint="Install piper.") if wanting == "voice" else Tones()
        )
        output = NoDevice if wanting == "loudspeaker" else ClockedOutput
        async with kept(monkeypatch, made, output=output) as mouth:
            assert mouth.parts == 0
            [line] = mouth.logs
            assert line.level == "info"
            assert line.message.startswith("Answers are shown, not spoken. There is no")
            assert not mouth.voice.audible
            heard: list[str] = []
            await mouth.voice.say("An answer.", heard.append)
            assert heard == ["An answer."]

    asyncio.run(scenario())


@pytest.mark.parametrize("wanting", ["voice", "loudspeaker"])
def test_what_was_asked_for_by_name_is_a_part_that_is_missing(monkeypatch: pytest.MonkeyPatch, wanting: str) -> None:
    async def scenario() -> None:
        made = ModelError("espeak-ng is not installed.", hint="Install it.") if wanting == "voice" else Tones()
        output = NoDevice if wanting == "loudspeaker" else ClockedOutput
        async with kept(monkeypatch, made, "voice.backend=espeak", output=output) as mouth:
            [status] = mouth.statuses
            assert status.state == "missing"
            assert status.detail in (
                "espeak-ng is not installed. Install it.",
                "There is no loudspeaker. Answers are shown without one.",
            )
            assert mouth.logs == []

    asyncio.run(scenario())


def test_a_voice_that_cannot_be_loaded_is_missing_and_not_left_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    class Damaged(Tones):
        async def load(self) -> None:
            raise ModelError("The voice cannot be loaded: it is damaged.")

    async def scenario() -> None:
        damaged = Damaged()
        async with kept(monkeypatch, damaged) as mouth:
            assert [status.state for status in mouth.statuses] == ["missing"]
            assert damaged.closed
            assert not mouth.voice.audible

    asyncio.run(scenario())


def test_a_voice_that_is_lost_while_it_loads_is_tried_again_for_an_answer_but_not_for_each(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Frail(Tones):
        loads = 0

        async def load(self) -> None:
            self.loads += 1
            if self.loads <= 2:
                raise VoiceLost("The voice process was killed by SIGKILL.")

    async def scenario() -> None:
        frail = Frail()
        async with kept(monkeypatch, frail) as mouth:
            said: list[str] = []

            async def answered(text: str, *, spoken: bool) -> None:
                assert mouth.voice.audible == spoken
                await mouth.voice.say(text, said.append)
                assert said[-1] == text
                await asyncio.sleep(0.1)

            assert frail.closed
            assert "It is tried again when there is something to say." in mouth.statuses[0].detail
            for loads in (1, 2):
                await answered("too soon", spoken=False)
                assert frail.loads == loads
                await asyncio.sleep(voice_part.PAUSE_S)
                assert frail.loads == loads, "nobody needs it"
                await answered("shown", spoken=False)
                assert frail.loads == loads + 1
            assert [status.state for status in mouth.statuses] == ["missing", "missing", "ready"]
            await answered("spoken", spoken=True)
            assert frail.made == ["spoken"]

    virtual_time.run(scenario())


def test_a_voice_that_is_damaged_is_not_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    class Damaged(Tones):
        loads = 0

        async def load(self) -> None:
            self.loads += 1
            raise ModelError("The voice cannot be loaded: it is damaged.")

    async def scenario() -> None:
        damaged = Damaged()
        async with kept(monkeypatch, damaged) as mouth:
            await asyncio.sleep(2 * voice_part.PAUSE_S)
            await mouth.voice.say("shown", lambda text: None)
            await asyncio.sleep(1)
            assert damaged.loads == 1

    virtual_time.run(scenario())


def test_answers_that_are_never_spoken_need_no_voice_but_the_sounds_have_their_loudspeaker(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def scenario() -> None:
        async with kept(monkeypatch, ModelError("nobody looks"), "voice.when=never") as mouth:
            assert mouth.parts == 0
            assert mouth.logs == []
            assert mouth.player.usable
            assert not mouth.voice.audible

    asyncio.run(scenario())


def test_a_model_that_cannot_be_fetched_leaves_a_part_that_says_what_to_run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    class Offline:
        def __init__(self, store: object, name: str, tell: Callable[[str], None]) -> None:
            tell(f"fetching {name}")

        async def done(self) -> Path:
            raise ModelError("The network is down.")

    async def scenario() -> None:
        missing = ModelError("The model piper-joe is not downloaded.", hint="Run: sayso models pull piper-joe")
        wanted = ("models.fetch=true", f"models.folder={tmp_path}")
        async with kept(monkeypatch, missing, *wanted) as mouth:
            [status] = mouth.statuses
            assert status.state == "missing"
            assert "sayso models pull piper-joe" in status.detail

    monkeypatch.setattr(voice_part, "Pull", Offline)
    asyncio.run(scenario())


class Plug(ClockedOutput):
    """A loudspeaker that can be pulled out and plugged in."""

    name = "loudspeaker (test)"
    lost: Callable[[SaysoError], None]

    def __init__(self, *, there: bool = True) -> None:
        super().__init__()
        self.there = asyncio.Event()
        self.sought = asyncio.Event()  # somebody waits for it
        if there:
            self.there.set()

    async def open(self, pull: Any, lost: Any, *, patient: bool = False) -> None:
        if patient:
            self.sought.set()
            await self.there.wait()
        if not self.there.is_set():
            raise DeviceError("There is no loudspeaker.", hint="Answers are shown without one.")
        self.sought.clear()
        self.lost = lost
        await super().open(pull, lost)

    async def pull_out(self) -> None:
        self.there.clear()
        self.lost(DeviceError("The loudspeaker is gone."))
        async with asyncio.timeout(LIMIT_S):
            await self.sought.wait()


def test_a_loudspeaker_that_goes_is_looked_for_and_told_once_when_it_goes_and_once_when_it_is_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def scenario() -> None:
        plug = Plug()
        async with kept(monkeypatch, Tones(), output=lambda: plug) as mouth:
            for times in (1, 2):
                await plug.pull_out()
                assert not mouth.voice.audible
                mouth.settled.clear()
                plug.there.set()
                async with asyncio.timeout(LIMIT_S):
                    await mouth.settled.wait()
                assert mouth.voice.audible, "nobody has to say anything first"
                assert [status.state for status in mouth.statuses] == ["ready", *(["missing", "ready"] * times)]
            assert mouth.statuses[-1].detail == "tones, loudspeaker (test)"
            assert mouth.logs == []

    asyncio.run(scenario())


def test_a_loudspeaker_that_goes_while_the_voice_loads_is_missed_until_it_is_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plug = Plug()

    class LosesIt(Tones):
        async def load(self) -> None:
            plug.there.clear()
            plug.lost(DeviceError("The loudspeaker is gone."))
            await asyncio.sleep(0)

    async def scenario() -> None:
        async with kept(monkeypatch, LosesIt(), output=lambda: plug) as mouth:
            assert not mouth.voice.audible
            assert mouth.statuses[-1].state == "missing"
            mouth.settled.clear()
            plug.there.set()
            async with asyncio.timeout(LIMIT_S):
                await mouth.settled.wait()
            assert mouth.voice.audible
            assert mouth.statuses[-1].state == "ready"

    asyncio.run(scenario())


def test_a_loudspeaker_that_is_plugged_in_later_brings_the_voice(monkeypatch: pytest.MonkeyPatch) -> None:
    async def scenario() -> None:
        plug, tones = Plug(there=False), Tones()
        async with kept(monkeypatch, tones, output=lambda: plug) as mouth:
            assert mouth.parts == 0
            async with asyncio.timeout(LIMIT_S):
                await plug.sought.wait()
            mouth.settled.clear()
            plug.there.set()
            async with asyncio.timeout(LIMIT_S):
                await mouth.settled.wait()
            assert mouth.voice.audible
            assert [log.message for log in mouth.logs] == [
                "Answers are shown, not spoken. There is no loudspeaker. Answers are shown without one.",
                "There is a loudspeaker (test) now.",
            ]
            assert [status.state for status in mouth.statuses] == ["ready"]

    asyncio.run(scenario())


def test_without_a_sound_library_nothing_is_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    class Deaf(ClockedOutput):
        sought = 0

        async def open(self, pull: Any, lost: Any, *, patient: bool = False) -> None:
            Deaf.sought += 1
            raise Unusable("There is no loudspeaker: the PortAudio library is missing.")

    async def scenario() -> None:
        async with kept(monkeypatch, Tones(), output=Deaf) as mouth:
            assert not mouth.voice.audible
        assert Deaf.sought == 1

    asyncio.run(scenario())


def test_where_only_sounds_are_wanted_a_lost_loudspeaker_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    async def scenario() -> None:
        plug = Plug()
        async with kept(monkeypatch, Tones(), "voice.when=never", output=lambda: plug) as mouth:
            await plug.pull_out()
            mouth.settled.clear()
            plug.there.set()
            async with asyncio.timeout(LIMIT_S):
                await mouth.settled.wait()
            assert [log.message for log in mouth.logs] == [
                "The loudspeaker is gone.",
                "The loudspeaker (test) is back.",
            ]
            assert mouth.parts == 0

    asyncio.run(scenario())


def test_nothing_is_spoken_where_sound_comes_as_commands_unless_somebody_asks_for_it() -> None:
    def heard(kind: Any, *overrides: str) -> bool:
        settings = load_settings(overrides=overrides, environ={}, user_folder=Path("no-such-folder"))
        return loading.is_to_be_heard(settings.voice, Sound(kind))

    assert heard("auto")
    assert not heard("none")
    assert heard("none", "voice.device=3")
    assert heard("none", "voice.when=always")


# Stopping


def test_whoever_stops_everything_stops_the_robot_first_and_then_the_voice_in_the_same_thread() -> None:
    engine = Engine(load_settings(environ={}, user_folder=Path("no-such-folder")), mode="ask", sound=Sound("none"))
    stopped: list[tuple[str, int, int]] = []
    for part, name in ((engine._robot, "robot"), (engine._player, "voice")):
        part.stop = lambda epoch, name=name: stopped.append((name, epoch, threading.get_ident()))  # type: ignore
    epoch = engine._epoch.advance()
    assert stopped == [("robot", epoch, threading.get_ident()), ("voice", epoch, threading.get_ident())]


# The doctor, and the models


def findings(monkeypatch: pytest.MonkeyPatch, made: Tones | SaysoError, *overrides: str, trouble: str = "") -> Finding:
    def make(settings: Settings, tell: Callable[[str], None]) -> Tones:
        del settings
        if isinstance(made, SaysoError):
            raise made
        if trouble:
            tell(trouble)
        return made

    monkeypatch.setattr(loading, "make_synthesiser", make)
    return _voice(load_settings(overrides=overrides, environ={}, user_folder=Path("no-such-folder")))


def test_the_doctor_names_the_voice_and_what_a_better_one_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    both = findings(monkeypatch, Tones(name="piper (joe), espeak-ng"))
    assert (both.state, both.detail, both.fix) == ("ok", "piper (joe), espeak-ng", "")
    assert "apt install espeak-ng" in findings(monkeypatch, Tones(name="piper (joe)")).detail
    half = findings(monkeypatch, Tones(name="piper (joe)"), trouble="Its data are missing.")
    assert (half.state, half.detail) == ("limited", "piper (joe). Its data are missing.")
    monkeypatch.setattr(piper, "is_installed", lambda: False)
    poor = findings(monkeypatch, Tones(name="espeak-ng"))
    assert (poor.state, poor.fix) == ("limited", "pip install 'sayso[voice]'")
    monkeypatch.setattr(piper, "is_installed", lambda: True)
    assert findings(monkeypatch, Tones(name="espeak-ng")).fix == "sayso models pull piper-joe"
    none = findings(monkeypatch, ModelError("There is no voice on this machine.", hint="Install piper."))
    assert (none.state, none.fix, none.needed) == ("missing", "Install piper.", False)
    assert findings(monkeypatch, ModelError("nobody looks"), "voice.when=never").state == "ok"


def test_the_voice_is_among_the_models_that_are_needed_where_there_is_piper(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def is_needed(*overrides: str) -> bool:
        folder = f"models.folder={tmp_path}"
        settings = load_settings(overrides=(folder, *overrides), environ={}, user_folder=Path("no-such-folder"))
        return "piper-joe" in needed(loading.model_store(settings), settings)

    monkeypatch.setattr(piper, "is_installed", lambda: False)
    assert not is_needed()
    monkeypatch.setattr(piper, "is_installed", lambda: True)
    assert is_needed()
    assert not is_needed("voice.when=never")
    assert not is_needed("voice.backend=espeak")
    assert not is_needed("voice.model=/home/me/en.onnx")


# Settings


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("voice.when=sometimes", "spoken | always | never"),
        ("voice.backend=festival", "auto | piper | espeak | openai"),
        ("voice.volume=2", "voice.volume"),
        ("voice.volum=1", "did you mean 'voice.volume'"),
        ("voice.backend=openai", "voice.platform names none"),
        ("voice.platform=dify_decision", ""),
    ],
)
def test_a_mistake_in_the_settings_of_the_voice_is_told_with_its_remedy(override: str, said: str) -> None:
    overrides = [override] if said else [override, "voice.backend=openai"]
    with pytest.raises(ConfigError) as error:
        load_settings(overrides=overrides, environ={}, user_folder=Path("no-such-folder"))
    assert (said or "dify_decision is none") in str(error.value)
    assert "voice." in str(error.value)
