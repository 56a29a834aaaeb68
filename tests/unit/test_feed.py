"""The door for somebody else's microphone, and those who knock."""

from __future__ import annotations

import asyncio
import errno
import os
import socket
import stat
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import numpy as np
import pytest

from engine.audio import feed as f
from engine.audio.feed import Door, feed, peer_uid
from engine.audio.pipe import GuestSource
from engine.audio.source import FRAME_SAMPLES
from engine.errors import AudioFormatError, DeviceError, SaysoError, StorageError
from tests import virtual_time

LIMIT_S = 20
SOUND = np.arange(20 * FRAME_SAMPLES, dtype=np.int16)


class Guests(asyncio.Queue[GuestSource]):
    """Who was let in."""


class Feeder:
    """``sayso mic`` in a thread, and the pipe that its sound comes from."""

    def __init__(self, path: Path, source: str = "ssh microphone") -> None:
        reading, self.pipe = os.pipe()
        self.heard_by = 0
        self._reading = reading
        self.work = asyncio.ensure_future(asyncio.to_thread(feed, path, reading, source, self._welcome))

    def _welcome(self, pid: int) -> None:
        self.heard_by = pid

    def say(self, data: bytes) -> None:
        os.write(self.pipe, data)

    def end(self) -> None:
        """The sound ends."""
        if self.pipe >= 0:
            os.close(self.pipe)
            self.pipe = -1

    async def error(self) -> SaysoError:
        """What it ends with."""
        with pytest.raises(SaysoError) as caught:
            await self.work
        return caught.value

    async def close(self) -> None:
        self.end()
        await asyncio.gather(self.work, return_exceptions=True)
        os.close(self._reading)


@asynccontextmanager
async def feeder(path: Path, source: str = "ssh microphone") -> AsyncIterator[Feeder]:
    made = Feeder(path, source)
    try:
        yield made
    finally:
        await made.close()


def at(path: Path, scenario: Callable[[Guests], Awaitable[None]]) -> None:
    """Run a scenario at an open door."""

    async def run() -> None:
        guests = Guests()
        async with asyncio.timeout(LIMIT_S), Door(path, guests.put_nowait):
            await scenario(guests)

    asyncio.run(run())


def test_the_kernel_tells_whose_the_other_end_of_a_local_socket_is() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        assert peer_uid(ours) == os.geteuid()


