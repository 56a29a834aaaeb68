"""Sources that go away and come, what they lose, and how loud each of them is."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest

from config.schema import Vad
from engine import events
from engine.asr.recogniser import Rejected
from engine.audio.endpoint import Utterance
from engine.audio.gain import Gain
from engine.audio.pipe import PushSource
from engine.audio.source import RATE
from engine.audio.vad import make_vad
from engine.bus import Bus
from engine.clock import SystemClock
from engine.errors import DeviceError, SaysoError
from engine.hearing.hearing import Hearing, NothingHeard
from engine.hearing.intake import WARN_S
from tests.unit.hears import COMMAND, ENDPOINT, Scripted, all_read, ears, pushed, quiet

# A microphone that goes away


class Unplugged(PushSource):
    """A live source that is lost when it has said its piece."""

    async def __aenter__(self) -> PushSource:
        self._queue.end(DeviceError("The microphone is gone."))
        return self


def test_a_lost_microphone_ends_the_listening_and_another_one_is_heard_in_its_place() -> None:
    ends: list[SaysoError | None] = []

    async def scenario() -> None:
        async with ears(Unplugged, on_end=ends.append) as it:
            with pytest.raises(DeviceError, match="is gone"):
                await it.hearing.listen(it.emit)
            assert it.last() == events.ListenEnded("device_lost", 0.0, 0.0)
            assert [str(error) for error in ends] == ["The microphone is gone."]
            with pytest.raises(DeviceError, match="is gone"):  # as long as nobody brings another one
                await it.hearing.listen(it.emit)
            await it.hearing.hear(pushed(COMMAND, quiet(1), end=True))
            it.hearing.mark()
            assert isinstance(await it.hearing.listen(it.emit), Utterance)

    asyncio.run(scenario())


def test_a_microphone_that_was_never_there_can_still_come() -> None:
    class Absent(PushSource):
        async def __aenter__(self) -> PushSource:
            raise DeviceError("There is no microphone.")

    async def scenario() -> None:
        it = Hearing(Absent, make_vad(Vad(backend="auto", gate_mode=3, threshold=0.5)), ENDPOINT, Scripted())
        with pytest.raises(DeviceError):
            await it.__aenter__()
        emit = Bus(SystemClock()).bound(turn=None, epoch=1)
        with pytest.raises(DeviceError, match="no microphone"):
            await it.listen(emit)
        with pytest.raises(DeviceError):
            await it.hear(Absent())
        await it.hear(pushed(COMMAND, quiet(1), end=True))
        assert isinstance(await it.listen(emit), Utterance)
        await it.__aexit__(None, None, None)

    asyncio.run(scenario())


def test_somebody_who_listens_goes_on_with_the_source_that_takes_the_place_of_the_first() -> None:
    async def scenario() -> None:
        ends: list[SaysoError | None] = []
        half = len(COMMAND) // 2
        async with ears(lambda: pushed(quiet(0.3), COMMAND[:half]), on_end=ends.append) as it:
            listening = asyncio.create_task(it.hearing.listen(it.emit))
            await all_read()
            assert it.kinds == ["listen.started"]
            await it.hearing.hear(pushed(COMMAND[half:], quiet(1), end=True))
            heard = await listening
            assert isinstance(heard, Utterance)
            assert heard.speech_s > 0.6  # either half has less
            assert it.kinds == ["listen.started", "listen.ended"]
            await all_read()
            assert ends == [None]  # of the second one: the first was closed by us

    asyncio.run(scenario())


def test_closing_ends_the_listening() -> None:
    async def scenario() -> None:
        async with ears(PushSource) as it:
            listening = asyncio.create_task(it.hearing.listen(it.emit))
            await all_read()
            assert it.kinds == ["listen.started"]
        heard = await listening
        assert isinstance(heard, NothingHeard)
        assert heard.reason == "source_ended"

    asyncio.run(scenario())


class Overrun(PushSource):
    """A device that loses sound now and then."""

    overruns = 1

    @property
    def warnings(self) -> tuple[str, ...]:
        return (f"The device lost sound {self.overruns} times.",)


def test_lost_sound_is_told_after_the_listening_and_only_once() -> None:
    async def scenario() -> None:
        source = Overrun()
        async with ears(lambda: source) as it:

            async def listened() -> list[str]:
                del it.published[:]
                source.push(np.concatenate((COMMAND, quiet(1))).tobytes())
                await it.hearing.listen(it.emit)
                return [event.body.message for event in it.published if isinstance(event.body, events.Log)]

            assert await listened() == ["The device lost sound 1 times."]
            assert await listened() == []
            source.overruns = 5
            assert await listened() == ["The device lost sound 5 times."]

    asyncio.run(scenario())


def test_what_a_source_loses_while_nobody_listens_is_told_now_and_then() -> None:
    async def scenario() -> None:
        source, told = Overrun(), list[str]()
        async with ears(lambda: source, warn=told.append):
            source.push(quiet(WARN_S - 1).tobytes())
            await all_read()
            assert told == []
            for lost in (2, 3):  # both within the next few seconds
                source.overruns = lost
                source.push(quiet(1.5).tobytes())
                await all_read()
            assert told == ["The device lost sound 2 times."]

    asyncio.run(scenario())


class Exclusive(PushSource):
    """A device that one can have at a time."""

    taken = False

    async def __aenter__(self) -> Exclusive:
        if Exclusive.taken:
            raise DeviceError("The device is busy.")
        Exclusive.taken = True
        await super().__aenter__()
        return self

    async def __aexit__(self, *error: object) -> None:
        Exclusive.taken = False
        await super().__aexit__(*error)


def test_a_device_that_has_ended_is_let_go_before_it_is_opened_again() -> None:
    async def scenario() -> None:
        ended = asyncio.Event()
        source = Exclusive()
        async with ears(lambda: source, on_end=lambda error: ended.set()) as it:
            source.finish()
            await ended.wait()
            await it.hearing.hear(again := Exclusive())
            again.push(np.concatenate((COMMAND, quiet(1))).tobytes())
            assert isinstance(await it.hearing.listen(it.emit), Utterance)

    asyncio.run(scenario())


def test_much_sound_at_once_holds_nobody_up() -> None:
    async def scenario() -> None:
        source = PushSource()
        async with ears(lambda: source):
            source.push(quiet(60).tobytes())
            turns, loop = 0, asyncio.get_running_loop()

            def beat() -> None:
                nonlocal turns
                turns += 1
                loop.call_soon(beat)

            beat()
            await all_read()
            assert turns > 200

    asyncio.run(scenario())


# The automatic gain


def test_a_guest_is_as_loud_as_it_is_and_the_own_microphone_as_before() -> None:
    async def scenario() -> None:
        async with ears(PushSource, gain_db=20.0) as it:

            async def level() -> float:
                source = it.hearing._intake.source
                assert isinstance(source, PushSource)
                source.push((COMMAND / 30).astype(np.int16)[: RATE // 2].tobytes())
                await all_read()
                return it.hearing.level.peak_db

            own = await level()
            await it.hearing.hear(PushSource(), Gain(0.0))
            assert await level() == pytest.approx(own - 20, abs=0.5)
            await it.hearing.hear(PushSource())
            assert await level() == pytest.approx(own, abs=0.1)

    asyncio.run(scenario())


@pytest.mark.parametrize("understood", [True, False])
def test_the_automatic_gain_learns_from_what_was_understood_and_from_nothing_else(understood: bool) -> None:
    async def scenario() -> None:
        answer = None if understood else Rejected("artefact", "It is no speech.", "Thank you.")
        async with ears(PushSource, Scripted(answer), gain_db="auto") as it:
            faint = Utterance((COMMAND / 20).astype(np.int16), 0.0, len(COMMAND) / RATE, 1.0)
            for _ in range(3):
                await it.hearing.transcribe(faint, it.emit)
        said = [event.body.message for event in it.published if isinstance(event.body, events.Log)]
        rises = ["The gain is 3 dB from now on.", "The gain is 6 dB from now on.", "The gain is 9 dB from now on."]
        assert said == (rises if understood else [])

    asyncio.run(scenario())
