"""Real voices in processes of their own: they speak, tell which words have been said, and leave nothing behind."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import threading
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Coroutine, Iterator
from contextlib import aclosing, asynccontextmanager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import psutil
import pytest
import soxr

from config import load as load_settings
from config.schema import Settings
from engine.asr.recogniser import Transcript
from engine.asr.whisper import WhisperRecogniser
from engine.audio.source import RATE
from engine.errors import ModelError
from engine.parts.loading import make_synthesiser, model_store
from engine.tts import espeak, isolated, piper
from engine.tts.choice import ByLanguage
from engine.tts.isolated import IsolatedVoice
from engine.tts.sentences import Sentence, sentences
from engine.tts.synthesis import Piece, Synthesiser, VoiceLost
from tests.bench.wer import errors, normalised
from tests.children import children

T = TypeVar("T")
LIMIT_S = 60.0
"""s for what takes a moment; a test that waits longer has failed."""
TEXT = "Moved 1.00 m forward. I am in the kitchen, next to the table."


class Stage:
    """A voice that stays while the tests of this file come and go, in a loop of its own: loading one takes a while."""

    def __init__(self, voice: IsolatedVoice) -> None:
        self.voice = voice
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever)
        self._thread.start()

    def run(self, work: Coroutine[Any, Any, T]) -> T:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(LIMIT_S)

    def close(self) -> None:
        self.run(self.voice.close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(LIMIT_S)
        assert not self._thread.is_alive()
        self._loop.close()


@pytest.fixture(scope="module")
def stages() -> Iterator[dict[str, Stage]]:
    found: dict[str, Stage] = {}
    yield found
    for stage in found.values():
        stage.close()
    assert workers() == []


@pytest.fixture(params=("piper", "espeak"))
def stage(request: pytest.FixtureRequest, stages: dict[str, Stage]) -> Stage:
    backend: str = request.param
    if backend not in stages:
        voice = the_voice(backend)
        assert isinstance(voice, IsolatedVoice)
        stages[backend] = Stage(voice)
    return stages[backend]


@pytest.fixture(autouse=True)
def _nothing_is_left(stages: dict[str, Stage]) -> Iterator[None]:
    """Whatever a test does, no child of it survives."""
    yield
    kept = {stage.voice.pid for stage in stages.values()}
    assert [child for child in workers() if child.pid not in kept] == []


def workers() -> list[psutil.Process]:
    return children("engine.tts.worker")


def settings(*overrides: str) -> Settings:
    return load_settings(overrides=overrides, environ={}, user_folder=Path("no-such-folder"))


def the_voice(backend: str, *overrides: str) -> Synthesiser:
    """A voice that is on this machine; skips the test where it is not, and says why."""
    if backend == "espeak" and not espeak.is_installed():
        pytest.skip(f"espeak-ng is not installed. {espeak.INSTALL}")
    if backend == "piper" and not piper.is_installed():
        pytest.skip(f"piper is not installed. {piper.INSTALL}")
    try:
        return make_synthesiser(settings(f"voice.backend={backend}", *overrides))
    except ModelError as error:
        pytest.skip(str(error))


@asynccontextmanager
async def speaking(backend: str, *overrides: str) -> AsyncIterator[IsolatedVoice]:
    voice = the_voice(backend, *overrides)
    assert isinstance(voice, IsolatedVoice)
    try:
        async with asyncio.timeout(LIMIT_S):
            yield voice
    finally:
        await voice.close()


async def said(voice: Synthesiser, sentence: Sentence) -> list[Piece]:
    async with aclosing(voice.synthesise(sentence)) as pieces:
        return [piece async for piece in pieces]


def a_sentence(text: str) -> Sentence:
    [sentence] = sentences(text)
    return sentence


def seconds(pieces: list[Piece]) -> float:
    return sum(len(piece.samples) / piece.rate for piece in pieces)


async def until(condition: Callable[[], bool]) -> None:
    """Wait for a state that nobody tells of."""
    async with asyncio.timeout(LIMIT_S):
        while not condition():  # noqa: ASYNC110
            await asyncio.sleep(0.01)


# Speaking


@pytest.mark.model
def test_a_voice_says_a_sentence_and_tells_when_each_word_has_ended(stage: Stage) -> None:
    sentence = a_sentence("I am in the kitchen next to the table.")
    pieces = stage.run(said(stage.voice, sentence))
    assert 1.0 < seconds(pieces) < 5.0
    assert max(np.abs(piece.samples.astype(int)).max() for piece in pieces) > 3000
    ends = [each for piece in pieces for each in piece.said]
    assert [each.count for each in ends] == sorted({each.count for each in ends})
    assert [each.at for each in ends] == sorted(each.at for each in ends)
    assert ends[-1].count == len(sentence.words)
    assert 0.6 * seconds(pieces) < ends[-1].at <= seconds(pieces) + 0.001
    assert len(ends) > len(sentence.words) // 2


@pytest.mark.model
@pytest.mark.parametrize("text", ["Fine.", "I am here.", "She found it."])
def test_what_it_says_begins_at_once(stage: Stage, text: str) -> None:
    first = stage.run(said(stage.voice, a_sentence(text)))[0]
    begins = int(np.flatnonzero(np.abs(first.samples.astype(int)) > 200)[0]) / first.rate
    assert begins < 0.03


@pytest.mark.model
def test_what_it_says_is_understood(stage: Stage) -> None:
    sound = []
    for sentence in sentences(TEXT):
        for piece in stage.run(said(stage.voice, sentence)):
            sound.append(soxr.resample(piece.samples.astype(np.float32) / 32768, piece.rate, RATE))
        sound.append(np.zeros(RATE // 4, np.float32))
    recogniser = WhisperRecogniser(model_store(settings()).find("whisper-base"), settings().asr)
    heard = recogniser.transcribe(np.concatenate(sound))
    assert isinstance(heard, Transcript)
    spoken = normalised("Moved 1 metre forward. I am in the kitchen next to the table.")
    assert errors(spoken, normalised(heard.text)) <= 3


@pytest.mark.model
def test_at_twice_the_speed_it_takes_less_time(stage: Stage) -> None:
    async def scenario() -> list[Piece]:
        async with speaking(stage.voice.name.partition("-")[0].partition(" ")[0], "voice.speed=2") as voice:
            return await said(voice, a_sentence(words))

    words = "I am in the kitchen next to the table"
    slow, fast = stage.run(said(stage.voice, a_sentence(words))), asyncio.run(scenario())
    assert seconds(fast) < 0.8 * seconds(slow)  # a voice never says a sentence in quite the same way again


def test_espeak_says_chinese_too_a_character_at_a_time() -> None:
    async def scenario() -> None:
        async with speaking("espeak") as voice:
            chinese, english = a_sentence("我在厨房，离桌子 0.5 m。"), a_sentence("I am in the kitchen")
            assert chinese.chinese
            pieces = await said(voice, chinese)
            assert 1.0 < seconds(pieces) < 6.0
            counts = [each.count for piece in pieces for each in piece.said]
            assert len(counts) >= 5
            assert counts[-1] == len(chinese.words)
            assert 0.5 < seconds(await said(voice, english)) < 3.0

    asyncio.run(scenario())


@pytest.mark.parametrize("text", ["—", "…", "???", "\0", "😀", "a" * 2000, "<b> &amp; [[x]]", "﷽" * 50])
def test_nothing_that_can_be_written_confuses_it(stage: Stage, text: str) -> None:
    for sentence in sentences(text):
        stage.run(said(stage.voice, sentence))
    assert seconds(stage.run(said(stage.voice, a_sentence("Stopped.")))) > 0.2


# Changing one's mind


@pytest.mark.model
def test_what_nobody_wants_to_hear_any_more_does_not_get_into_the_next_sentence(stage: Stage) -> None:
    async def changes_its_mind() -> list[Piece]:
        saying = asyncio.create_task(said(stage.voice, a_sentence("a very long sentence " * 7)))
        await until(lambda: stage.voice._number > before)  # it is asked
        saying.cancel()
        await asyncio.gather(saying, return_exceptions=True)
        return await said(stage.voice, a_sentence("Stopped."))

    alone = seconds(stage.run(said(stage.voice, a_sentence("Stopped."))))
    pid = stage.voice.pid
    for _ in range(3):
        before = stage.voice._number
        assert seconds(stage.run(changes_its_mind())) == pytest.approx(alone, rel=0.3)
    assert stage.voice.pid == pid


@pytest.mark.model
def test_at_whatever_moment_somebody_changes_their_mind_the_next_sentence_is_whole(stage: Stage) -> None:
    async def gives_up_after(steps: int) -> list[Piece]:
        saying = asyncio.create_task(said(stage.voice, a_sentence("I am in the kitchen next to the table.")))
        for _ in range(steps):  # of the loop
            await asyncio.sleep(0)
        saying.cancel()
        await asyncio.gather(saying, return_exceptions=True)
        return await said(stage.voice, a_sentence("Yes."))

    alone = seconds(stage.run(said(stage.voice, a_sentence("Yes."))))
    for steps in range(0, 400, 20):
        assert seconds(stage.run(gives_up_after(steps))) == pytest.approx(alone, rel=0.5)


def test_one_that_is_closed_in_the_middle_of_a_sentence_leaves_whoever_waits_with_an_error() -> None:
    async def scenario() -> None:
        async with speaking("espeak") as voice:
            await voice.load()
            pid = voice.pid
            assert pid is not None
            os.kill(pid, signal.SIGSTOP)
            saying = asyncio.create_task(said(voice, a_sentence("Hello.")))
            await until(lambda: voice._number == 1)
            await voice.close()
            with pytest.raises(ModelError):
                await saying

    asyncio.run(scenario())


# The process


def test_a_process_that_is_killed_is_an_error_and_the_next_sentence_starts_another() -> None:
    async def scenario() -> None:
        async with speaking("espeak") as voice:
            await voice.load()
            first = voice.pid
            assert first is not None
            os.kill(first, signal.SIGSTOP)
            saying = asyncio.create_task(said(voice, a_sentence("Hello.")))
            await until(lambda: voice._number == 1)
            os.kill(first, signal.SIGKILL)
            with pytest.raises(ModelError, match="SIGKILL"):
                await saying
            assert first not in {worker.pid for worker in workers()}
            assert seconds(await said(voice, a_sentence("Hello."))) > 0.2
            second = voice.pid
            assert second not in (None, first)
            assert second is not None
            os.kill(second, signal.SIGKILL)
            ended = voice._child
            assert ended is not None
            await until(lambda: ended.epitaph() is not None)  # its first thread is a zombie before the others are gone
            assert seconds(await said(voice, a_sentence("Hello."))) > 0.2  # nobody was waiting: nothing is lost

    asyncio.run(scenario())


def test_a_process_that_does_not_get_ready_is_not_waited_for_by_one_sentence_after_the_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def scenario() -> None:
        async with speaking("espeak") as voice:
            with monkeypatch.context() as broken:
                broken.setattr(isolated, "_WORKER", "no_such_worker")
                with pytest.raises(VoiceLost, match="no_such_worker") as lost:
                    await voice.load()
                assert lost.value.hint == "", "whoever loads it knows better"
                with pytest.raises(VoiceLost, match="no_such_worker") as lost:
                    await said(voice, a_sentence("Hello."))
                assert "after 60 s" in lost.value.hint
            with pytest.raises(VoiceLost, match="no_such_worker"):
                await said(voice, a_sentence("Hello."))
            assert voice.pid is None
            voice._broken = (asyncio.get_running_loop().time(), "")
            assert seconds(await said(voice, a_sentence("Hello."))) > 0.2

    asyncio.run(scenario())


def test_the_process_goes_with_the_engine_however_that_dies() -> None:
    the_voice("espeak")
    code = (
        "import asyncio, time\n"
        "from engine.tts.isolated import IsolatedVoice\n"
        "async def main():\n"
        "    voice = IsolatedVoice('espeak-ng', 'espeak')\n"
        "    await voice.load()\n"
        "    print(voice.pid, flush=True)\n"
        "    time.sleep(600)\n"
        "asyncio.run(main())\n"
    )
    host = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert host.stdout is not None
    worker = psutil.Process(int(host.stdout.readline()))
    host.kill()
    host.wait()
    host.stdout.close()
    worker.wait(LIMIT_S)


@pytest.mark.parametrize("fault", ["missing", "damaged"])
def test_a_piper_voice_that_cannot_be_loaded_is_an_error_that_names_it(tmp_path: Path, fault: str) -> None:
    if not piper.is_installed():
        pytest.skip(f"piper is not installed. {piper.INSTALL}")
    file = tmp_path / "en.onnx"
    if fault == "damaged":
        file.write_bytes(b"no model")
        (tmp_path / "en.onnx.json").write_text("{}")

    async def scenario() -> None:
        voice = make_synthesiser(settings("voice.backend=piper", f"voice.model={file}"))
        for _ in range(2):
            with pytest.raises(ModelError) as error:
                await voice.load()
            assert str(file) in error.value.message
            assert "voice.model" in error.value.hint
        await voice.close()

    asyncio.run(scenario())


def test_an_espeak_voice_that_there_is_not_is_an_error_that_says_where_to_look() -> None:
    async def scenario() -> None:
        async with speaking("espeak", "voice.speaker=klingonese") as voice:
            with pytest.raises(ModelError, match="klingonese") as error:
                await voice.load()
            assert "--voices" in error.value.hint

    asyncio.run(scenario())


def test_the_engine_itself_never_loads_what_is_under_the_gpl() -> None:
    the_voice("espeak")
    code = (
        "import asyncio, sys\n"
        "from engine.tts.isolated import IsolatedVoice\n"
        "from engine.tts.sentences import sentences\n"
        "import engine.engine, engine.parts.loading\n"
        "async def main():\n"
        "    voice = IsolatedVoice('espeak-ng', 'espeak')\n"
        "    async for piece in voice.synthesise(next(sentences('Hello.'))):\n"
        "        assert len(piece.samples)\n"
        "    await voice.close()\n"
        "asyncio.run(main())\n"
        "assert not {'piper', 'onnxruntime', 'sounddevice'} & set(sys.modules), sys.modules.keys()\n"
        "maps = open('/proc/self/maps').read()\n"
        "assert 'espeak' not in maps and 'piper' not in maps\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


# Which voice there is


class _Voice:
    """A voice of which one only wants to know whether it was asked."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.asked: list[str] = []
        self.trouble: ModelError | None = None
        """Why it cannot be loaded."""
        self.closed = False

    async def load(self) -> None:
        if self.trouble is not None:
            raise self.trouble

    async def synthesise(self, sentence: Sentence) -> AsyncGenerator[Piece]:
        self.asked.append(sentence.joined()[0])
        yield Piece(np.ones(10, np.int16), RATE)

    async def close(self) -> None:
        self.closed = True


