"""A service that speaks, over a real socket on loopback: whatever it does, it is sound or one error."""

from __future__ import annotations

import asyncio
import io
import json
import wave
from collections.abc import AsyncIterator
from contextlib import aclosing, asynccontextmanager
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import SecretStr

from engine.audio.source import Samples
from engine.errors import ModelError, SaysoError
from engine.llm.bytes import ByteService
from engine.llm.chat import KeyWanted, Refused, TooSlow, Unreachable
from engine.llm.service import TRIES
from engine.tts.openai import RATE, ServiceVoice, _Sound
from engine.tts.sentences import Sentence, sentences
from engine.tts.synthesis import Piece
from tests.model_service import HANGS_UP, SECRET, SILENCE, Answer, Service, Unfinished, reply, serving

TONE = np.asarray(9000 * np.sin(np.arange(RATE) / 10), np.int16)
HEAD = b"HTTP/1.1 200 OK\r\nContent-Type: audio/pcm\r\nConnection: close\r\n"


def sound(samples: Samples = TONE, kind: str = "audio/pcm") -> bytes:
    return reply(200, samples.astype("<i2").tobytes(), **{"Content-Type": kind})


def wav(samples: Samples, rate: int, *, channels: int = 1, width: int = 2) -> bytes:
    file = io.BytesIO()
    with wave.open(file, "wb") as out:
        out.setnchannels(channels)
        out.setsampwidth(width)
        out.setframerate(rate)
        out.writeframes(samples.astype("<i2").tobytes())
    return file.getvalue()


@asynccontextmanager
async def speaking(*answers: Answer, speed: float = 1.0, **changes: Any) -> AsyncIterator[tuple[ServiceVoice, Service]]:
    async with serving(*answers) as service:
        platform = service.platform(model="one-that-speaks", **changes)
        assert platform.model is not None
        bytes_ = ByteService("speech", platform, "a service for speech", "Check voice.speaker.")
        voice = ServiceVoice(bytes_, platform.model, "alloy", speed)
        try:
            yield voice, service
        finally:
            await voice.close()


def a_sentence(text: str = "Moved 1.00 m forward.") -> Sentence:
    [sentence] = sentences(text)
    return sentence


async def said(voice: ServiceVoice, text: str = "Moved 1.00 m forward.") -> list[Piece]:
    async with aclosing(voice.synthesise(a_sentence(text))) as pieces:
        return [piece async for piece in pieces]


def joined(pieces: list[Piece]) -> Samples:
    return np.concatenate([piece.samples for piece in pieces])


def error_of(*answers: Answer, **changes: Any) -> SaysoError:
    async def scenario() -> SaysoError:
        async with speaking(*answers, **changes) as (voice, _):
            with pytest.raises(SaysoError) as caught:
                await said(voice)
            return caught.value

    found = asyncio.run(scenario())
    assert SECRET not in f"{found} {found!r} {found.__cause__!r} {found.__context__!r}"
    assert "speech" in found.message
    return found


# Sound


def test_it_is_asked_for_pcm_with_the_key_and_its_sound_is_played_as_it_is() -> None:
    async def scenario() -> None:
        async with speaking(sound(), speed=1.5) as (voice, service):
            pieces = await said(voice)
            assert {piece.rate for piece in pieces} == {RATE}
            assert np.array_equal(joined(pieces), TONE)
            [asked] = service.asked
            assert asked.line.startswith("POST /v1/audio/speech ")
            assert asked.headers["authorization"] == f"Bearer {SECRET}"
            assert asked.body == {
                "model": "one-that-speaks",
                "voice": "alloy",
                "input": "Moved 1 metre forward.",
                "response_format": "pcm",
                "speed": 1.5,
            }

    asyncio.run(scenario())


