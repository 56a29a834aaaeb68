"""Recognisers elsewhere, over real sockets on loopback: what they do is a transcript, a rejection or one error."""

from __future__ import annotations

import asyncio
import email
import socket
import threading
import traceback
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import ExitStack, asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import SecretStr
from wyoming.asr import Transcribe
from wyoming.asr import Transcript as Told
from wyoming.audio import AudioChunk, AudioStart, AudioStop
from wyoming.error import Error
from wyoming.event import Event
from wyoming.server import AsyncEventHandler, AsyncTcpServer

from config import load
from config.errors import ConfigError
from config.schema import Asr, Platform
from engine.asr.openai import OpenAITranscription
from engine.asr.recogniser import Recogniser, Rejected, Transcript
from engine.asr.remote import RATE, Heard, RemoteRecogniser
from engine.asr.wyoming import WyomingTranscription
from engine.audio.wav import read_wav
from engine.errors import SaysoError
from engine.llm.recordings import RecordingService
from engine.parts.loading import make_isolated_recogniser
from engine.wyoming import CONNECT_S
from tests.model_service import SECRET, reply
from tests.virtual_time import run

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
COMMAND = read_wav(SPEECH / "go_to_the_kitchen.wav").astype(np.float32) / np.float32(32768)
SETTINGS = load().asr
LIMIT_S = 20.0
SURE = {
    "text": " Go to the kitchen.",
    "language": "english",
    "segments": [{"tokens": [1, 2, 3], "avg_logprob": -0.1, "no_speech_prob": 0.02, "id": 0}],
}
HANGS = object()
HANGS_UP = object()


class Elsewhere:
    """A server in a thread of its own, since a recogniser blocks the one that asks."""

    def __init__(self, *answers: Any) -> None:
        self.answers = answers
        self.asked: list[Any] = []
        self.began = threading.Event()
        self.left = threading.Event()  # somebody hung up instead of waiting for an answer
        self.port = 0

    def next(self) -> Any:
        told = self.answers[min(len(self.asked), len(self.answers)) - 1]
        self.began.set()
        return told


@contextmanager
def running(serve: Callable[[], Any]) -> Iterator[None]:
    """``serve()`` is an asynchronous context manager that is entered in a thread of its own."""
    loop = asyncio.new_event_loop()
    up, down = threading.Event(), asyncio.Event()

    async def main() -> None:
        async with serve():
            up.set()
            await down.wait()

    thread = threading.Thread(target=lambda: asyncio.Runner(loop_factory=lambda: loop).run(main()))
    thread.start()
    assert up.wait(LIMIT_S)
    try:
        yield
    finally:
        loop.call_soon_threadsafe(down.set)
        thread.join(LIMIT_S)
        assert not thread.is_alive()


# A service


@contextmanager
def service(*answers: Any, **changes: Any) -> Iterator[tuple[RemoteRecogniser, Elsewhere]]:
    """A recogniser that asks an OpenAI-compatible service, which answers like this; settings in ``changes``."""
    other = Elsewhere(*answers)

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        head = (await reader.readuntil(b"\r\n\r\n")).decode()
        length = int(next(line for line in head.split("\r\n") if line.lower().startswith("content-length")).split()[1])
        other.asked.append(form(head, await reader.readexactly(length)))
        told = other.next()
        if told is HANGS:
            await reader.read()
            other.left.set()
        elif told is not HANGS_UP:
            writer.write(told if isinstance(told, bytes) else reply(200, told))
        writer.close()

    @asynccontextmanager
    async def serve() -> AsyncIterator[None]:
        async with await asyncio.start_server(answer, "127.0.0.1", 0) as server:
            other.port = server.sockets[0].getsockname()[1]
            yield

    timeout_s = changes.pop("timeout_s", LIMIT_S)
    with running(serve):
        url = f"http://127.0.0.1:{other.port}/v1"
        key = SecretStr(SECRET)
        platform = Platform(kind="openai", base_url=url, model="one-that-hears", api_key=key, timeout_s=timeout_s)
        recordings = RecordingService("hearing", platform, "a service for speech", "Check the model.")
        made = RemoteRecogniser(OpenAITranscription(recordings, "one-that-hears"), settings(**changes))
        yield made, other
        made.close()