def test_a_guest_of_another_user_is_not_let_in(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def scenario(guests: Guests) -> None:
        monkeypatch.setattr(f, "_is_ours", lambda link: False)
        reader, writer = await asyncio.open_unix_connection(str(path))
        assert await reader.read() == b"", "no welcome"
        writer.close()
        assert guests.empty()

    at(path, scenario)


def test_sound_is_not_handed_to_another_user(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def scenario(guests: Guests) -> None:
        monkeypatch.setattr(f, "peer_uid", lambda link: 65_534)
        async with feeder(path) as somebody:
            assert "another user" in str(await somebody.error())

    at(path, scenario)


def test_a_lock_that_is_a_link_is_not_followed(path: Path, tmp_path: Path) -> None:
    path.parent.mkdir(mode=0o700)
    path.with_suffix(".lock").symlink_to(tmp_path / "elsewhere")

    async def scenario(guests: Guests) -> None:
        raise AssertionError("there is no door")

    with pytest.raises(StorageError, match=r"mic\.sock"):
        at(path, scenario)
    assert not (tmp_path / "elsewhere").exists()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "state" / "mic.sock"


async def heard(guest: GuestSource) -> np.ndarray[tuple[int], np.dtype[np.int16]]:
    async with guest:
        return np.concatenate([np.empty(0, np.int16), *[frame.samples async for frame in guest]])


def test_a_guest_is_heard_from_the_first_sample_to_the_last(path: Path) -> None:
    async def scenario(guests: Guests) -> None:
        async with feeder(path) as somebody:
            somebody.say(SOUND.tobytes()[:1001])  # in the middle of a sample
            guest = await guests.get()
            somebody.say(SOUND.tobytes()[1001:])
            somebody.end()
            assert np.array_equal(await heard(guest), SOUND)
            await somebody.work
            assert guest.name == "ssh microphone"
            assert somebody.heard_by == os.getpid()

    at(path, scenario)


def test_nobody_else_may_open_the_door_and_it_goes_with_the_house(path: Path) -> None:
    async def scenario(guests: Guests) -> None:
        found = await asyncio.to_thread(path.stat)
        assert stat.S_IMODE(found.st_mode) == 0o600
        assert stat.S_ISSOCK(found.st_mode)

    at(path, scenario)
    assert not path.exists()
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700


def test_the_door_is_private_from_its_first_moment_where_a_socket_has_no_mode(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    born: list[int] = []
    chmod = Path.chmod

    def refuse(fd: int, mode: int) -> None:
        raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))  # as on macOS

    def change(file: Path, mode: int) -> None:
        born.append(stat.S_IMODE(file.stat().st_mode))
        chmod(file, mode)

    monkeypatch.setattr(os, "fchmod", refuse)
    monkeypatch.setattr(Path, "chmod", change)
    before = os.umask(0o022)
    try:
        at(path, lambda guests: scenario_of_one_guest(path, guests))
        assert os.umask(before) == 0o022
    finally:
        os.umask(before)
    assert born == [0o700]


def test_there_is_one_guest_at_a_time_and_the_next_one_is_told_who_it_is(path: Path) -> None:
    async def scenario(guests: Guests) -> None:
        async with feeder(path, "ssh microphone") as first:
            guest = await guests.get()
            async with feeder(path, "piped microphone") as second:
                error = await second.error()
                assert isinstance(error, DeviceError)
                assert "hears somebody else already (ssh microphone)" in error.message
                assert str(os.getpid()) in error.message
            first.end()
            await first.work
            await heard(guest)
        async with feeder(path, "piped microphone"):
            assert (await guests.get()).name == "piped microphone"

    at(path, scenario)


def test_a_guest_whose_connection_hangs_gives_way(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(f, "IDLE_S", 0.0)

    async def scenario(guests: Guests) -> None:
        async with feeder(path) as laptop, feeder(path, "piped microphone") as pipe:
            hanging, new = await guests.get(), await guests.get()  # in whichever order their threads came
            feeders = {"ssh microphone": laptop, "piped microphone": pipe}
            assert {hanging.name, new.name} == feeders.keys()
            async with hanging:
                with pytest.raises(StopAsyncIteration):
                    await anext(hanging)
            assert "hears somebody else now" in (await feeders[hanging.name].error()).message

    at(path, scenario)


@asynccontextmanager
async def knocking(path: Path, greeting: bytes) -> AsyncIterator[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
    """A guest who has been welcomed, without a thread: those know no virtual time."""
    reader, writer = await asyncio.open_unix_connection(path)
    writer.write(greeting + b"\n")
    assert b'"refusal":""' in await reader.readline()
    try:
        yield reader, writer
    finally:
        writer.close()


@pytest.mark.parametrize("greeting", [b'{"source":"microphone"}', b'{"source":"microphone","pauses":false}'])
def test_a_guest_from_whom_nothing_comes_any_more_is_let_go(path: Path, greeting: bytes) -> None:
    async def scenario() -> None:
        guests = Guests()
        async with Door(path, guests.put_nowait), knocking(path, greeting) as (reader, writer):
            guest = await guests.get()
            for piece in np.split(SOUND, 2):
                await asyncio.sleep(0.9 * f.SILENT_S)
                writer.write(piece.tobytes())
            assert np.array_equal(await heard(guest), SOUND)
            assert b"no sound has come for 30 s" in await reader.read()
            assert asyncio.get_running_loop().time() == pytest.approx(2.8 * f.SILENT_S)
            async with knocking(path, greeting):  # the door is open for the next one
                await guests.get()

    virtual_time.run(scenario())


def test_a_satellite_may_be_silent_for_hours(path: Path) -> None:
    async def scenario() -> None:
        guests = Guests()
        async with (
            Door(path, guests.put_nowait),
            knocking(path, b'{"source":"satellite","pauses":true}') as (_, writer),
        ):
            guest = await guests.get()
            await asyncio.sleep(3600)
            writer.write(SOUND.tobytes())
            writer.write_eof()
            assert np.array_equal(await heard(guest), SOUND)

    virtual_time.run(scenario())


def test_a_guest_who_is_let_go_is_told_why(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def scenario(guests: Guests) -> None:
        async with feeder(path) as somebody:
            guest = await guests.get()
            async with guest:
                somebody.say(SOUND.tobytes())
                await anext(guest)
                monkeypatch.setattr(f, "SILENT_S", 0.05)
                somebody.say(SOUND.tobytes())
                error = await somebody.error()
            assert isinstance(error, DeviceError)
            assert error.message.endswith("does not hear this any more: no sound has come for 0.05 s.")

    at(path, scenario)


def test_a_sayso_that_ends_before_it_was_greeted_has_ended(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ours, theirs = socket.socketpair()
    theirs.close()
    monkeypatch.setattr(f, "_connected", lambda path: ours)  # it goes between the connection and the first word

    async def scenario() -> None:
        async with feeder(path) as somebody:
            assert "has ended" in (await somebody.error()).message

    asyncio.run(scenario())


def test_without_a_sayso_the_guest_is_told_to_start_one(path: Path) -> None:
    async def scenario() -> None:
        async with feeder(path) as somebody:
            assert "No sayso" in (await somebody.error()).message

    asyncio.run(scenario())
    left = socket.socket(socket.AF_UNIX)
    path.parent.mkdir()
    left.bind(str(path))
    left.close()  # as one that was killed leaves it
    asyncio.run(scenario())
    at(path, lambda guests: scenario_of_one_guest(path, guests))


async def scenario_of_one_guest(path: Path, guests: Guests) -> None:
    async with feeder(path):
        await guests.get()


def test_a_second_sayso_has_no_door_until_the_first_has_gone(path: Path) -> None:
    async def scenario(guests: Guests) -> None:
        with pytest.raises(DeviceError, match="Another sayso"):
            async with Door(path, guests.put_nowait):
                pass
        await scenario_of_one_guest(path, guests)

    at(path, scenario)
    at(path, lambda guests: scenario_of_one_guest(path, guests))


def test_a_sayso_that_ends_lets_its_guest_go(path: Path) -> None:
    async def scenario() -> None:
        guests = Guests()
        async with asyncio.timeout(LIMIT_S):
            async with Door(path, guests.put_nowait):
                somebody = Feeder(path)
                await guests.get()
            assert "has ended" in (await somebody.error()).message
            await somebody.close()

    asyncio.run(scenario())


def test_a_folder_with_a_very_long_name_is_no_hindrance(tmp_path: Path) -> None:
    path = tmp_path / ("a-very-long-name" * 8) / "mic.sock"
    at(path, lambda guests: scenario_of_one_guest(path, guests))
    assert not path.exists()


def test_a_folder_that_cannot_be_written_is_an_error_with_its_name(tmp_path: Path) -> None:
    (tmp_path / "state").write_text("")  # a file where the folder should be

    async def scenario(guests: Guests) -> None: ...

    with pytest.raises(StorageError, match="state"):
        at(tmp_path / "state" / "mic.sock", scenario)


def test_a_wav_file_is_no_raw_sound(path: Path) -> None:
    async def scenario(guests: Guests) -> None:
        async with feeder(path) as somebody:
            somebody.say(b"RIFF\x00\x00\x00\x00WAVE")
            error = await somebody.error()
            assert isinstance(error, AudioFormatError)
            assert "-t raw" in error.hint

    at(path, scenario)


@pytest.mark.parametrize(
    "words", [b"hello\n", b"", b'{"source": 5}\n', b"x" * 100_000], ids=["text", "nothing", "number", "long"]
)
def test_whoever_does_not_greet_is_no_guest(path: Path, words: bytes) -> None:
    async def scenario(guests: Guests) -> None:
        reader, writer = await asyncio.open_unix_connection(path)
        writer.write(words)
        writer.write_eof()
        with suppress(ConnectionResetError):
            assert await reader.read() == b""
        writer.close()
        await scenario_of_one_guest(path, guests)

    at(path, scenario)


def test_a_name_is_shown_and_draws_nothing(path: Path) -> None:
    async def scenario(guests: Guests) -> None:
        async with feeder(path, "\x1b[2Jlaptop\n" + "y" * 100):
            guest = await guests.get()
            assert guest.name.startswith("[2Jlaptop")
            assert len(guest.name) < 70

    at(path, scenario)