def test_the_first_sound_comes_before_the_last_is_sent() -> None:
    async def scenario() -> None:
        begun = HEAD + b"\r\n" + TONE[:4000].astype("<i2").tobytes()
        async with speaking(Unfinished(begun)) as (voice, service):
            async with aclosing(voice.synthesise(a_sentence())) as pieces:
                assert len((await anext(pieces)).samples) > 0
            await asyncio.wait_for(service.left.wait(), 10)  # whoever has enough hangs up

    asyncio.run(scenario())


@pytest.mark.parametrize("rate", [16_000, 22_050, 48_000])
def test_a_service_that_sends_a_wav_file_is_understood_too(rate: int) -> None:
    async def scenario() -> None:
        async with speaking(reply(200, wav(TONE, rate), **{"Content-Type": "audio/wav"})) as (voice, _):
            pieces = await said(voice)
            assert {piece.rate for piece in pieces} == {rate}
            assert np.array_equal(joined(pieces), TONE)

    asyncio.run(scenario())


@given(st.lists(st.integers(1, 4000), max_size=30), st.booleans())
def test_the_pieces_that_bytes_come_in_make_no_difference(lengths: list[int], in_a_file: bool) -> None:
    data = wav(TONE, RATE) if in_a_file else TONE.astype("<i2").tobytes()
    cuts = [0, *np.minimum(np.cumsum(lengths), len(data)).tolist(), len(data)] if lengths else [0, len(data)]
    reading = _Sound()
    pieces = [reading.add(data[a:b]) for a, b in pairwise(cuts)]
    assert np.array_equal(joined(pieces), TONE)


@settings(max_examples=200)
@given(st.binary(max_size=400))
def test_no_header_breaks_the_reader(junk: bytes) -> None:
    reading, refused = _Sound(), ""
    try:
        reading.add(b"RIFF" + junk)
        reading.add(junk)
    except ValueError as error:
        refused = str(error)
    assert not refused or "WAV" in refused


# What goes wrong


def test_a_file_in_stereo_is_refused_instead_of_played_at_half_speed() -> None:
    file = wav(TONE, RATE, channels=2)
    assert "2 channels" in error_of(reply(200, file, **{"Content-Type": "audio/wav"})).message


@pytest.mark.parametrize(
    "kind",
    [
        *("application/json", "text/html", "audio/mpeg; charset=x", "audio/mp3", "audio/ogg", "application/ogg"),
        *("audio/opus", "audio/flac", "audio/aac", "audio/webm"),
    ],
)
def test_an_answer_that_is_no_sound_is_an_error_and_not_noise(kind: str) -> None:
    found = error_of(reply(200, b"{}", **{"Content-Type": kind}))
    assert isinstance(found, ModelError)
    assert kind.partition(";")[0] in found.message
    assert "platforms.speech" in found.hint


@pytest.mark.parametrize("kind", ["audio/pcm", "audio/wav", "application/octet-stream"])
@pytest.mark.parametrize(
    ("begins", "what"),
    [
        (b"ID3\x04\x00", "MP3"),
        (b"\xff\xfb\x90\x64", "MP3"),  # MPEG 1
        (b"\xff\xf3\x64\xc4", "MP3"),  # MPEG 2, as at 24 kHz
        (b"\xff\xf1\x50\x80", "AAC"),
        (b"OggS\x00\x02", "Ogg"),
        (b"fLaC\x00\x00", "FLAC"),
        (b"\x1a\x45\xdf\xa3", "WebM"),
    ],
)
def test_sound_that_is_packed_is_an_error_and_not_noise_whatever_it_is_called(
    begins: bytes, what: str, kind: str
) -> None:
    found = error_of(reply(200, begins + bytes(1000), **{"Content-Type": kind}))
    assert isinstance(found, ModelError)
    assert f"it is {what}, not sound in PCM" in found.message
    assert "platforms.speech" in found.hint


@pytest.mark.parametrize("first", [-1, 0, 255, -256, 767, -513])
def test_sound_that_begins_quietly_is_not_taken_for_anything_else(first: int) -> None:
    quiet = np.full(2000, first, np.int16)
    assert np.array_equal(_Sound().add(quiet.astype("<i2").tobytes()).samples, quiet)


