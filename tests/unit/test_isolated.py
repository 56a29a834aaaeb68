"""The recogniser in a process of its own: it says the same, and its end is neither the engine's nor left over."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import textwrap
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import psutil
import pytest

from config import load as load_settings
from config.schema import Asr, Endpoint, Vad
from engine import events
from engine.asr import isolated
from engine.asr.isolated import IsolatedRecogniser
from engine.asr.recogniser import Rejected, Transcript
from engine.asr.whisper import WhisperRecogniser
from engine.audio.endpoint import Utterance
from engine.audio.pipe import PushSource
from engine.audio.source import RATE
from engine.audio.vad import make_vad
from engine.bus import Bus
from engine.child import Child
from engine.clock import SystemClock
from engine.errors import ModelError
from engine.hearing.hearing import Hearing
from engine.lead import Lead
from engine.parts.ears import Ears
from engine.parts.loading import Sound
from engine.parts.part import Part
from tests.bench.wer import normalised
from tests.children import children
from tests.open_files import open_files
from tests.unit.test_whisper import NOUNS, SETTINGS, model_folder, recogniser, spoken

LIMIT_S = 30.0
"""s for what takes a moment; a test that waits longer has failed."""
ALIKE = 0.1
"""By how much likelihoods and probabilities of one sound may differ between two processes: on processors with AVX2 only
an int8 model does not calculate the same everywhere, and log-probabilities 0.04 apart were seen."""
NOISE_ALIKE = 0.5
"""The same for what is no speech: there 0.2 was seen."""
COMMAND = "go_to_the_kitchen.wav"
SENTENCES = ("go_to_the_bedroom_then_turn_around.wav", "move_forward_one_metre.wav", "turn_left_ninety_degrees.wav") * 3
ME = psutil.Process()


@pytest.fixture(autouse=True)
def _nothing_is_left() -> Iterator[None]:
    """Whatever a test does, no child and no thread of it survives."""
    before = set(threading.enumerate())
    yield
    assert workers() == []
    for thread in set(threading.enumerate()) - before:
        if thread.name != "tqdm_monitor":  # of the one recogniser in this process
            thread.join(LIMIT_S)
            assert not thread.is_alive(), thread.name


def workers() -> list[psutil.Process]:
    return children("engine.asr.worker")


@contextmanager
def own_process(folder: Path | None = None, settings: Asr = SETTINGS) -> Iterator[IsolatedRecogniser]:
    made = IsolatedRecogniser(folder or model_folder(), settings)
    try:
        yield made
    finally:
        made.close()


def once(act: Callable[[], object]) -> Callable[[], bool]:
    """A ``cancelled`` that does something the first time it is asked, which is in the middle of the decoding."""
    left = [act]

    def cancelled() -> bool:
        while left:
            left.pop()()
        return False

    return cancelled


def signalled(made: IsolatedRecogniser, number: signal.Signals) -> Callable[[], None]:
    def act() -> None:
        assert made.pid is not None
        os.kill(made.pid, number)

    return act


def understands(made: IsolatedRecogniser) -> bool:
    heard = made.transcribe(spoken(COMMAND), NOUNS)
    return isinstance(heard, Transcript) and heard.text == "Go to the kitchen."


# Answers


@pytest.mark.model
def test_it_answers_as_the_recogniser_in_this_process_does() -> None:
    noise = np.random.default_rng(0).normal(0, 0.05, 3 * RATE).astype(np.float32)
    silence = np.zeros(RATE, np.float32)
    sounds = [(spoken(COMMAND), False), (spoken(*SENTENCES[:2]), False), (noise, True), (silence, False)]
    with own_process() as made:
        for sound, quick in sounds:
            here = recogniser().transcribe(sound, NOUNS, quick=quick)
            there = made.transcribe(sound, NOUNS, quick=quick)
            assert_alike(there, here)
        assert made.transcribe(silence[:100]) == recogniser().transcribe(silence[:100])
        both = made.transcribe(sounds[1][0], NOUNS), recogniser().transcribe(sounds[1][0], NOUNS)
        for heard in both:
            assert isinstance(heard, Transcript)
            assert "1 meter" in " ".join(heard.others), "another way of writing it is told as well"
        lead = Lead("go to the kitchen", (spoken(COMMAND) * 32768).astype(np.int16))
        turn = spoken("turn_left_ninety_degrees.wav")
        assert made.transcribe(turn, lead=lead).text == recogniser().transcribe(turn, lead=lead).text
        assert "kitchen" not in made.transcribe(turn, lead=lead).text
        stop, texts = spoken("stop.wav"), ("Stop", "stop")
        assert made.likelihood(stop, texts) == pytest.approx(recogniser().likelihood(stop, texts), abs=ALIKE)
        assert made.likelihood(silence[:100], texts) is None
        assert made.name.rpartition(", ")[0] == recogniser().name.rpartition(", ")[0], "all but how long a pass takes"


def assert_alike(there: Transcript | Rejected, here: Transcript | Rejected) -> None:
    """The same words or the same reason, and likelihoods that differ by no more than two processes may."""
    assert there.decoding is not None
    assert here.decoding is not None
    assert there.decoding.decode_s > 0
    rounded = {"avg_logprob": there.decoding.avg_logprob, "no_speech_probability": there.decoding.no_speech_probability}
    alike = ALIKE if isinstance(here, Transcript) else NOISE_ALIKE
    for name, value in rounded.items():
        assert value == pytest.approx(getattr(here.decoding, name), abs=alike), name
    assert there.decoding == replace(here.decoding, decode_s=there.decoding.decode_s, **rounded)
    if isinstance(here, Transcript):
        assert isinstance(there, Transcript)
        assert normalised(there.text) == normalised(here.text)
        assert there.confidence == pytest.approx(here.confidence, abs=ALIKE)
    else:
        assert isinstance(there, Rejected)
        assert there.reason == here.reason


@pytest.mark.model
@pytest.mark.parametrize("fault", ["missing", "damaged", "another language"])
def test_a_model_that_cannot_be_loaded_is_the_same_error_each_time(tmp_path: Path, fault: str) -> None:
    folder, settings = tmp_path / "whisper-base", SETTINGS
    if fault == "damaged":
        folder.mkdir()
        for path in model_folder().iterdir():
            (folder / path.name).symlink_to(path)
        (folder / "model.bin").unlink()
        (folder / "model.bin").write_bytes(b"no model")
    if fault == "another language":
        folder, settings = model_folder(), SETTINGS.model_copy(update={"language": "tlh"})
    with pytest.raises(ModelError) as here:
        WhisperRecogniser(folder, settings).load()
    with own_process(folder, settings) as made:
        for ask in (made.load, lambda: made.transcribe(spoken(COMMAND))):
            with pytest.raises(ModelError) as there:
                ask()
            assert (there.value.message, there.value.hint) == (here.value.message, here.value.hint)
            assert workers() == []


# Changing one's mind


@pytest.mark.model
def test_it_is_told_of_a_cancellation_in_mid_decoding_and_hears_the_next_one() -> None:
    noise = np.random.default_rng(0).normal(0, 0.05, 3 * RATE).astype(np.float32)
    with own_process(settings=SETTINGS.model_copy(update={"max_no_speech": 1.0})) as made:
        asked = []

        def no_more() -> bool:
            asked.append(True)
            return True

        cancelled = made.transcribe(noise, cancelled=no_more)
        assert cancelled.decoding is not None
        assert cancelled.decoding.window_s == 10, "no second look"
        assert len(asked) == 1, "who has been told does not ask again"
        kept = made.transcribe(noise)
        assert kept.decoding is not None
        assert kept.decoding.window_s == 30
        assert understands(made)


@pytest.mark.model
def test_closing_in_mid_decoding_ends_it_at_once_and_for_good() -> None:
    with own_process() as made:
        made.load()
        (worker,) = workers()
        closer = threading.Thread(target=made.close)
        with pytest.raises(ModelError, match="has been closed"):
            made.transcribe(spoken(*SENTENCES), cancelled=once(closer.start))
        closer.join(LIMIT_S)
        assert not worker.is_running()
        for ask in (made.load, lambda: made.transcribe(spoken(COMMAND))):
            with pytest.raises(ModelError, match="has been closed"):
                ask()


@pytest.mark.model
def test_closing_while_the_model_loads_ends_it_at_once() -> None:
    with own_process() as made:
        errors: list[ModelError] = []

        def load() -> None:
            try:
                made.load()
            except ModelError as error:
                errors.append(error)

        loading = threading.Thread(target=load)
        loading.start()
        while made.pid is None and loading.is_alive():
            loading.join(0.001)
        made.close()
        loading.join(LIMIT_S)
        assert [error.message for error in errors] == ["The recogniser has been closed."]


@pytest.mark.model
def test_leaving_the_hearing_in_mid_decoding_leaves_nothing() -> None:
    async def scenario() -> list[events.Event]:
        published: list[events.Event] = []
        bus = Bus(SystemClock())
        bus.subscribe(published.append)
        endpoint = Endpoint(
            pre_roll_s=0.3,
            start_s=0.1,
            silence_s=0.6,
            complete_s=0.35,
            incomplete_s=1.2,
            max_length_s=15,
            no_speech_s=2,
        )
        made = IsolatedRecogniser(model_folder(), SETTINGS)
        samples = (spoken(*SENTENCES) * 32767).astype(np.int16)
        vad = make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5))
        async with Hearing(PushSource, vad, endpoint, made) as hearing:
            await hearing.load()
            utterance = Utterance(samples, 0.0, len(samples) / RATE, 5.0)
            work = asyncio.create_task(hearing.transcribe(utterance, bus.bound(turn=None, epoch=1)))
            await asyncio.sleep(0)
        assert workers() == []
        await asyncio.gather(work, return_exceptions=True)
        return published

    assert asyncio.run(scenario()) == []


@pytest.mark.model
def test_ears_that_close_while_the_model_loads_leave_nothing() -> None:
    model_folder()

    async def scenario() -> None:
        part: Part[Hearing] = Part("recogniser", lambda status: None)
        ears = Ears(load_settings(), Sound("none"), Part("microphone", lambda status: None), part)
        keeping = asyncio.create_task(ears.keep())
        async with asyncio.timeout(LIMIT_S):
            while not workers():
                assert part.status.state == "loading"
                await asyncio.sleep(0.001)
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)
        assert workers() == []

    asyncio.run(scenario())


# A process that is lost


@pytest.mark.model
def test_a_process_that_dies_in_mid_decoding_is_an_error_that_says_so_and_the_next_one_hears() -> None:
    with own_process() as made:
        made.load()
        first = made.pid
        for number in (signal.SIGKILL, signal.SIGSEGV):
            with pytest.raises(ModelError, match=f"recogniser process was killed by {number.name}") as caught:
                made.transcribe(spoken(*SENTENCES), cancelled=once(signalled(made, number)))
            assert "Say it again" in caught.value.hint
        assert made.pid is None
        assert understands(made)
        assert made.pid not in (None, first)


@pytest.mark.model
def test_a_process_that_dies_while_nobody_waits_for_it_is_replaced() -> None:
    with own_process() as made:
        made.load()
        (worker,) = workers()
        worker.kill()
        os.waitid(os.P_PID, worker.pid, os.WEXITED | os.WNOWAIT)
        assert understands(made)
        assert made.pid != worker.pid


@pytest.mark.model
def test_a_process_that_never_answers_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    with own_process() as made:
        made.load()
        (worker,) = workers()
        with monkeypatch.context() as impatient:
            impatient.setattr(isolated, "ANSWER_LIMIT_S", 0.2)
            with pytest.raises(ModelError, match=r"has not answered for 0\.2 s"):
                made.transcribe(spoken(COMMAND), cancelled=once(signalled(made, signal.SIGSTOP)))
        assert not worker.is_running()


@pytest.mark.model
def test_a_process_that_cannot_be_started_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    with own_process() as made, monkeypatch.context() as broken:
        broken.setattr(sys, "executable", "/nonexistent/python")
        with pytest.raises(ModelError, match="recogniser process cannot be started"):
            made.load()


@pytest.mark.parametrize(
    "said",
    [
        b"\xff\xff\xff\xff",  # too long
        b"\x05\x00\x00\x00hello",  # no message
        b"\x01\x00\x00\x00\x01",  # a number
        b"\x0d\x00\x00\x00\x81\xa4type\xa6Nobody",  # an answer that does not exist
        b"\x22\x00\x00\x00\x83\xa4type\xa6Failed\xa7message\xa4oops\xa4hint\xc3____",  # a hint that is no text
    ],
    ids=["too long", "no message", "a number", "unknown", "wrong type"],
)
def test_an_answer_that_makes_no_sense_is_an_error(monkeypatch: pytest.MonkeyPatch, said: bytes) -> None:
    monkeypatch.setattr(isolated, "_WORKER", "tests.babbler")
    others = ME.children()
    with own_process(Path(said.hex())) as made:
        with pytest.raises(ModelError, match="unreadable"):
            made.load()
        assert made.pid is None
        assert ME.children() == others


def test_a_request_that_makes_no_sense_ends_the_process_with_a_word(tmp_path: Path) -> None:
    model = SETTINGS.model_dump_json()
    child = Child("recogniser", "engine.asr.worker", (f"--folder={tmp_path}", f"--settings={model}", "--unknown"))
    assert "unrecognized arguments: --unknown" in (child.epitaph(wait=LIMIT_S) or "")
    child.release()
    child = Child("recogniser", "engine.asr.worker", (f"--folder={model_folder()}", f"--settings={model}"))
    child.link.sendall(b"\x05\x00\x00\x00hello")
    assert "does not speak to a recogniser" in (child.epitaph(wait=LIMIT_S) or "")
    child.release()


# Whoever made it


HOST = textwrap.dedent(
    """
    import os, sys, threading
    from pathlib import Path
    from engine.asr.isolated import IsolatedRecogniser
    from tests.unit.test_isolated import SENTENCES
    from tests.unit.test_whisper import SETTINGS, spoken

    made = IsolatedRecogniser(Path(sys.argv[1]), SETTINGS)
    if sys.argv[2] == "decodes":
        made.load()
        said = []
        def cancelled():
            if not said:
                said.append(print(made.pid, flush=True))
            return False
        while True:
            made.transcribe(spoken(*SENTENCES), cancelled=cancelled)
    threading.Thread(target=made.load, daemon=True).start()
    while made.pid is None:
        pass
    print(made.pid, flush=True)
    threading.Event().wait()
    """
)


@pytest.mark.model
@pytest.mark.parametrize("moment", ["decodes", "loads"])
def test_the_process_ends_when_the_engine_is_killed(moment: str) -> None:
    argv = [sys.executable, "-c", HOST, str(model_folder()), moment]
    with subprocess.Popen(argv, stdout=subprocess.PIPE, text=True) as engine:
        assert engine.stdout is not None
        worker = psutil.Process(int(engine.stdout.readline()))
        assert worker.cmdline()
        engine.kill()
    assert psutil.wait_procs([worker], timeout=LIMIT_S)[1] == []


@pytest.mark.model
def test_the_terminals_signals_do_not_reach_it() -> None:
    with own_process() as made:
        made.load()
        (worker,) = workers()
        assert os.getsid(worker.pid) == worker.pid != os.getsid(0)
        made.transcribe(spoken(COMMAND), cancelled=once(signalled(made, signal.SIGINT)))
        assert understands(made)
        assert made.pid == worker.pid


@pytest.mark.model
def test_it_can_be_made_and_closed_again_and_again_without_leaving_anything() -> None:
    with own_process() as made:
        made.load()
    before = open_files()
    for _ in range(2):
        with own_process() as made:
            made.load()
            made.close()
    assert open_files() == before
