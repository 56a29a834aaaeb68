"""Recogniser and voice for other programs, over real sockets on loopback, asked with the Wyoming package's own classes
and with our clients: whoever asks properly is answered, whoever does not is told why, and nobody else notices.
"""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable, Sequence
from contextlib import AsyncExitStack, aclosing, asynccontextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as trials
from hypothesis import strategies as st
from numpy.typing import NDArray
from wyoming.asr import Transcribe
from wyoming.asr import Transcript as Told
from wyoming.audio import AudioChunk, AudioStart, AudioStop
from wyoming.client import AsyncClient
from wyoming.error import Error
from wyoming.event import Event, Eventable
from wyoming.info import Describe, Info
from wyoming.ping import Ping, Pong
from wyoming.tts import Synthesize

from config import ConfigError
from config import load as load_settings
from engine import serving, visit, wyoming
from engine.asr.recogniser import Decoding, Recogniser, Rejected, Transcript
from engine.asr.remote import RemoteRecogniser
from engine.asr.wyoming import WyomingTranscription
from engine.audio.wav import read_wav
from engine.errors import DeviceError, ModelError, UsageError
from engine.lead import Lead
from engine.parts.loading import make_isolated_recogniser, make_synthesiser
from engine.serving import Server, is_private
from engine.tts.sentences import Sentence, sentences
from engine.tts.synthesis import Piece, Synthesiser
from engine.tts.wyoming import WyomingVoice
from engine.visit import LONGEST_S, LONGEST_TEXT, Offer, Recording
from engine.wyoming import RATE
from tests.unit.test_speaking import Tones

SPEECH = Path(__file__).parents[2] / "assets" / "speech"
COMMAND = read_wav(SPEECH / "go_to_the_kitchen.wav")
SETTINGS = load_settings(environ={}, user_folder=Path("no-such-folder"))
LIMIT_S = 30.0


class Counting:
    """A recogniser that hears how long a sound is, once it may."""

    name = "counting (slowly), en"
    takes_lead = False

    def __init__(self, *, free: bool = True) -> None:
        self.asked: list[tuple[int, tuple[str, ...]]] = []
        self.given_up = threading.Event()
        self.busy = threading.Event()
        self.free = threading.Event()
        if free:
            self.free.set()

    def load(self) -> None: ...

    def transcribe(
        self,
        samples: NDArray[np.float32],
        vocabulary: Sequence[str] = (),
        cancelled: Callable[[], bool] = lambda: False,
        *,
        quick: bool = False,
        lead: Lead | None = None,
    ) -> Transcript | Rejected:
        self.asked.append((len(samples), tuple(vocabulary)))
        self.busy.set()
        while not self.free.wait(0.01):
            if cancelled():
                self.given_up.set()
                return Rejected("empty", "Nobody needs it.")
        if not np.abs(samples).max(initial=0) > 0:
            return Rejected("no_speech", "It is silent.")
        return Transcript(f"{len(samples)} samples", 0.9, Decoding("en", -0.1, 0.0, len(samples) / RATE, 0.1, 10.0))

    def likelihood(
        self, samples: NDArray[np.float32], texts: Sequence[str], cancelled: Callable[[], bool] = lambda: False
    ) -> float | None:
        return None

    def close(self) -> None: ...


class Visitor:
    """Somebody who speaks Wyoming with the package's own client."""

    def __init__(self, client: AsyncClient) -> None:
        self._client = client

    async def say(self, *events: Eventable) -> None:
        for event in events:
            await self._client.write_event(event.event())

    async def hear(self) -> Event | None:
        async with asyncio.timeout(LIMIT_S):
            return await self._client.read_event()

    async def ask(self, *events: Eventable) -> Event:
        await self.say(*events)
        event = await self.hear()
        assert event is not None, "the server hung up"
        return event