def form(head: str, body: bytes) -> dict[str, bytes]:
    """The fields of a multipart form, and the first line of the request."""
    kind = next(line for line in head.split("\r\n") if line.lower().startswith("content-type"))
    message = email.message_from_bytes(kind.encode() + b"\r\n\r\n" + body)
    fields = {}
    for part in message.get_payload():
        fields[part.get_param("name", header="content-disposition")] = part.get_payload(decode=True)
    return {"line": head.split("\r\n")[0].encode(), "head": head.encode(), **fields}


def settings(**changes: Any) -> Asr:
    return SETTINGS.model_copy(update=changes)


def test_a_service_is_sent_the_sound_as_a_file_and_the_words_that_come_back_are_a_transcript() -> None:
    with service(SURE) as (made, other):
        found = made.transcribe(COMMAND, ("kitchen", "study"))
    assert isinstance(found, Transcript)
    assert (found.text, found.decoding.language) == ("Go to the kitchen.", "en")
    assert found.decoding.avg_logprob == pytest.approx(-0.1)
    [asked] = other.asked
    assert asked["line"] == b"POST /v1/audio/transcriptions HTTP/1.1"
    assert f"Authorization: Bearer {SECRET}".encode().lower() in asked["head"].lower()
    assert asked["language"] == b"en"
    assert asked["prompt"] == b"kitchen, study."
    assert asked["model"] == b"one-that-hears"
    assert asked["file"][:4] == b"RIFF"
    sent = np.frombuffer(asked["file"][44:], "<i2")
    assert np.abs(sent / 32768 - COMMAND).max() < 1e-3


def test_what_a_service_is_not_sure_of_does_not_pass_the_gates() -> None:
    unsure = {**SURE, "segments": [{"tokens": [1], "avg_logprob": -2.0, "no_speech_prob": 0.1}]}
    silent = {**SURE, "segments": [{"tokens": [1], "avg_logprob": -0.1, "no_speech_prob": 0.9}]}
    for answer, reason in (
        (unsure, "low_confidence"),
        (silent, "no_speech"),
        ({"text": "Thanks for watching!"}, "artefact"),
        ({"text": "谢谢观看。"}, "artefact"),
        ({"text": ""}, "empty"),
    ):
        with service(answer) as (made, _):
            found = made.transcribe(COMMAND)
        assert isinstance(found, Rejected)
        assert found.reason == reason


def test_a_service_that_knows_no_figures_is_asked_without_them_from_then_on() -> None:
    refusal = reply(400, {"error": {"message": "response_format 'verbose_json' is not compatible with this model"}})
    with service(refusal, {"text": "Go to the kitchen."}) as (made, other):
        assert isinstance(made.transcribe(COMMAND), Transcript)
        assert isinstance(made.transcribe(COMMAND), Transcript)
    assert [asked["response_format"] for asked in other.asked] == [b"verbose_json", b"json", b"json"]


def test_a_language_that_nobody_speaks_here_is_not_taken_for_the_one_that_was_spoken() -> None:
    welsh = {**SURE, "text": "Ewch i'r gegin.", "language": "welsh"}
    with service(welsh, SURE, language="auto", languages=("en", "zh")) as (made, other):
        found = made.transcribe(COMMAND)
    assert isinstance(found, Transcript)
    assert found.decoding.language == "en"
    assert ["language" in asked for asked in other.asked] == [False, True]


@pytest.mark.parametrize(
    ("told", "text", "language"),
    [
        *(
            (name, "去厨房。", "zh")
            for name in ("zh-CN", "zh_CN", "ZH", "cmn", "cmn-Hans-CN", "yue", "Chinese", "mandarin")
        ),
        *((name, "Go to the kitchen.", "en") for name in ("en-US", "en_GB", "english", "English (US)", "eng")),
    ],
)
def test_a_language_is_known_by_whatever_it_is_called(told: str, text: str, language: str) -> None:
    for other_side, answer in ((service, {"text": text, "language": told}), (wyoming, Told(text, language=told))):
        with other_side(answer, language="auto", languages=("en", "zh")) as (made, other):  # type: ignore[operator]
            found = made.transcribe(COMMAND)
        assert isinstance(found, Transcript)
        assert (found.text, found.decoding.language) == (text, language)
        assert len(other.asked) == 1, "the answer was thrown away"


