"""Where sound comes from."""

from __future__ import annotations

import asyncio
import itertools
import os
import subprocess
import sys
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import soundfile
from hypothesis import given
from hypothesis import strategies as st

from engine.audio.pipe import PcmSource, PushSource
from engine.audio.simulated import SimulatedMicrophone
from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE, Frame, FrameQueue, Framer, Samples, Source
from engine.audio.wav import WavSource, read_wav
from engine.errors import AudioFormatError, ExitCode
from tests.virtual_time import run

SPEECH = Path(__file__).parents[2] / "assets" / "speech"


def tone(seconds: float, rate: int = RATE, hertz: float = 440.0) -> np.ndarray[Any, np.dtype[np.float32]]:
    return (0.5 * np.sin(2 * np.pi * hertz * np.arange(round(seconds * rate)) / rate)).astype(np.float32)


async def collected(source: Source) -> list[Frame]:
    async with source:
        return [frame async for frame in source]


def joined(frames: list[Frame]) -> Samples:
    return np.concatenate([frame.samples for frame in frames])


def dominant(sound: Samples) -> float:
    """The strongest frequency, Hz."""
    spectrum = np.abs(np.fft.rfft(sound.astype(np.float64) * np.hanning(len(sound))))
    return float(np.argmax(spectrum) * RATE / len(sound))


# Frames


@given(st.lists(st.integers(0, 2000), max_size=20))
def test_a_framer_loses_and_reorders_nothing(sizes: list[int]) -> None:
    sound = np.arange(sum(sizes), dtype=np.int64).astype(np.int16)
    framer = Framer()
    frames: list[Frame] = []
    at = 0
    for size in sizes:
        frames += framer.push(sound[at : at + size])
        at += size
    frames += framer.flush()
    assert all(frame.samples.shape == (FRAME_SAMPLES,) for frame in frames)
    assert [frame.end for frame in frames] == pytest.approx([(i + 1) * FRAME_S for i in range(len(frames))])
    whole = joined(frames) if frames else np.empty(0, np.int16)
    assert np.array_equal(whole[: len(sound)], sound)
    assert not whole[len(sound) :].any()


def test_a_full_queue_drops_the_oldest_frames_and_counts_them() -> None:
    queue = FrameQueue(2)
    for number in range(5):
        assert queue.put(Frame(np.full(FRAME_SAMPLES, number, np.int16), 0.0))
    queue.end()

    async def rest() -> list[int]:
        return [int((await queue.get()).samples[0]) for _ in range(2)]

    assert asyncio.run(rest()) == [3, 4]
    assert queue.dropped == 3
    assert not queue.put(Frame(np.zeros(FRAME_SAMPLES, np.int16), 0.0))


# WAV files


@pytest.mark.parametrize(
    ("rate", "channels", "subtype", "kind"),
    [
        (16000, 1, "PCM_16", "WAV"),
        (44100, 2, "PCM_16", "WAV"),
        (8000, 1, "PCM_U8", "WAV"),
        (48000, 6, "PCM_24", "WAVEX"),
        (22050, 1, "PCM_32", "WAV"),
        (96000, 2, "FLOAT", "WAV"),
        (32000, 1, "DOUBLE", "WAVEX"),
        (8000, 1, "ULAW", "WAV"),
        (11025, 1, "PCM_16", "RF64"),
    ],
)
def test_a_wav_file_of_any_shape_becomes_16_khz_mono(
    tmp_path: Path, rate: int, channels: int, subtype: str, kind: str
) -> None:
    path = tmp_path / "tone.wav"
    soundfile.write(path, np.tile(tone(1.5, rate)[:, None], channels), rate, subtype=subtype, format=kind)
    source = WavSource(path, "fast")
    sound = joined(asyncio.run(collected(source)))
    assert len(sound) == pytest.approx(1.5 * RATE, abs=FRAME_SAMPLES)
    assert dominant(sound[: round(1.4 * RATE)]) == pytest.approx(440, abs=2)
    assert np.abs(sound).max() == pytest.approx(16384, rel=0.05)
    assert source.warnings == ()


