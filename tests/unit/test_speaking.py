"""An answer that is spoken: heard is what has sounded, and silence comes at once."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine import events
from engine.audio.clocked import ClockedOutput
from engine.audio.player import BLOCK_S, Player
from engine.audio.source import RATE, Samples
from engine.chimes import Chimes
from engine.commands import Interrupt, Say, Wake
from engine.errors import DeviceError, ExitCode, ModelError, SaysoError
from engine.planner.phrases.stopping import is_stop
from engine.session.history import Answered
from engine.speaking import AHEAD, SpokenVoice
from engine.tts.choice import ByLanguage
from engine.tts.sentences import Sentence, sentences
from engine.tts.synthesis import Piece, Said
from engine.tts.voice import SilentVoice
from tests.session.conversation import Conversation, converse
from tests.virtual_time import run

WORD_S = 0.25
"""How long each word of :class:`Tones` lasts."""


@dataclass
class Tones:
    """A voice whose every word is a tone: what a test of timing cannot have from a real one."""

    takes_s: float = 0.05  # to make a sentence
    knows_words: bool = True
    pieces: int = 1
    fails_at: int | None = None  # number of the sentence that it cannot say
    made: list[str] = field(default_factory=list)
    cut: int = 0
    closed: bool = False
    rate: int = RATE  # Hz
    name: str = "tones"

    async def load(self) -> None: ...

    async def synthesise(self, sentence: Sentence) -> AsyncGenerator[Piece]:
        if len(self.made) == self.fails_at:
            raise ModelError("The voice has lost its tongue.")
        self.made.append(sentence.joined()[0])
        if not any(map(str.isalnum, self.made[-1])):
            return
        try:
            await asyncio.sleep(self.takes_s)
            count = len(sentence.words)
            said = tuple(Said(number, number * WORD_S) for number in range(1, count + 1)) if self.knows_words else ()
            time = np.arange(round(count * WORD_S * self.rate)) / self.rate
            sound = np.asarray(8000 * np.sin(2 * np.pi * 300 * time), np.int16)
            for index, part in enumerate(np.array_split(sound, self.pieces)):
                yield Piece(part, self.rate, said if index == 0 else ())
                await asyncio.sleep(0)
        except GeneratorExit:
            self.cut += 1
            raise

    async def close(self) -> None:
        self.closed = True


class Room:
    """A voice and a player on a clock, and everything that was heard."""

    def __init__(self, tones: Tones | None = None) -> None:
        self.tones = tones or Tones()
        self.blocks: list[Samples] = []
        self.player = Player(ClockedOutput(RATE, self.blocks.append))
        self.voice = SpokenVoice(self.player)
        self.heard: list[tuple[float, str]] = []

    async def ready(self) -> None:
        await self.player.open()
        self.voice.settle(self.tones)

    def hear(self, text: str) -> None:
        self.heard.append((asyncio.get_running_loop().time(), text))

    @property
    def words(self) -> list[str]:
        return [text for _, text in self.heard]

    def loud_since(self, block: int) -> bool:
        return any(np.abs(block.astype(int)).max() > 0 for block in self.blocks[block:])


def in_a_room(test: Callable[[Room], Any], tones: Tones | None = None) -> None:
    async def scenario() -> None:
        room = Room(tones)
        await room.ready()
        try:
            await test(room)
        finally:
            await room.player.close()
        assert len(asyncio.all_tasks()) == 1

    run(scenario())


def beginnings(text: str) -> list[str]:
    return [text[: word.end] for sentence in sentences(text) for word in sentence.words]


# Saying


def test_every_word_is_heard_when_it_has_sounded_not_before() -> None:
    async def test(room: Room) -> None:
        text = "one two three four"
        await room.voice.say(text, room.hear)
        assert room.words == beginnings(text)
        times = {text: at for at, text in room.heard}
        for number, beginning in enumerate(beginnings(text), 1):
            due = room.tones.takes_s + number * WORD_S
            assert due - 1e-6 <= times[beginning] <= due + 3 * BLOCK_S

    in_a_room(test)


@given(st.lists(st.sampled_from(["red", "box.", "厨房", "-0.5 m,", "and", "yes!"]), max_size=12), st.integers(1, 5))
def test_whatever_is_said_all_of_it_is_heard_word_by_word_in_the_end(words: list[str], pieces: int) -> None:
    async def test(room: Room) -> None:
        text = " ".join(words)
        await room.voice.say(text, room.hear)
        assert room.words[-1] == text
        assert room.words[: len(beginnings(text))] == beginnings(text)
        assert len(room.words) <= len(beginnings(text)) + 1

    for knows in (True, False):
        in_a_room(test, Tones(pieces=pieces, knows_words=knows))


def test_the_first_sentence_sounds_while_the_next_is_made_and_no_more_than_that_is_made_in_vain() -> None:
    async def test(room: Room) -> None:
        text = "one two three. four five six. seven eight nine. ten eleven twelve. last."
        saying = asyncio.create_task(room.voice.say(text, room.hear))
        await asyncio.sleep(0.3)
        assert room.loud_since(0)
        assert len(room.tones.made) == AHEAD
        await asyncio.sleep(0.75)
        assert len(room.tones.made) == AHEAD + 1
        saying.cancel()
        await asyncio.gather(saying, return_exceptions=True)
        assert len(room.tones.made) == AHEAD + 1

    in_a_room(test)


def test_sentences_follow_each_other_without_a_gap() -> None:
    async def test(room: Room) -> None:
        await room.voice.say("one two. three four. five six.", room.hear)
        sound = np.concatenate(room.blocks)
        loud = np.flatnonzero(sound)
        assert (loud[-1] - loud[0]) / RATE == pytest.approx(6 * WORD_S, abs=0.01)

    in_a_room(test)


@pytest.mark.parametrize("rate", [RATE, 22_050, 24_000])
@pytest.mark.parametrize("text", ["one two. ... three four. five.", "one two! 👍! three.", "...", "one."])
def test_a_sentence_without_sound_holds_nothing_up_however_fast_the_voice_samples(text: str, rate: int) -> None:
    async def test(room: Room) -> None:
        async with asyncio.timeout(10):
            await room.voice.say(text, room.hear)
        assert room.words[-1] == text

    in_a_room(test, Tones(rate=rate))


# Being cut off


@given(st.floats(0.0, 3.0))
def test_cut_off_anywhere_the_sound_ends_within_a_block_and_what_was_heard_is_what_had_sounded(at: float) -> None:
    async def test(room: Room) -> None:
        text = "one two three. four five six. seven eight nine."
        saying = asyncio.create_task(room.voice.say(text, room.hear))
        await asyncio.sleep(at)
        done = saying.done()
        saying.cancel()
        blocks = len(room.blocks)
        await asyncio.gather(saying, return_exceptions=True)
        await asyncio.sleep(1.0)
        assert not room.loud_since(blocks + 2)  # in the first of them the task had not been cancelled yet
        heard = room.words[-1] if room.words else ""
        assert text.startswith(heard)
        sounded = max(0.0, at - room.tones.takes_s)
        words = len(beginnings(heard)) if heard else 0
        assert done or int((sounded - 3 * BLOCK_S) / WORD_S) <= words <= int(sounded / WORD_S + 1e-6)

    in_a_room(test)


def test_a_stop_silences_before_anybody_is_cancelled_and_the_next_answer_sounds() -> None:
    async def test(room: Room) -> None:
        saying = asyncio.create_task(room.voice.say("one two three four five six", room.hear))
        await asyncio.sleep(0.7)
        room.player.stop(2)
        blocks = len(room.blocks)
        await asyncio.sleep(0.3)
        assert not room.loud_since(blocks + 1)
        assert room.words[-1] == "one two"
        saying.cancel()
        await asyncio.gather(saying, return_exceptions=True)
        await room.voice.say("Stopped.", room.hear)
        assert room.words[-1] == "Stopped."
        assert room.loud_since(blocks + 1)

    in_a_room(test)


def test_what_was_to_be_said_when_the_stop_came_is_never_heard() -> None:
    async def test(room: Room) -> None:
        saying = room.voice.say("one two three", room.hear)
        room.player.stop(2)  # after that, and before it has begun
        with pytest.raises(SaysoError, match="cut off"):
            await saying
        assert not room.loud_since(0)
        assert room.words == []

    in_a_room(test)


def test_a_voice_that_is_cut_off_while_it_makes_a_sentence_is_told_that_nobody_needs_it() -> None:
    async def test(room: Room) -> None:
        saying = asyncio.create_task(room.voice.say("one two three", room.hear))
        await asyncio.sleep(room.tones.takes_s + 0.01)
        saying.cancel()
        await asyncio.gather(saying, return_exceptions=True)
        assert room.words == []

    in_a_room(test, Tones(takes_s=5.0))


# What goes wrong


def test_a_voice_that_fails_in_the_middle_has_said_the_rest_and_says_so_once() -> None:
    async def test(room: Room) -> None:
        text = "one two. three four. five six."
        with pytest.raises(ModelError, match="tongue"):
            await room.voice.say(text, room.hear)
        assert room.words[-1] == "one two."
        await room.voice.say("again", room.hear)  # the same trouble: the answer is shown
        assert room.words[-1] == "again"
        room.tones.fails_at = None
        await room.voice.say("and well", room.hear)
        room.tones.fails_at = len(room.tones.made)
        with pytest.raises(ModelError, match="tongue"):
            await room.voice.say("anew", room.hear)

    in_a_room(test, Tones(fails_at=1))


def test_until_there_is_a_voice_answers_are_shown() -> None:
    async def scenario() -> None:
        room = Room()
        assert not room.voice.audible
        await room.voice.say("not yet", room.hear)
        assert room.words == ["not yet"]
        assert asyncio.get_running_loop().time() == 0
        await room.ready()
        assert room.voice.audible
        await room.player.close()

    run(scenario())


def test_whoever_is_patient_waits_for_a_voice_that_loads_but_not_for_ever() -> None:
    async def scenario() -> None:
        room = Room()
        room.voice = SpokenVoice(room.player, patience_s=10)
        assert room.voice.audible
        asyncio.get_running_loop().call_later(3, room.voice.settle, room.tones)
        await room.player.open()
        await room.voice.say("one", room.hear)
        assert room.loud_since(0)
        assert room.heard[0][0] > 3
        await room.player.close()

        never = SpokenVoice(room.player, patience_s=10)
        began = asyncio.get_running_loop().time()
        await never.say("two", room.hear)
        assert asyncio.get_running_loop().time() - began == pytest.approx(10)

    run(scenario())


def test_a_loudspeaker_that_is_lost_is_one_error_and_when_it_is_back_answers_are_spoken_again() -> None:
    class Plug(ClockedOutput):
        there = True

        async def open(self, pull, lost, *, patient=False) -> None:  # type: ignore[no-untyped-def]
            if not self.there:
                raise DeviceError("There is no loudspeaker.")
            self.lost = lost
            await super().open(pull, lost)

    async def scenario() -> None:
        room = Room()
        plug = Plug(RATE, room.blocks.append)
        room.player = Player(plug)
        room.voice = SpokenVoice(room.player)
        await room.ready()
        saying = asyncio.create_task(room.voice.say("one two three four", room.hear))
        await asyncio.sleep(0.7)
        plug.there = False
        plug.lost(DeviceError("The loudspeaker is gone."))
        with pytest.raises(DeviceError, match="gone"):
            await saying
        assert room.words[-1] == "one two"
        assert not room.voice.audible
        await room.voice.say("shown", room.hear)
        assert room.words[-1] == "shown"
        plug.there = True
        await room.player.open()
        blocks = len(room.blocks)
        await room.voice.say("spoken", room.hear)
        assert room.loud_since(blocks)
        await room.player.close()

    run(scenario())


# Its own words in its own ears


def test_it_knows_what_its_ears_may_have_heard_of_itself() -> None:
    async def test(room: Room) -> None:
        assert room.voice.not_own("Stop.") == "Stop."
        saying = asyncio.create_task(room.voice.say("Stopped. 停下了。", room.hear))
        await asyncio.sleep(0.2)
        assert room.voice.not_own("stop") == ""
        assert room.voice.not_own("Stop, stop!") == ""
        assert room.voice.not_own("停") == ""
        assert room.voice.not_own("freeze") == "freeze"
        await saying
        assert room.voice.not_own("Stop.") == "", "a recogniser needs a moment"
        await room.voice.say("I am in the kitchen.", room.hear)
        assert room.voice.not_own("Stop.") == "Stop."

    in_a_room(test)


def test_whoever_says_just_what_it_said_may_have_been_itself() -> None:
    async def test(room: Room) -> None:
        assert not room.voice.repeats("going to the kitchen")
        await room.voice.say("Going to the kitchen.", room.hear)
        await room.voice.say("I am in the kitchen.", room.hear)
        assert room.voice.repeats("Going to the kitchen")
        assert room.voice.repeats("the kitchen, I am.")
        assert not room.voice.repeats("and go to the kitchen")
        assert not room.voice.repeats("Going to the bedroom.")

    in_a_room(test)


def test_what_is_only_shown_is_not_heard_by_anybody() -> None:
    async def scenario() -> None:
        room = Room()
        await room.voice.say("Stopped.", room.hear)
        assert room.voice.not_own("Stop.") == "Stop."

    run(scenario())


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ("The red box is on the table now.", "Stop the robot!"),
        ("The red box is on the table now.", "No, stop!"),
        ("The red box is on the table now.", "Hold on."),
        ("我现在不在厨房。", "不，停！"),
        ("我现在不在厨房。", "不要动"),
        ("我现在不在厨房。", "现在停下"),
        ("Stopped.", "Stop, freeze!"),
    ],
)
def test_a_stop_is_no_echo_because_of_a_word_that_the_robot_says_too(answer: str, said: str) -> None:
    async def test(room: Room) -> None:
        saying = asyncio.create_task(room.voice.say(answer, room.hear))
        await asyncio.sleep(0.2)
        assert is_stop(said)
        assert is_stop(room.voice.not_own(said))
        await saying

    in_a_room(test)


# In a session


def talk_with(test: Callable[[Conversation, Room], Any], *, typed_too: bool = False) -> None:
    """A session whose answers to speech are spoken."""
    room = Room()

    async def wrapped(talk: Conversation) -> None:
        await room.ready()
        tell = talk.epoch._on_advance
        talk.epoch._on_advance = lambda epoch: (tell(epoch), room.player.stop(epoch))[0]
        talk.session._needs = replace(talk.session._needs, voice_for_typed=room.voice if typed_too else SilentVoice())
        try:
            await test(talk, room)
        finally:
            await room.player.close()

    converse(wrapped, voice=_Late(room))


class _Late:
    """The voice of a room that is made before the loop that it lives in."""

    def __init__(self, room: Room) -> None:
        self._room = room

    @property
    def audible(self) -> bool:
        return self._room.voice.audible

    def say(self, text: str, heard: Callable[[str], None]) -> Any:
        return self._room.voice.say(text, heard)


async def spoken(talk: Conversation, text: str) -> None:
    """Wake it and say something."""
    talk.send(Wake("key"))
    await talk.until_state("LISTENING")
    while not talk.hearing.speak(text):
        await talk.pass_time(0.05)


def test_a_spoken_request_is_answered_aloud_and_a_typed_one_is_not() -> None:
    async def test(talk: Conversation, room: Room) -> None:
        await spoken(talk, "where are you")
        await talk.result()
        first = talk.bodies(events.SpeechStarted)[0]
        assert first.audible
        assert room.loud_since(0)
        blocks = len(room.blocks)
        talk.send(Say("where are you"))
        await talk.result(2)
        assert not talk.bodies(events.SpeechStarted)[-1].audible
        assert not room.loud_since(blocks + 1)
        assert talk.bodies(events.SpeechEnded)[-1].heard == talk.bodies(events.SpeechStarted)[-1].text

    talk_with(test)


def test_with_always_a_typed_request_is_answered_aloud_too() -> None:
    async def test(talk: Conversation, room: Room) -> None:
        talk.send(Say("where are you"))
        await talk.result()
        assert talk.bodies(events.SpeechStarted)[0].audible
        assert room.loud_since(0)

    talk_with(test, typed_too=True)


def test_interrupted_in_mid_word_it_is_silent_when_the_call_returns_and_the_history_has_what_was_heard() -> None:
    async def test(talk: Conversation, room: Room) -> None:
        await spoken(talk, "where are you")
        started = await talk.until(events.SpeechStarted)
        await talk.pass_time(room.tones.takes_s + 2.6 * WORD_S)
        talk.send(Interrupt())
        blocks = len(room.blocks)  # not a step of the loop later
        result = await talk.result()
        assert result.exit_code == ExitCode.INTERRUPTED
        await talk.pass_time(1.0)
        assert not room.loud_since(blocks + 1)
        ended = talk.bodies(events.SpeechEnded)[0]
        assert ended.outcome == "interrupted"
        assert ended.heard == beginnings(started.text)[1]
        [entry] = [entry for entry in talk.session._cycle.entries if isinstance(entry, Answered)]
        assert entry.heard == ended.heard
        assert any(ended.heard in str(entry) for entry in talk.session._cycle.happened())

    talk_with(test)


def test_a_wake_while_it_speaks_silences_it_and_listens() -> None:
    async def test(talk: Conversation, room: Room) -> None:
        await spoken(talk, "where are you")
        await talk.until(events.SpeechStarted)
        await talk.pass_time(room.tones.takes_s + 1.5 * WORD_S)
        talk.send(Wake("key"))
        blocks = len(room.blocks)
        await talk.until_state("LISTENING")
        await talk.pass_time(1.0)
        assert not room.loud_since(blocks + 1)
        assert talk.session.state == "LISTENING"

    talk_with(test)


# The robot's sounds


def sounds_of(test: Callable[[Conversation, Room, list[str]], Any], *, audible: bool = False) -> None:
    """A session with :class:`Chimes`, and the names of what they played."""
    played: list[str] = []

    async def with_chimes(talk: Conversation, room: Room) -> None:
        if not audible:
            room.voice.settle(None)
        chimes = Chimes(room.player)
        play = chimes._play

        def noted(name: Any, **options: Any) -> Any:
            played.append(name)
            return play(name, **options)

        chimes._play = noted  # type: ignore[method-assign]
        talk.session._bus.subscribe(chimes.see)
        await test(talk, room, played)

    talk_with(with_chimes)


def test_a_wake_is_answered_and_the_recording_runs_before_any_of_it_has_sounded() -> None:
    async def test(talk: Conversation, room: Room, played: list[str]) -> None:
        woken = asyncio.get_running_loop().time()
        talk.send(Wake("key"))
        await talk.until(events.ListenStarted)
        assert played == ["wake", "listen"]
        assert asyncio.get_running_loop().time() == woken
        await talk.pass_time(0.5)
        assert room.loud_since(0)
        assert not room.loud_since(20)

    sounds_of(test)


def test_a_spoken_request_without_a_spoken_answer_ends_with_a_sound_that_says_how() -> None:
    async def test(talk: Conversation, room: Room, played: list[str]) -> None:
        await spoken(talk, "go forward 1 metre")
        await talk.result(1)
        await spoken(talk, "go to the moon")
        await talk.result(2)
        await spoken(talk, "")
        await talk.result(3)
        await spoken(talk, "go forward 5 metres")
        await talk.until_state("ACTING")
        talk.send(Interrupt())
        await talk.result(4)
        waking = ["wake", "listen"]
        assert played == [*waking, "done", *waking, "error", *waking, "error", *waking]

    sounds_of(test)


def test_an_answer_that_is_spoken_needs_no_sound_and_what_is_typed_makes_none() -> None:
    async def test(talk: Conversation, room: Room, played: list[str]) -> None:
        await spoken(talk, "where are you")
        await talk.result(1)
        talk.send(Say("go forward 1 metre"))
        await talk.result(2)
        assert played == ["wake", "listen"]

    sounds_of(test, audible=True)


def test_an_answer_of_which_nothing_sounded_is_no_answer_to_the_ear() -> None:
    async def test(talk: Conversation, room: Room, played: list[str]) -> None:
        room.voice.settle(ByLanguage(room.tones, None, chinese=True))
        await spoken(talk, "where are you")
        await talk.result(1)
        assert talk.bodies(events.SpeechStarted)[0].audible
        assert played == ["wake", "listen", "done"]

    sounds_of(test, audible=True)


def test_while_somebody_is_listened_to_speech_is_ducked_with_chimes_and_without() -> None:
    async def test(talk: Conversation, room: Room) -> None:
        talk.session._bus.subscribe(room.voice.see)
        assert not room.player._ducking
        talk.send(Wake("key"))
        await talk.until_state("LISTENING")
        assert room.player._ducking
        talk.send(Interrupt())
        await talk.until_state("IDLE")
        assert not room.player._ducking

    talk_with(test)