def test_english_goes_to_one_voice_and_chinese_to_the_other_or_is_only_shown() -> None:
    async def scenario() -> None:
        english, others, told = _Voice("a"), _Voice("b"), []
        both = ByLanguage(english, others)
        alone = ByLanguage(english, None, told.append)
        for sentence in sentences("Hello. 你好。再见。"):
            await said(both, sentence)
            await said(alone, sentence)
        assert english.asked == ["Hello.", "Hello."]
        assert others.asked == ["你好。", "再见。"]
        assert told == ["Chinese answers are only shown: install espeak-ng to hear them."]

    asyncio.run(scenario())


def test_a_chinese_voice_says_chinese_and_english_goes_to_the_other_or_is_only_shown() -> None:
    async def scenario() -> None:
        chinese, others, told = _Voice("a"), _Voice("b"), []
        both = ByLanguage(chinese, others, chinese=True)
        alone = ByLanguage(chinese, None, told.append, chinese=True)
        for sentence in sentences("Hello. 你好。再见。"):
            await said(both, sentence)
            await said(alone, sentence)
        assert chinese.asked == ["你好。", "你好。", "再见。", "再见。"]
        assert others.asked == ["Hello."]
        assert told == ["English answers are only shown: install espeak-ng to hear them."]

    asyncio.run(scenario())