@pytest.mark.parametrize("data", [b"", b"\0", wav(TONE[:0], RATE), wav(TONE, RATE)[:20]])
def test_a_service_that_makes_no_sound_of_words_has_failed(data: bytes) -> None:
    found = error_of(reply(200, data, **{"Content-Type": "audio/pcm"}))
    assert isinstance(found, ModelError)
    assert "sent no sound" in found.message
    assert "platforms.speech" in found.hint


def test_a_service_that_makes_no_sound_of_mere_signs_has_said_them() -> None:
    async def scenario() -> None:
        async with speaking(reply(200, b"", **{"Content-Type": "audio/pcm"})) as (voice, _):
            assert await said(voice, "…!") == []

    asyncio.run(scenario())


def test_half_a_character_is_sent_as_what_can_be_sent() -> None:
    async def scenario() -> None:
        async with speaking(sound()) as (voice, service):
            assert await said(voice, "Going to caf\udcc3 now.")
            assert service.asked[0].body["input"] == "Going to caf? now."

    asyncio.run(scenario())


def test_a_refusal_says_why_and_what_to_look_at() -> None:
    found = error_of(reply(400, {"error": {"message": f"no such voice, {SECRET}"}}))
    assert isinstance(found, Refused)
    assert "no such voice" in found.message
    assert "voice.speaker" in found.hint


def test_a_service_that_wants_a_key_gets_none_that_was_not_given() -> None:
    assert isinstance(error_of(reply(401, {}), api_key=None), KeyWanted)
    assert isinstance(error_of(sound(), api_key=SecretStr("schlüssel")), KeyWanted)


def test_one_that_hangs_up_is_asked_again_before_anything_was_heard() -> None:
    async def scenario() -> None:
        async with speaking(HANGS_UP, sound()) as (voice, service):
            assert np.array_equal(joined(await said(voice)), TONE)
            assert len(service.asked) == 2
        async with speaking(HANGS_UP) as (voice, service):
            with pytest.raises(Unreachable):
                await said(voice)
            assert len(service.asked) == TRIES

    asyncio.run(scenario())


def test_one_that_breaks_off_in_the_middle_is_not_asked_again_and_what_came_was_heard() -> None:
    async def scenario() -> None:
        cut = HEAD + b"Content-Length: 100000\r\n\r\n" + TONE[:5000].astype("<i2").tobytes()
        async with speaking(cut) as (voice, service):
            heard: list[Piece] = []

            async def listen() -> None:
                async for piece in voice.synthesise(a_sentence()):
                    heard.append(piece)

            with pytest.raises(Unreachable, match="broke off"):
                await listen()
            assert len(joined(heard)) == 5000
            assert len(service.asked) == 1

    asyncio.run(scenario())


def test_one_that_says_nothing_is_given_up_after_its_time() -> None:
    assert isinstance(error_of(SILENCE, timeout_s=0.2), TooSlow)


def test_one_that_falls_silent_in_the_middle_is_given_up_after_its_time() -> None:
    begun = HEAD + b"\r\n" + TONE[:4000].astype("<i2").tobytes()
    found = error_of(Unfinished(begun), timeout_s=0.2)
    assert "broke off" in found.message


def test_who_is_cancelled_hangs_up_at_once() -> None:
    async def scenario() -> None:
        async with speaking(SILENCE) as (voice, service):
            asked = asyncio.Event()
            service.on_request = asked.set
            saying = asyncio.create_task(said(voice))
            await asyncio.wait_for(asked.wait(), 10)
            saying.cancel()
            await asyncio.gather(saying, return_exceptions=True)
            await asyncio.wait_for(service.left.wait(), 10)

    asyncio.run(scenario())


def test_nothing_is_sent_before_there_is_something_to_say() -> None:
    async def scenario() -> None:
        async with speaking(sound()) as (voice, service):
            await voice.load()
            assert service.asked == []
            assert json.dumps(voice.name) == '"speech (one-that-speaks, alloy)"'

    asyncio.run(scenario())