class Place:
    """A server, and what it told about its visitors."""

    def __init__(self, server: Server, told: list[str]) -> None:
        self.server = server
        self.told = told

    @asynccontextmanager
    async def visitor(self) -> AsyncIterator[Visitor]:
        async with AsyncClient.from_uri(self.server.address) as client:
            yield Visitor(client)

    @asynccontextmanager
    async def socket(self) -> AsyncIterator[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
        _, port = serving.parsed(self.server.address)
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        try:
            yield reader, writer
        finally:
            writer.close()


def served(
    scenario: Callable[[Place], Awaitable[None]],
    recogniser: Recogniser | None = None,
    voice: Synthesiser | None = None,
) -> None:
    async def run() -> None:
        told: list[str] = []
        offer = Offer(recogniser, voice, ("en",), ("en", "zh"))
        async with asyncio.timeout(4 * LIMIT_S), Server(offer, "tcp://127.0.0.1:0", told.append) as server:
            await scenario(Place(server, told))
        assert not server._visits, "nobody stays when the house is closed"

    asyncio.run(run())


def sound(samples: NDArray[np.int16] = COMMAND, *, chunk: int = 1000) -> list[Eventable]:
    """A request to recognise it, as Home Assistant makes one."""
    pieces = [samples[at : at + chunk].tobytes() for at in range(0, len(samples), chunk)]
    chunks = [AudioChunk(RATE, 2, 1, piece) for piece in pieces]
    return [Transcribe(language="en"), AudioStart(RATE, 2, 1), *chunks, AudioStop()]


def text_of(event: Event) -> str:
    return str(Told.from_event(event).text)


# Who asks properly


def test_who_asks_what_there_is_is_told_of_the_recogniser_and_the_voice() -> None:
    async def scenario(place: Place) -> None:
        async with place.visitor() as visitor:
            info = Info.from_event(await visitor.ask(Describe()))
            [asr], [tts] = info.asr, info.tts
            assert (asr.name, asr.installed, asr.models[0].name) == ("sayso", True, "counting")
            assert asr.models[0].languages == ["en"]
            assert (tts.voices[0].name, tts.voices[0].languages) == ("tones", ["en", "zh"])
            assert Pong.from_event(await visitor.ask(Ping("hello"))).text == "hello"

    served(scenario, Counting(), Tones())


def test_what_is_not_there_is_neither_offered_nor_given() -> None:
    async def scenario(place: Place) -> None:
        async with place.visitor() as visitor:
            info = Info.from_event(await visitor.ask(Describe()))
            assert info.asr
            assert not info.tts
            answer = await visitor.ask(Synthesize("Hello."))
            assert Error.from_event(answer).code == "not-offered"
            assert await visitor.hear() is None, "and that is the end"

    served(scenario, Counting())


def test_sound_becomes_words_and_the_names_that_the_visitor_expects_reach_the_recogniser() -> None:
    ears = Counting()

    async def scenario(place: Place) -> None:
        async with place.visitor() as visitor:
            wish, *rest = sound()
            del wish
            named = Transcribe(transcript_names=["Rosie"], transcript_terms=["kitchen"])
            assert text_of(await visitor.ask(named, *rest)) == f"{len(COMMAND)} samples"
            assert text_of(await visitor.ask(*sound(COMMAND[:8000]))) == "8000 samples", "in the same connection"
            assert text_of(await visitor.ask(*sound(np.zeros(8000, np.int16)))) == "", "as Home Assistant expects it"

    served(scenario, ears)
    assert ears.asked == [(len(COMMAND), ("Rosie", "kitchen")), (8000, ()), (8000, ())]


@pytest.mark.parametrize(("rate", "width", "channels"), [(48_000, 2, 2), (22_050, 2, 1), (16_000, 4, 1), (8000, 2, 1)])
def test_sound_of_any_usual_kind_is_taken_as_the_same_sound(rate: int, width: int, channels: int) -> None:
    seconds = np.arange(rate) / rate
    tone = (0.3 * np.sin(2 * np.pi * 440 * seconds) * 2 ** (8 * width - 1)).astype(f"<i{width}")
    pcm = np.repeat(tone, channels).tobytes()
    recording = Recording()
    step = 1000 * width * channels
    for at in range(0, len(pcm), step):
        recording.add(AudioChunk(rate, width, channels, pcm[at : at + step]))
    found = recording.samples() / 32768
    assert len(found) == pytest.approx(RATE, abs=2)
    expected = 0.3 * np.sin(2 * np.pi * 440 * np.arange(len(found)) / RATE)
    assert np.abs(found - expected)[500:-500].max() < 0.01


def test_a_text_becomes_sound_sentence_by_sentence() -> None:
    async def scenario(place: Place) -> None:
        async with place.visitor() as visitor:
            start = AudioStart.from_event(await visitor.ask(Synthesize("Moved. I am in the kitchen.")))
            chunks = []
            while AudioChunk.is_type((event := await visitor.hear() or Event("nothing")).type):
                chunks.append(AudioChunk.from_event(event))
            assert AudioStop.is_type(event.type)
            assert {(chunk.rate, chunk.width, chunk.channels) for chunk in chunks} == {(start.rate, 2, 1)}
            expected = [piece async for piece in spoken(Tones(), "Moved. I am in the kitchen.")]
            heard = np.frombuffer(b"".join(chunk.audio for chunk in chunks), np.int16)
            assert np.array_equal(heard, np.concatenate([piece.samples for piece in expected]))

    served(scenario, voice=Tones())


async def spoken(voice: Synthesiser, text: str) -> AsyncGenerator[Piece]:
    for sentence in sentences(text):
        async with aclosing(voice.synthesise(sentence)) as pieces:
            async for piece in pieces:
                yield piece


def test_a_text_in_which_nothing_is_to_be_said_is_answered_all_the_same() -> None:
    async def scenario(place: Place) -> None:
        async with place.visitor() as visitor:
            assert AudioStart.is_type((await visitor.ask(Synthesize(" "))).type)
            assert AudioStop.is_type((await visitor.hear() or Event("nothing")).type)

    served(scenario, voice=Tones())


# Our own clients


def a_sentence(text: str) -> Sentence:
    [sentence] = sentences(text)
    return sentence


def test_our_clients_understand_our_server() -> None:
    ears = Counting()

    async def scenario(place: Place) -> None:
        made = RemoteRecogniser(WyomingTranscription(place.server.address), SETTINGS.asr)
        found = await asyncio.to_thread(made.transcribe, COMMAND / np.float32(32768), ("kitchen",))
        assert isinstance(found, Transcript)
        assert found.text == f"{len(COMMAND)} samples"
        voice = WyomingVoice(place.server.address, "tones")
        pieces = [piece async for piece in spoken(voice, "Moved.")]
        expected = [piece async for piece in spoken(Tones(), "Moved.")]
        assert {piece.rate for piece in pieces} == {piece.rate for piece in expected}
        heard, said = (np.concatenate([piece.samples for piece in of]) for of in (pieces, expected))
        assert np.array_equal(heard, said)

    served(scenario, ears, Tones())
    assert ears.asked == [(len(COMMAND), ("kitchen",))]


@pytest.mark.model
def test_what_our_voice_says_to_our_recogniser_through_our_server_is_understood() -> None:
    try:
        recogniser = make_isolated_recogniser(SETTINGS)
        voice = make_synthesiser(SETTINGS)
    except ModelError as error:
        pytest.skip(str(error))

    async def scenario(place: Place) -> None:
        try:
            await conversation(place)
        finally:
            await voice.close()

    async def conversation(place: Place) -> None:
        await asyncio.to_thread(recogniser.load)
        made = RemoteRecogniser(WyomingTranscription(place.server.address), SETTINGS.asr)
        found = await asyncio.to_thread(made.transcribe, COMMAND / np.float32(32768))
        assert isinstance(found, Transcript)
        assert "kitchen" in found.text.casefold()
        async with place.visitor() as visitor:
            start = AudioStart.from_event(await visitor.ask(Synthesize("Turn left and go to the kitchen.")))
            chunks = []
            while AudioChunk.is_type((event := await visitor.hear() or Event("nothing")).type):
                chunks.append(AudioChunk.from_event(event))
            assert start.rate == chunks[0].rate
            answer = await visitor.ask(Transcribe(), AudioStart(start.rate, 2, 1), *chunks, AudioStop())
            assert "kitchen" in text_of(answer).casefold()

    try:
        served(scenario, recogniser, voice)
    finally:
        recogniser.close()


# Who does not


BROKEN = [
    (b"GET / HTTP/1.1\r\nHost: robot\r\n\r\n", "not-wyoming"),
    (b"[1, 2]\n", "not-wyoming"),
    (b'{"data": {}}\n', "not-wyoming"),
    (b"[" * 5000 + b"\n", "not-wyoming"),
    (b'{"type": "describe", "data_length": 99999999999}\n', "not-wyoming"),
    (b'{"type": "audio-chunk", "payload_length": 99999999999}\n', "not-wyoming"),
    (b'{"type": "audio-chunk", "payload_length": -3}\n', "not-wyoming"),
    (b'{"type": "audio-chunk", "data": {"rate": 16000}}\n', "not-wyoming"),
    (b'{"type": "audio-chunk", "data": {"rate": 0, "width": 2, "channels": 1}}\n', "audio-format"),
    (b'{"type": "audio-chunk", "data": {"rate": "x", "width": 2, "channels": 1}}\n', "not-wyoming"),
    (b'{"type": "transcribe", "data": {"language": 7}}\n', "not-wyoming"),
    (b'{"type": "transcribe", "data": {"language": "xx-klingon"}}\n', "language"),
    (b'{"type": "synthesize", "data": {"text": 7}}\n', "not-wyoming"),
    (b'{"type": "synthesize", "data": {"text": ["a"]}}\n', "not-wyoming"),
    (b'{"type": "synthesize", "data": {"text": {"a": "b"}}}\n', "not-wyoming"),
    (b'{"type": "synthesize", "data": {"text": "' + b"a" * (LONGEST_TEXT + 1) + b'"}}\n', "too-long"),
    (b"x" * (wyoming.LINE_BYTES + 10), "not-wyoming"),
    (bytes(range(256)), "not-wyoming"),
]


@pytest.mark.parametrize(("words", "code"), BROKEN)
def test_who_speaks_something_else_is_told_so_and_shown_out(words: bytes, code: str) -> None:
    async def scenario(place: Place) -> None:
        async with place.socket() as (reader, writer):
            writer.write(words)
            event = await wyoming.read(reader)
            assert event is not None
            assert Error.from_event(event).code == code
            assert await reader.read() == b""
        assert len(place.told) == 1
        async with place.visitor() as visitor:
            assert text_of(await visitor.ask(*sound())) == f"{len(COMMAND)} samples", "others are served"

    served(scenario, Counting(), Tones())


@trials(max_examples=60)
@given(st.binary(max_size=300), st.booleans())
def test_no_garbage_does_any_harm(garbage: bytes, begun: bool) -> None:
    async def scenario(place: Place) -> None:
        async with place.socket() as (reader, writer):
            writer.write((b'{"type": "audio-chunk", "data_length": 40}\n' if begun else b"") + garbage)
            writer.write_eof()
            await reader.read()
        async with place.visitor() as visitor:
            assert Info.is_type((await visitor.ask(Describe())).type)

    served(scenario, Counting())


def test_who_closes_their_side_after_asking_is_answered() -> None:
    ears = Counting(free=False)

    async def scenario(place: Place) -> None:
        async with place.socket() as (reader, writer):
            writer.writelines(wire(event) for event in (*sound(), Ping("and")))
            writer.write_eof()
            await asyncio.to_thread(ears.busy.wait, LIMIT_S)
            ears.free.set()
            told, pong = [await wyoming.read(reader) for _ in range(2)]
            assert told is not None
            assert text_of(told) == f"{len(COMMAND)} samples"
            assert pong is not None
            assert Pong.from_event(pong).text == "and"
            assert await reader.read() == b""

    served(scenario, ears)


@pytest.mark.parametrize("cut", [10, 70, 130, 900])
def test_who_leaves_in_the_midst_of_a_sound_asks_for_nothing(cut: int) -> None:
    ears = Counting()

    async def scenario(place: Place) -> None:
        stream = b"".join(wire(event) for event in sound()[:-1])
        async with place.socket() as (reader, writer):
            writer.write(stream[:cut])
            writer.write_eof()
            assert await reader.read() == b""
        async with place.visitor() as visitor:
            assert Info.is_type((await visitor.ask(Describe())).type)

    served(scenario, ears)
    assert ears.asked == []


def wire(event: Eventable) -> bytes:
    told = event.event()
    data, payload = json.dumps(told.data).encode(), told.payload or b""
    head = {"type": told.type, "data_length": len(data), "payload_length": len(payload)}
    return json.dumps(head).encode() + b"\n" + data + payload


def test_events_may_come_in_pieces_of_any_size() -> None:
    async def scenario(place: Place) -> None:
        async with place.socket() as (reader, writer):
            stream = b"".join(wire(event) for event in sound(COMMAND[:4000]))
            for at in range(0, len(stream), 7):
                writer.write(stream[at : at + 7])
                await writer.drain()
            event = await wyoming.read(reader)
            assert event is not None
            assert text_of(event) == "4000 samples"

    served(scenario, Counting())


def test_more_sound_than_is_recognised_in_one_go_is_refused_and_not_kept() -> None:
    ears = Counting()

    async def scenario(place: Place) -> None:
        second = np.ones(RATE, np.int16)
        async with place.visitor() as visitor:
            answer = await visitor.ask(*sound(np.tile(second, int(LONGEST_S) + 5), chunk=RATE))
            assert Error.from_event(answer).code == "too-long"
        async with place.visitor() as visitor:
            answer = await visitor.ask(*sound(np.tile(second, int(LONGEST_S)), chunk=RATE))
            assert text_of(answer) == f"{int(LONGEST_S) * RATE} samples"

    served(scenario, ears)
    assert len(ears.asked) == 1


def test_pieces_without_sound_are_not_kept() -> None:
    recording = Recording()
    for _ in range(100):
        recording.add(AudioChunk(RATE, 2, 1, b""))
    recording.add(AudioChunk(RATE, 2, 1, COMMAND.tobytes()))
    assert len(recording._pieces) == 1
    assert np.array_equal(recording.samples(), COMMAND)


# Several


def test_two_at_once_are_both_answered_each_with_their_own() -> None:
    ears = Counting(free=False)

    async def scenario(place: Place) -> None:
        async with place.visitor() as one, place.visitor() as other:
            first = asyncio.create_task(one.ask(*sound(COMMAND[:5000])))
            await asyncio.to_thread(ears.busy.wait, LIMIT_S)
            second = asyncio.create_task(other.ask(*sound(COMMAND[:6000])))
            assert Info.is_type((await who_asks(place)).type), "while the recogniser is busy"
            ears.free.set()
            assert (text_of(await first), text_of(await second)) == ("5000 samples", "6000 samples")

    served(scenario, ears)


async def who_asks(place: Place) -> Event:
    async with place.visitor() as visitor:
        return await visitor.ask(Describe())


def test_who_leaves_while_the_recogniser_works_keeps_nobody_waiting_for_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(visit, "PATIENCE_S", 1.0)
    ears = Counting(free=False)

    async def scenario(place: Place) -> None:
        async with place.visitor() as visitor:
            await visitor.say(*sound())
            await asyncio.to_thread(ears.busy.wait, LIMIT_S)
        assert await asyncio.to_thread(ears.given_up.wait, LIMIT_S)
        ears.free.set()
        async with place.visitor() as visitor:
            assert text_of(await visitor.ask(*sound())) == f"{len(COMMAND)} samples"

    served(scenario, ears)


def test_one_too_many_is_told_that_it_is_busy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serving, "VISITORS", 1)

    async def scenario(place: Place) -> None:
        async with place.visitor() as visitor:
            await visitor.ask(Describe())
            async with place.visitor() as another:
                assert Error.from_event(await another.ask(Describe())).code == "busy"
            await visitor.ask(Describe())

    served(scenario, Counting())