def test_a_language_that_is_named_in_the_settings_is_called_as_it_is_there() -> None:
    with service({"text": "去厨房。", "language": "Cantonese"}, language="auto", languages=("en", "yue")) as (made, _):
        found = made.transcribe(COMMAND)
    assert isinstance(found, Transcript)
    assert found.decoding.language == "yue"


@pytest.mark.parametrize(
    "more",
    [
        {"segments": [{"tokens": None, "avg_logprob": -0.1, "no_speech_prob": 0.1}]},
        {"segments": [{"tokens": ["a"], "avg_logprob": -0.1}]},
        {"segments": [{"avg_logprob": "high", "no_speech_prob": None}]},
        {"segments": [None, 3, {"tokens": [1], "avg_logprob": -0.1}]},
        {"segments": "none"},
        {"segments": [{"avg_logprob": 1e300}]},
        {"segments": [{"avg_logprob": -0.05, "tokens": [1]}, {"avg_logprob": 1e308, "no_speech_prob": 1e308}]},
        {"language": ["en"]},
        {"language": ""},
    ],
)
def test_what_cannot_be_read_beside_a_text_does_not_cost_the_text(more: dict[str, Any]) -> None:
    with service({"text": "Go to the kitchen.", **more}, language="auto") as (made, other):
        found = made.transcribe(COMMAND)
    assert isinstance(found, Transcript)
    assert 0.9 < found.confidence <= 1
    assert len(other.asked) == 1


def test_half_a_character_is_no_transcription() -> None:
    with service(reply(200, rb'{"text": "go \ud800"}')) as (made, _), pytest.raises(SaysoError, match="it is no JSON"):
        made.transcribe(COMMAND)


def test_no_control_character_of_a_service_gets_into_a_transcript() -> None:
    with service({"text": "Go\x1b[31m to the\n kitchen.\x00"}) as (made, _):
        found = made.transcribe(COMMAND)
    assert isinstance(found, Transcript)
    assert found.text == "Go [31m to the kitchen."


def test_a_service_that_refuses_either_form_is_asked_for_figures_again() -> None:
    refusal = reply(400, {"error": {"message": "this file is no sound"}})
    with service(refusal, refusal, SURE) as (made, other):
        with pytest.raises(SaysoError, match="this file is no sound"):
            made.transcribe(COMMAND)
        assert isinstance(made.transcribe(COMMAND), Transcript)
    assert [asked["response_format"] for asked in other.asked] == [b"verbose_json", b"json", b"verbose_json"]


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (reply(401, {"error": "wrong key"}), "refused with status 401"),
        (reply(200, b"<html>"), "no JSON"),
        (reply(200, b"[" * 100_000), "no JSON"),
        (reply(200, {"words": []}), "no transcription"),
        (reply(200, {"text": None, "segments": []}), "no transcription"),
        (reply(200, b"\xff\xfe\x00garbage"), "no JSON"),
        (HANGS_UP, "cannot be reached"),
        (reply(429, {"error": "slow down"}, **{"Retry-After": "60"}), "status 429"),
    ],
)
def test_a_service_that_fails_is_one_error_without_the_key(answer: Any, message: str) -> None:
    with service(answer) as (made, _), pytest.raises(SaysoError, match=message) as caught:
        made.transcribe(COMMAND)
    assert SECRET not in repr(caught.value) + str(caught.value)
    assert caught.value.hint


def test_a_busy_service_is_asked_again() -> None:
    with service(reply(429, {}, **{"Retry-After": "0"}), SURE) as (made, other):
        assert isinstance(made.transcribe(COMMAND), Transcript)
    assert len(other.asked) == 2