def test_floats_beyond_full_scale_are_clipped_and_not_wrapped(tmp_path: Path) -> None:
    path = tmp_path / "loud.wav"
    sound = tone(0.5) * 10
    sound[100] = np.nan
    soundfile.write(path, sound, RATE, subtype="FLOAT")
    heard = joined(asyncio.run(collected(WavSource(path, "fast"))))
    assert heard.max() == 32767
    assert heard.min() == -32768
    assert heard[100] == 0


def test_a_truncated_wav_file_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = tmp_path / "cut.wav"
    soundfile.write(path, np.tile(tone(4, 44100)[:, None], 2), 44100)
    path.write_bytes(path.read_bytes()[: 44 + 44100 * 4 + 1])
    source = WavSource(path, "fast")
    assert len(joined(asyncio.run(collected(source)))) == pytest.approx(RATE, abs=FRAME_SAMPLES)
    assert len(source.warnings) == 1
    assert "cut short: it promises 4.00 s of sound and holds 1.00 s" in source.warnings[0]


def test_the_unknown_length_of_a_streaming_recorder_is_no_truncation(tmp_path: Path) -> None:
    path = tmp_path / "streamed.wav"
    soundfile.write(path, tone(1), RATE)
    data = bytearray(path.read_bytes())
    data[40:44] = b"\xff\xff\xff\xff"
    path.write_bytes(data)
    source = WavSource(path, "fast")
    assert len(joined(asyncio.run(collected(source)))) == pytest.approx(RATE, abs=FRAME_SAMPLES)
    assert source.warnings == ()


def _header_only(path: Path) -> None:
    soundfile.write(path, np.empty(0, np.int16), RATE)


BAD: list[tuple[Callable[[Path], object], str]] = [
    (lambda path: None, "There is no file"),
    (lambda path: path.mkdir(), "no regular file"),
    (lambda path: path.write_bytes(b""), "There is nothing to hear in .*: the file is empty"),
    (_header_only, "There is nothing to hear in .*: it has a header and no samples"),
    (lambda path: path.write_bytes(b"ID3\x04" + bytes(500)), "looks like an MP3 file"),
    (lambda path: path.write_bytes(b"\xff\xfb\x90\x64" + bytes(500)), "looks like an MP3 file"),
    (lambda path: path.write_bytes(b"OggS" + bytes(500)), "looks like an Ogg file"),
    (lambda path: path.write_bytes(bytes(4) + b"ftypM4A " + bytes(500)), "looks like an MP4"),
    (lambda path: path.write_text("turn left " * 30), "looks like text"),
    (lambda path: path.write_bytes(bytes(range(1, 256))), "something unknown"),
    (lambda path: path.write_bytes(b"RIFF\x10\x00\x00\x00WAVEjunk"), "looks like a WAV file"),
]


@pytest.mark.parametrize(("make", "message"), BAD)
def test_what_is_no_sound_is_refused_by_its_name(tmp_path: Path, make: Callable[[Path], object], message: str) -> None:
    path = tmp_path / "speech.wav"
    make(path)
    with pytest.raises(AudioFormatError, match=message) as caught:
        asyncio.run(collected(WavSource(path, "fast")))
    assert caught.value.exit_code is ExitCode.USAGE
    assert str(path) in caught.value.message
    assert caught.value.hint


@pytest.mark.parametrize(
    ("kind", "channels", "rate"),
    [
        ("FLAC", 2, 44100),
        ("FLAC", 1, 44100),
        ("FLAC", 6, 48000),
        ("OGG", 2, 44100),
        ("MP3", 2, 44100),
        ("AIFF", 1, 8000),
    ],
)
def test_other_kinds_of_sound_are_read_whatever_they_are_called(
    tmp_path: Path, kind: str, channels: int, rate: int
) -> None:
    path = tmp_path / "song.wav"
    soundfile.write(path, np.tile(tone(1.5, rate)[:, None], channels), rate, format=kind)
    for sound in (joined(asyncio.run(collected(WavSource(path, "fast")))), read_wav(path)):
        assert len(sound) == pytest.approx(1.5 * RATE, abs=0.1 * RATE)
        assert dominant(sound[:RATE]) == pytest.approx(440, abs=2)