def test_who_asks_nothing_gives_way_to_somebody_who_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serving, "IDLE_S", 0)

    async def scenario(place: Place) -> None:
        async with AsyncExitStack() as opened:
            idle = [await opened.enter_async_context(place.visitor()) for _ in range(serving.VISITORS)]
            for visitor in idle:
                await visitor.ask(Describe())
            newcomer = await opened.enter_async_context(place.visitor())
            assert Info.is_type((await newcomer.ask(Describe())).type)
            assert Error.from_event(await idle[0].hear()).code == "idle"  # who has been idle for longest
            await idle[1].ask(Describe())

    served(scenario, Counting())


def test_who_sends_sound_does_not_give_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serving, "VISITORS", 1)
    monkeypatch.setattr(serving, "IDLE_S", 0.001)

    async def scenario(place: Place) -> None:
        async with place.visitor() as visitor:
            await visitor.ask(Describe())
            await visitor.say(*sound()[:3], Ping())
            assert Pong.is_type((await visitor.hear()).type)
            async with place.visitor() as another:
                assert Error.from_event(await another.ask(Describe())).code == "busy"

    served(scenario, Counting())


def test_who_stops_in_the_midst_of_a_sound_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(visit, "PATIENCE_S", 0.1)

    async def scenario(place: Place) -> None:
        async with place.visitor() as visitor:
            await visitor.say(*sound()[:3])
            assert await visitor.hear() is None

    served(scenario, Counting())


