"""The microphone through a real sound server: found, lost, found again, and judged."""

from __future__ import annotations

import asyncio
import json
import subprocess
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import psutil
import pytest

from engine.audio.gain import TARGET_DB
from engine.audio.microphone import Lost, Microphone
from engine.audio.source import Frame
from engine.errors import DeviceError, ExitCode
from tests.audio.server import SoundServer
from tests.children import children
from tests.e2e.sayso import command, environment

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
LIMIT_S = 30

pytestmark = pytest.mark.audio


@pytest.fixture(autouse=True)
def _here(server: SoundServer, monkeypatch: pytest.MonkeyPatch) -> None:
    """This process, and what it starts, uses the test's own sound server."""
    for name, value in server.environment.items():
        monkeypatch.setenv(name, value)


@asynccontextmanager
async def within(seconds: float = LIMIT_S) -> AsyncIterator[None]:
    async with asyncio.timeout(seconds):
        yield


def recorders() -> list[psutil.Process]:
    return children("engine.audio.recorder")


async def until_recording() -> None:
    """Wait for a recorder to be there."""
    while True:
        if recorders():
            return
        await asyncio.sleep(0.001)  # no kernel tells of somebody's child


def loudest(frames: list[Frame]) -> int:
    return int(np.abs(np.concatenate([frame.samples for frame in frames]).astype(np.int32)).max())


async def until_loud(microphone: Microphone) -> None:
    """Read until somebody speaks."""
    async for frame in microphone:
        if loudest([frame]) > 3000:
            return


@pytest.mark.parametrize("device", [None, "pulse", 0], ids=["default", "name", "index"])
def test_what_is_said_arrives(server: SoundServer, device: str | int | None) -> None:
    async def scenario() -> None:
        async with within(), Microphone(device) as microphone:
            assert microphone.name.startswith("microphone (")
            speaking = asyncio.create_task(asyncio.to_thread(server.play, SPEECH / "stop.wav"))
            await until_loud(microphone)
            await speaking
            assert microphone.overruns == 0
        assert recorders() == []

    asyncio.run(scenario())


def test_a_microphone_that_is_not_there_is_named_with_those_that_are() -> None:
    async def scenario() -> None:
        async with Microphone("Blue Yeti"):
            pass

    with pytest.raises(Lost, match="no microphone 'Blue Yeti'") as caught:
        asyncio.run(scenario())
    assert "pulse" in caught.value.hint
    assert not caught.value.for_good
    assert recorders() == []


def test_a_lost_microphone_is_an_error_and_another_one_waits_until_it_is_back(server: SoundServer) -> None:
    async def scenario() -> None:
        async with within():
            async with Microphone() as microphone:
                await anext(microphone)
                server.kill()
                with pytest.raises(DeviceError, match="is gone") as caught:
                    async for _ in microphone:
                        pass
                assert "keeps looking for it" in caught.value.hint
            patient = Microphone(patient=True)
            finding = asyncio.create_task(patient.__aenter__())
            await until_recording()
            assert not finding.done()
            await asyncio.to_thread(server.start)
            await finding
            await anext(patient)
            await patient.__aexit__(None, None, None)
        assert recorders() == []

    asyncio.run(scenario())


def test_waiting_for_a_microphone_can_be_given_up(server: SoundServer) -> None:
    async def scenario() -> None:
        server.kill()
        async with within():
            finding = asyncio.create_task(Microphone(patient=True).__aenter__())
            await until_recording()
            finding.cancel()
            await asyncio.gather(finding, return_exceptions=True)
        assert recorders() == []

    asyncio.run(scenario())


def test_a_recorder_that_dies_or_hangs_is_an_error_that_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    async def scenario() -> None:
        for blow, words in ((psutil.Process.kill, "killed by SIGKILL"), (psutil.Process.suspend, "hangs")):
            async with within(), Microphone() as microphone:
                await anext(microphone)
                blow(recorders()[0])
                # Only the wait for one that hangs is shortened: its start takes as long as a busy machine needs.
                with monkeypatch.context() as patch:
                    patch.setattr("engine.audio.microphone.ANSWER_S", 1.0)
                    with pytest.raises(DeviceError, match=words):
                        async for _ in microphone:
                            pass
            assert recorders() == []

    asyncio.run(scenario())


# sayso doctor --mic


def test_the_doctor_says_by_how_much_a_faint_microphone_is_too_quiet(server: SoundServer, tmp_path: Path) -> None:
    argv = command("doctor", "--mic", "--json")
    with subprocess.Popen(
        argv, env=environment(tmp_path), text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        try:
            assert process.stderr is not None
            assert "say “go to the kitchen” now" in process.stderr.readline()
            server.play(SPEECH / "go_to_the_kitchen.wav", volume=0.4)
            out, _ = process.communicate(timeout=LIMIT_S)
        finally:
            process.kill()
    found = json.loads(out)
    assert found["verdict"] == "too quiet"
    assert f"audio.gain_db to {found['gain_db']:g}" in found["advice"]
    assert found["speech_db"] + found["gain_db"] == pytest.approx(TARGET_DB, abs=1)
    assert len(found["levels"]) == len(found["voiced"]) == 94
    assert process.returncode == ExitCode.FAILED