def test_a_service_that_hangs_is_given_up_in_time() -> None:
    with service(HANGS, timeout_s=0.2) as (made, other), pytest.raises(SaysoError, match="did not answer within"):
        made.transcribe(COMMAND)
    assert other.left.wait(LIMIT_S)


# A Wyoming server


@contextmanager
def wyoming(*answers: Any, **changes: Any) -> Iterator[tuple[RemoteRecogniser, Elsewhere]]:
    """A recogniser that asks a Wyoming server, made with the package, which answers with these events."""
    other = Elsewhere(*answers)

    class Handler(AsyncEventHandler):
        async def handle_event(self, event: Event) -> bool:
            if Transcribe.is_type(event.type):
                other.asked.append({"wish": Transcribe.from_event(event), "sound": b""})
            elif AudioStart.is_type(event.type):
                other.asked[-1]["format"] = AudioStart.from_event(event)
            elif AudioChunk.is_type(event.type):
                other.asked[-1]["sound"] += AudioChunk.from_event(event).audio
            elif AudioStop.is_type(event.type):
                return await self._answer(other.next())
            return True

        async def _answer(self, told: Any) -> bool:
            if told is HANGS:
                await self.reader.read()
                other.left.set()
            elif isinstance(told, bytes):
                self.writer.write(told)
                await self.writer.drain()
            elif told is not HANGS_UP:
                await self.write_event(told.event())
            return told is not HANGS_UP and not isinstance(told, bytes)

    @asynccontextmanager
    async def serve() -> AsyncIterator[None]:
        server = AsyncTcpServer("127.0.0.1", 0)
        await server.start(Handler)
        assert server._server is not None
        other.port = server._server.sockets[0].getsockname()[1]
        try:
            yield
        finally:
            await server.stop()

    limit_s = changes.pop("limit_s", LIMIT_S)
    with running(serve):
        uri = f"tcp://127.0.0.1:{other.port}"
        made = RemoteRecogniser(WyomingTranscription(uri, limit_s), settings(**changes))
        yield made, other
        made.close()


def test_a_wyoming_server_is_sent_the_sound_and_its_words_are_a_transcript() -> None:
    with wyoming(Told("Go to the kitchen.", language="en")) as (made, other):
        found = made.transcribe(COMMAND, ("kitchen",))
        again = made.transcribe(COMMAND)
    assert isinstance(found, Transcript)
    assert isinstance(again, Transcript)
    assert (found.text, found.decoding.language) == ("Go to the kitchen.", "en")
    asked = other.asked[0]
    assert (asked["wish"].language, asked["wish"].transcript_names) == ("en", ["kitchen"])
    assert (asked["format"].rate, asked["format"].width, asked["format"].channels) == (RATE, 2, 1)
    assert np.abs(np.frombuffer(asked["sound"], "<i2") / 32768 - COMMAND).max() < 1e-3


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (HANGS_UP, "closed the connection"),
        (Error("the model is broken"), "reports an error: the model is broken"),
        (b"HTTP/1.1 400 Bad Request\r\n\r\n", "does not speak Wyoming"),
        (b'{"type": "transcript", "data": {"words": 1}}\n', "does not speak Wyoming"),
        (b'{"type": "transcript", "data": {"text": null}}\n', "does not speak Wyoming"),
        (b'{"type": "transcript", "data": {"text": "go \\ud800"}}\n', "does not speak Wyoming"),
        (b'{"type": "transcript", "data": {"text": "go", "x": 1e400}}\n', "does not speak Wyoming"),
        (Error("a\x1b[2Jb\nc" + "d" * 300), r"reports an error: a \[2Jb cd{191}…"),
        (b'{"type": "transcript", "data_length": 100}\n{', "cannot be used"),
        (b"[1, 2]\n", "does not speak Wyoming"),
    ],
)
def test_a_wyoming_server_that_fails_is_one_error(answer: Any, message: str) -> None:
    with wyoming(answer) as (made, _), pytest.raises(SaysoError, match=message) as caught:
        made.transcribe(COMMAND)
    assert "asr.server" in caught.value.hint