def test_who_goes_on_with_pieces_without_sound_is_given_up_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(visit, "PATIENCE_S", 0.1)

    async def scenario(place: Place) -> None:
        async with place.socket() as (_, writer):
            writer.writelines(wire(event) for event in sound()[:3])
            await until_closed(writer, AudioChunk(RATE, 2, 1, b""))

    served(scenario, Counting())


def test_the_connection_of_one_who_takes_no_answer_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(visit, "PATIENCE_S", 0.1)

    async def scenario(place: Place) -> None:
        async with place.socket() as (_, writer):
            await until_closed(writer, Ping("of which the answer is as long" * 10_000))

    served(scenario, Counting())


async def until_closed(writer: asyncio.StreamWriter, event: Eventable) -> None:
    """Say this again and again until the other side has closed the connection."""
    async with asyncio.timeout(LIMIT_S):
        with suppress(ConnectionError):
            while True:
                writer.write(wire(event))
                await writer.drain()
                await asyncio.sleep(0)  # there may always be room


def test_a_recogniser_that_fails_is_an_error_that_says_so() -> None:
    class Broken(Counting):
        def transcribe(self, *arguments: object, **more: object) -> Transcript | Rejected:
            raise ModelError("The recogniser process has died.", hint="Say it again.")

    async def scenario(place: Place) -> None:
        async with place.visitor() as visitor:
            told = Error.from_event(await visitor.ask(*sound()))
            assert told.text == "The recogniser process has died. Say it again."

    served(scenario, Broken())