def test_raw_sound_is_not_guessed_at(tmp_path: Path) -> None:
    path = tmp_path / "speech.raw"
    path.write_bytes(bytes(32000))
    with pytest.raises(AudioFormatError, match="raw sound") as caught:
        asyncio.run(collected(WavSource(path, "fast")))
    assert "sayso hear - <" in caught.value.hint


@given(st.binary(max_size=200))
def test_random_bytes_after_a_riff_header_never_crash(tmp_path_factory: pytest.TempPathFactory, junk: bytes) -> None:
    path = tmp_path_factory.mktemp("junk") / "junk.wav"
    path.write_bytes(b"RIFF" + len(junk).to_bytes(4, "little") + b"WAVEfmt " + junk)
    with pytest.raises(AudioFormatError):
        asyncio.run(collected(WavSource(path, "fast")))


def test_a_file_in_real_time_takes_as_long_as_it_sounds() -> None:
    async def seconds() -> tuple[float, float]:
        loop = asyncio.get_running_loop()
        began = loop.time()
        frames = await collected(WavSource(SPEECH / "stop.wav"))
        return loop.time() - began, frames[-1].end

    took, length = run(seconds())
    assert took == pytest.approx(length)


def test_a_fast_file_takes_no_time() -> None:
    async def seconds() -> float:
        began = asyncio.get_running_loop().time()
        await collected(WavSource(SPEECH / "stop.wav", "fast"))
        return asyncio.get_running_loop().time() - began

    assert run(seconds()) == 0


def test_a_file_waits_for_its_reader_and_goes_on_in_pace() -> None:
    async def gaps() -> list[float]:
        loop = asyncio.get_running_loop()
        times = []
        async with WavSource(SPEECH / "go_to_the_kitchen.wav") as source:
            for index in range(8):
                if index == 4:
                    await asyncio.sleep(10)  # virtual: the reader is busy
                await anext(source)
                times.append(loop.time())
        return list(np.diff(times))

    assert run(gaps()) == pytest.approx([FRAME_S] * 3 + [10 + FRAME_S] + [FRAME_S] * 3)


# Pipes


@pytest.fixture
def pipe() -> Iterator[tuple[Any, Any]]:
    """(read end, write end) as binary files."""
    read, write = os.pipe()
    with open(read, "rb", buffering=0) as reader, open(write, "wb", buffering=0) as writer:  # noqa: PTH123 - descriptors
        yield reader, writer


def test_pcm_from_a_pipe_survives_odd_pieces(pipe: tuple[Any, Any]) -> None:
    reader, writer = pipe
    sound = np.arange(3000, dtype=np.int16)
    data = sound.tobytes()
    source = PcmSource(reader)

    async def heard() -> list[Frame]:
        for size in itertools.cycle((1, 7, 301)):
            nonlocal data
            writer.write(data[:size])
            data = data[size:]
            if not data:
                break
        writer.close()
        return await collected(source)

    frames = asyncio.run(heard())
    assert np.array_equal(joined(frames)[:3000], sound)
    assert source.live
    assert source.warnings == ()


def test_half_a_sample_at_the_end_is_dropped_with_a_warning(pipe: tuple[Any, Any]) -> None:
    reader, writer = pipe
    writer.write(np.ones(FRAME_SAMPLES, np.int16).tobytes() + b"x")
    writer.close()
    source = PcmSource(reader)
    assert len(asyncio.run(collected(source))) == 1
    assert "ended within a sample" in source.warnings[0]


def test_a_regular_file_on_stdin_is_not_live_and_is_read_whole(tmp_path: Path) -> None:
    path = tmp_path / "long.raw"
    sound = np.arange(FRAME_SAMPLES * 500, dtype=np.int64).astype(np.int16)
    path.write_bytes(sound.tobytes())
    with path.open("rb") as stream:
        source = PcmSource(stream)
        assert not source.live
        assert np.array_equal(joined(asyncio.run(collected(source))), sound), "more than the queue holds"