def test_whatever_the_other_side_brings_about_is_one_error_that_tells_nothing_of_it() -> None:
    class Faulty:
        name = "faulty"

        async def ask(self, *_: object) -> Heard:
            raise LookupError(SECRET)

        async def close(self) -> None:
            pass

    with pytest.raises(SaysoError, match="LookupError") as caught:
        RemoteRecogniser(Faulty(), load(environ={}).asr).transcribe(COMMAND)
    assert SECRET not in "".join(traceback.format_exception(caught.value))


def test_a_wyoming_server_that_hangs_is_given_up_in_time() -> None:
    with wyoming(HANGS, limit_s=0.2) as (made, other), pytest.raises(SaysoError, match="has not answered for"):
        made.transcribe(COMMAND)
    assert other.left.wait(LIMIT_S)


def test_a_wyoming_server_that_is_not_there_is_one_error() -> None:
    with wyoming(HANGS) as (made, _):
        pass
    made = RemoteRecogniser(WyomingTranscription(made.name.removeprefix("Wyoming at ")), SETTINGS)
    with pytest.raises(SaysoError, match="cannot be used"):
        made.transcribe(COMMAND)


def test_a_wyoming_server_that_takes_no_connection_is_given_up_after_the_time_that_is_named() -> None:
    async def ask(address: str) -> None:
        await WyomingTranscription(address).ask(np.zeros(RATE, np.int16), (), "en")

    with socket.create_server(("127.0.0.1", 0), backlog=0) as full, ExitStack() as waiting:
        for _ in range(4):  # more than the system keeps for one that accepts none
            crowd = waiting.enter_context(socket.socket())
            crowd.setblocking(False)
            crowd.connect_ex(full.getsockname())
        with pytest.raises(SaysoError, match=f"cannot be reached within {CONNECT_S:g} s"):
            run(ask(f"tcp://127.0.0.1:{full.getsockname()[1]}"))


# Whoever no longer waits


@pytest.mark.parametrize("other_side", [service, wyoming])
def test_an_answer_that_nobody_needs_is_not_waited_for(other_side: Any) -> None:
    with other_side(HANGS) as (made, other):
        found = made.transcribe(COMMAND, cancelled=other.began.is_set)
        assert isinstance(found, Rejected)
        assert other.left.wait(LIMIT_S)


@pytest.mark.parametrize("other_side", [service, wyoming])
def test_closing_ends_a_conversation_at_once(other_side: Any) -> None:
    errors: list[SaysoError] = []
    with other_side(HANGS) as (made, other):

        def ask() -> None:
            try:
                made.transcribe(COMMAND)
            except SaysoError as error:
                errors.append(error)

        asking = threading.Thread(target=ask)
        asking.start()
        assert other.began.wait(LIMIT_S)
        made.close()
        asking.join(LIMIT_S)
        assert not asking.is_alive()
        assert other.left.wait(LIMIT_S)
    assert [error.message for error in errors] == ["The recogniser has been closed."]


# The settings


def test_the_settings_name_the_recogniser() -> None:
    overrides = ("asr.backend=wyoming", "asr.server=tcp://127.0.0.1:10300")
    assert made_from(*overrides).name == "Wyoming at tcp://127.0.0.1:10300"
    overrides = ("asr.backend=openai", "asr.platform=openai_hearing")
    assert made_from(*overrides).name == "openai_hearing (gpt-4o-mini-transcribe)"


@pytest.mark.parametrize(
    "overrides",
    [
        ("asr.backend=wyoming",),
        ("asr.backend=wyoming", "asr.server=somewhere"),
        ("asr.backend=openai",),
        ("asr.backend=openai", "asr.platform=dify_decision"),
    ],
)
def test_a_recogniser_that_nobody_could_reach_is_a_mistake_in_the_settings(overrides: tuple[str, ...]) -> None:
    with pytest.raises(ConfigError, match=r"asr"):
        load(overrides=overrides)


def made_from(*overrides: str) -> Recogniser:
    return make_isolated_recogniser(load(overrides=overrides))