def test_a_second_voice_that_is_lost_while_it_loads_is_tried_again_with_the_next_sentence() -> None:
    async def scenario() -> None:
        english, others, told = _Voice("a"), _Voice("b"), []
        others.trouble = VoiceLost("The voice was killed.")
        both = ByLanguage(english, others, told.append)
        await both.load()
        for sentence in sentences("你好。"):
            await said(both, sentence)
        assert others.asked == ["你好。"]
        assert told == []

    asyncio.run(scenario())


def test_a_voice_for_chinese_that_does_not_load_leaves_the_english_one_and_is_told_once() -> None:
    async def scenario() -> None:
        english, others, told = _Voice("a"), _Voice("b"), []
        others.trouble = ModelError("espeak-ng cannot be used: its data are missing.", hint=espeak.INSTALL)
        both = ByLanguage(english, others, told.append)
        await both.load()
        for sentence in sentences("Hello. 你好。再见。"):
            await said(both, sentence)
        assert both.name == "a"
        assert english.asked == ["Hello."]
        assert others.closed
        assert told == [f"Chinese answers are only shown. {others.trouble}"]
        await both.close()

    asyncio.run(scenario())


def test_without_the_english_voice_there_is_none() -> None:
    async def scenario() -> None:
        english = _Voice("a")
        english.trouble = ModelError("The voice is damaged.")
        with pytest.raises(ModelError, match="damaged"):
            await ByLanguage(english, _Voice("b")).load()

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("piper_there", "model_there", "espeak_there", "expected"),
    [
        (True, True, True, "piper (en_US-joe-medium), espeak-ng"),
        (True, True, False, "piper (en_US-joe-medium)"),
        (True, False, True, "espeak-ng"),
        (False, True, True, "espeak-ng"),
        (True, False, False, "sayso models pull piper-joe"),
        (False, False, False, "pip install 'sayso[voice]'"),
    ],
)
def test_auto_takes_what_there_is_and_says_what_to_install_where_there_is_nothing(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    piper_there: bool,
    model_there: bool,
    espeak_there: bool,
    expected: str,
) -> None:
    monkeypatch.setattr(piper, "is_installed", lambda: piper_there)
    monkeypatch.setattr(espeak, "is_installed", lambda: espeak_there)
    wanted = settings(f"models.folder={tmp_path}")
    if model_there:
        store = model_store(wanted)
        for file in store.manifest["piper-joe"].files:
            path = tmp_path / "piper-joe" / file.name
            path.parent.mkdir(exist_ok=True)
            with path.open("wb") as sparse:
                sparse.truncate(file.size)
    try:
        found = make_synthesiser(wanted).name
    except ModelError as error:
        found = str(error)
    assert expected in found
    if "install" not in expected and "pull" not in expected:
        assert found == expected


@pytest.mark.parametrize(("backend", "hint"), [("piper", "sayso[voice]"), ("espeak", "apt install espeak-ng")])
def test_a_voice_that_was_asked_for_and_is_not_installed_is_an_error(
    monkeypatch: pytest.MonkeyPatch, backend: str, hint: str
) -> None:
    monkeypatch.setattr(piper, "is_installed", lambda: False)
    monkeypatch.setattr(espeak, "is_installed", lambda: False)
    with pytest.raises(ModelError, match="not installed") as error:
        make_synthesiser(settings(f"voice.backend={backend}"))
    assert hint in error.value.hint