def test_a_pipe_that_never_delivers_is_closed_at_once(pipe: tuple[Any, Any]) -> None:
    async def leave() -> None:
        async with PcmSource(pipe[0]) as source:
            reading = asyncio.ensure_future(anext(source, None))
            await asyncio.sleep(0)
            reading.cancel()

    asyncio.run(leave())
    assert not [thread for thread in threading.enumerate() if thread.name == "pcm-reader"]


def test_closing_a_file_that_nobody_reads_does_not_wait_for_room_in_the_queue(tmp_path: Path) -> None:
    path = tmp_path / "long.raw"
    path.write_bytes(bytes(FRAME_SAMPLES * 2 * 1000))

    async def leave() -> None:
        with path.open("rb") as stream:
            async with PcmSource(stream) as source:
                await anext(source)

    asyncio.run(leave())
    assert not [thread for thread in threading.enumerate() if thread.name == "pcm-reader"]


def test_a_process_ends_while_its_stdin_stays_open() -> None:
    code = (
        "import asyncio, sys\n"
        "from engine.audio.pipe import PcmSource\n"
        "async def main():\n"
        "    source = PcmSource(sys.stdin.buffer)\n"
        "    await source.__aenter__()\n"
        "    asyncio.ensure_future(anext(source))\n"
        "asyncio.run(main())\n"
        "print('left')\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.wait(60) == 0, "not even an unclosed source holds the process"
        assert process.stdout is not None
        assert process.stdout.read() == "left\n"
        assert process.stderr is not None
        assert "Fatal" not in process.stderr.read()


def test_pushed_sound_arrives_whole_from_several_threads() -> None:
    source = PushSource()
    pieces = [np.full(FRAME_SAMPLES, number, np.int16).tobytes() for number in range(1, 9)]
    threads = [threading.Thread(target=source.push, args=(piece,)) for piece in pieces]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    source.finish()
    frames = asyncio.run(collected(source))
    assert sorted(int(frame.samples[0]) for frame in frames) == list(range(1, 9))
    assert all(len(set(frame.samples.tolist())) == 1 for frame in frames)


def test_a_push_wakes_a_waiting_reader() -> None:
    async def first() -> Frame:
        async with PushSource() as source:
            waiting = asyncio.ensure_future(anext(source))
            await asyncio.sleep(0)
            await asyncio.to_thread(source.push, bytes(FRAME_SAMPLES * 2))
            return await waiting

    assert asyncio.run(first()).end == FRAME_S


# The simulated microphone

RECORDINGS = (SPEECH / "stop.wav", SPEECH / "where_are_you.wav")


async def some(source: Source, count: int) -> list[Frame]:
    async def first(frames: AsyncIterator[Frame]) -> list[Frame]:
        return [await anext(frames) for _ in range(count)]

    async with source:
        return await first(source.__aiter__())


def loud(frames: list[Frame]) -> int:
    return sum(int(np.abs(frame.samples).max()) > 2000 for frame in frames)


def test_the_simulated_microphone_says_the_same_at_every_run() -> None:
    first, second, other = (
        joined(run(some(SimulatedMicrophone(RECORDINGS, every_s=0.5, seed=seed), 200))) for seed in (1, 1, 2)
    )
    assert np.array_equal(first, second)
    assert not np.array_equal(first, other)


def test_the_simulated_microphone_keeps_time_and_speaks_again_and_again() -> None:
    async def listen() -> tuple[list[Frame], float]:
        began = asyncio.get_running_loop().time()
        frames = await some(SimulatedMicrophone(RECORDINGS, every_s=2), 600)
        return frames, asyncio.get_running_loop().time() - began

    frames, took = run(listen())
    assert took == pytest.approx(600 * FRAME_S)
    assert loud(frames) > 60
    assert all(frame.samples.any() for frame in frames), "there is always some noise"


def test_the_simulated_microphone_speaks_when_told() -> None:
    async def listen() -> tuple[list[Frame], Path, list[Frame]]:
        async with SimulatedMicrophone(RECORDINGS, every_s=None) as source:
            before = [await anext(source) for _ in range(100)]
            said = source.speak()
            return before, said, [await anext(source) for _ in range(30)]

    before, said, after = run(listen())
    assert loud(before) == 0
    assert said == RECORDINGS[0]
    assert loud(after) > 5