# Where


def test_an_address_that_is_taken_is_one_error() -> None:
    async def scenario(place: Place) -> None:
        with pytest.raises(DeviceError, match="--uri"):
            async with Server(place.server.offer, place.server.address):
                pass

    served(scenario, Counting())


@pytest.mark.parametrize(
    "address", ["", "127.0.0.1:10300", "tcp://:10300", "tcp://robot", "http://robot:1", "tcp://a:b"]
)
def test_what_is_no_address_is_said(address: str) -> None:
    with pytest.raises(UsageError, match="tcp://127"):
        is_private(address)


def test_only_loopback_is_private() -> None:
    assert [is_private(f"tcp://{host}:1") for host in ("127.0.0.1", "localhost", "[::1]")] == [True] * 3
    assert [is_private(f"tcp://{host}:1") for host in ("0.0.0.0", "192.168.1.2", "robot", "[::]")] == [False] * 4


# A voice elsewhere


def test_the_settings_name_a_voice_elsewhere() -> None:
    overrides = ("voice.backend=wyoming", "voice.server=tcp://127.0.0.1:10200", "voice.speaker=en_US-amy-low")
    voice = make_synthesiser(load_settings(overrides=overrides, environ={}))
    assert voice.name == "Wyoming at tcp://127.0.0.1:10200 (en_US-amy-low)"
    for wrong in (("voice.backend=wyoming",), ("voice.backend=wyoming", "voice.server=somewhere")):
        with pytest.raises(ConfigError, match="voice"):
            load_settings(overrides=wrong, environ={})


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (b"", "closed the connection"),
        (b"HTTP/1.1 400 Bad Request\r\n\r\n", "does not speak Wyoming"),
        (wire(Error("no such voice")), "reports an error: no such voice"),
        (wire(AudioStart(22_050, 2, 1)), "closed the connection"),
        (wire(AudioStart(22_050, 2, 1)) + wire(AudioStop()), "sent no sound"),
        (wire(AudioStart(22_050, 2, 1)) + wire(AudioChunk(22_050, 2, 1, b"")) + wire(AudioStop()), "sent no sound"),
        (wire(AudioStart(22_050, 2, 1)) + wire(AudioChunk(22_050, 2, 1, b"abc")), "does not speak Wyoming"),
        (wire(AudioChunk(22_050, 3, 1, b"abc")), "of a kind that is not understood"),
        (
            b'{"type": "audio-chunk", "data": {"rate": 1, "width": "\\u001b[2J\\n", "channels": 1}}\n',
            r"not understood here \(1 Hz, \[2J bytes, 1 channels\)",
        ),
        (wire(AudioChunk(8000, 2, 1, b"\0" * 2_000_000)), "does not come to the end"),
        (b'{"type": "audio-chunk", "payload_length": 99999999999}\n', "does not speak Wyoming"),
        (b'{"type": "audio-chunk", "payload_length": 100}\nshort', "cannot be used"),
    ],
)
def test_a_voice_server_that_fails_is_one_error(answer: bytes, message: str) -> None:
    async def speak(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await wyoming.read(reader)
        writer.write(answer)
        writer.close()

    async def scenario() -> None:
        async with await asyncio.start_server(speak, "127.0.0.1", 0) as server:
            voice = WyomingVoice(f"tcp://127.0.0.1:{server.sockets[0].getsockname()[1]}", limit_s=LIMIT_S)
            with pytest.raises(ModelError, match=message) as caught:
                _ = [piece async for piece in voice.synthesise(a_sentence("Moved."))]
            assert "voice.server" in caught.value.hint

    asyncio.run(scenario())


def test_a_voice_server_that_makes_no_sound_of_mere_signs_has_said_them() -> None:
    async def speak(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await wyoming.read(reader)
        writer.write(wire(AudioStart(22_050, 2, 1)) + wire(AudioStop()))
        writer.close()

    async def scenario() -> None:
        async with await asyncio.start_server(speak, "127.0.0.1", 0) as server:
            voice = WyomingVoice(f"tcp://127.0.0.1:{server.sockets[0].getsockname()[1]}", limit_s=LIMIT_S)
            assert [piece async for piece in voice.synthesise(a_sentence("…!"))] == []

    asyncio.run(scenario())


def test_a_voice_server_that_hangs_or_is_not_there_is_one_error() -> None:
    async def scenario() -> None:
        left = asyncio.Event()

        async def hang(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            await reader.read()
            left.set()
            writer.close()

        async with await asyncio.start_server(hang, "127.0.0.1", 0) as server:
            address = f"tcp://127.0.0.1:{server.sockets[0].getsockname()[1]}"
            with pytest.raises(ModelError, match="has not answered for"):
                _ = [piece async for piece in WyomingVoice(address, limit_s=0.2).synthesise(a_sentence("Moved."))]
            async with asyncio.timeout(LIMIT_S):
                await left.wait()
        with pytest.raises(ModelError, match="cannot be used"):
            _ = [piece async for piece in WyomingVoice(address).synthesise(a_sentence("Moved."))]

    asyncio.run(scenario())
