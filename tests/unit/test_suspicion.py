"""A stop that a spotter suspects is looked into at once, and settled once; of a short one its likelihood counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine.asr.recogniser import Rejected, Transcript
from engine.audio.source import FRAME_S, FRAME_SAMPLES, RATE
from engine.errors import ModelError
from engine.hearing.overhearing import DOUBTFUL_LOGPROB, SURE_LOGPROB
from engine.hearing.suspicion import AGAIN_FRAMES, ALONE, ALONE_FRAMES, AT_ONCE, NEARLY
from tests.unit.overheard import COMMAND, DECODING, LONG, STOP, Listening, quiet, suspecting

LATER_S = (ALONE_FRAMES + 1) * FRAME_S


def test_a_suspicion_is_looked_into_at_once_and_the_recogniser_told_what_to_expect() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        assert ears.expected == [], "nobody has said anything"
        ears.suspect()
        await ears.rest()
        assert ears.expected == [("stop",)]
        assert ears.passes[0].seconds == pytest.approx(1.5, abs=FRAME_S)
        assert ears.told == ["Stop."]
        assert ears.settled == 1

    suspecting(scenario, "Stop.")


def test_a_service_is_asked_about_what_a_spotter_is_sure_of_and_about_nothing_else() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(np.concatenate((quiet(1), STOP, quiet(1), COMMAND, quiet(1))))
        ears.suspect(sure=False)
        await ears.hear(quiet(1))
        assert ears.passes == []
        assert ears.settled == 1, "nobody knows, and nobody was told to rest"
        ears.suspect(sure=True)
        await ears.rest()
        assert ears.expected == [("stop",)]
        assert ears.told == ["Stop."]
        assert ears.settled == 2

    suspecting(scenario, "Stop.", unasked=False)


def test_two_suspicions_at_once_are_looked_into_together() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.may_answer.clear()
        ears.suspect()
        ears.overhearing.suspect("停", lambda: None, lambda: None, sure=False)
        ears.may_answer.set()
        await ears.rest()
        assert ears.settled == 0
        await ears.hear(quiet(LATER_S))
        assert ears.expected == [("stop",), ("stop", "停")]
        assert ears.told == ["停。"]
        assert ears.settled == 1

    suspecting(scenario, "Shop.", "停。")


# What is so short that its likelihood counts


@pytest.mark.parametrize(
    ("likelihoods", "looks", "stops"),
    [
        ((AT_ONCE + 0.1,), 1, True),
        ((AT_ONCE - 0.1, ALONE + 0.1), 2, True),
        ((AT_ONCE - 0.1, NEARLY - 0.1), 2, False),
    ],
    ids=["certain at once", "alone", "the beginning of more"],
)
def test_a_short_stop_counts_at_once_when_it_is_certain_and_later_when_it_was_all(
    likelihoods: tuple[float, ...], looks: int, stops: bool
) -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = likelihoods
        await ears.hear(quiet(2))
        ears.suspect("停", sure=True)
        await ears.rest()
        assert len(ears.weighed) == 1
        assert ears.settled == (looks == 1)
        await ears.hear(quiet(LATER_S))
        assert len(ears.weighed) == looks
        assert ears.told == (["停"] if stops else [])
        assert ears.settled == 1
        assert ears.expected == []  # nobody was asked for a text

    suspecting(scenario, "Nobody asks.")


@pytest.mark.parametrize(("likelihood", "stops"), [(ALONE + 0.1, True), (NEARLY - 0.1, False)])
def test_a_doubtful_short_stop_is_looked_for_once_when_it_shows_whether_it_was_all(
    likelihood: float, stops: bool
) -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (likelihood,)
        await ears.hear(quiet(2))
        ears.suspect("停", sure=False)
        await ears.rest()
        assert ears.weighed == []
        assert ears.settled == 0
        await ears.hear(quiet(LATER_S))
        assert len(ears.weighed) == 1
        assert ears.told == (["停"] if stops else [])
        assert (ears.settled, ears.likelier) == (1, 0)

    suspecting(scenario, "Nobody asks.")


@pytest.mark.parametrize(("second", "stops"), [(NEARLY + 0.1, True), (NEARLY - 0.1, False)])
def test_what_is_nearly_a_short_stop_is_one_when_it_is_so_again(second: float, stops: bool) -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (ALONE - 0.1, second)
        await ears.hear(quiet(2))
        ears.suspect("停", sure=False)
        await ears.hear(quiet(LATER_S))
        assert len(ears.weighed) == 1
        assert (ears.told, ears.settled, ears.likelier) == ([], 0, 1)
        await ears.hear(quiet(AGAIN_FRAMES * FRAME_S))
        assert len(ears.weighed) == 2
        assert ears.told == (["停"] if stops else [])
        assert (ears.settled, ears.likelier) == (1, 1)
        await ears.hear(quiet(1))
        assert len(ears.weighed) == 2

    suspecting(scenario, "Nobody asks.")


def test_what_a_pause_asks_for_waits_for_the_second_look_as_well() -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (NEARLY + 0.1, NEARLY - 0.1)
        sound = np.concatenate((quiet(1), STOP, quiet(2)))
        while not ears.passes:  # as much as a stop was said; the pause comes next
            await ears.hear(sound[:FRAME_SAMPLES])
            sound = sound[FRAME_SAMPLES:]
        ears.suspect("停", sure=False)
        await ears.hear(sound[: (ALONE_FRAMES + AGAIN_FRAMES - 1) * FRAME_SAMPLES])
        assert (len(ears.weighed), len(ears.passes)) == (1, 1)
        await ears.hear(quiet(1))
        assert len(ears.weighed) == 2
        assert ears.told == ["站住。"]
        assert ears.settled == 1

    suspecting(scenario, "听", "站住。")


@pytest.mark.parametrize("alone", [True, False])
def test_what_a_pause_asks_for_waits_for_the_look_at_a_short_stop_and_is_not_lost(alone: bool) -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (ALONE + 0.1 if alone else NEARLY - 0.1,)
        await ears.hear(quiet(1))
        for at in range(0, len(STOP), FRAME_SAMPLES):
            await ears.hear(STOP[at : at + FRAME_SAMPLES])
            if len(ears.passes) == 1:  # as much as a stop was said; the pause comes next
                break
        ears.suspect("停", sure=False)
        await ears.hear(STOP[at + FRAME_SAMPLES :][: (ALONE_FRAMES - 1) * FRAME_SAMPLES])
        assert ears.weighed == []
        assert len(ears.passes) == 1
        await ears.hear(quiet(2 * FRAME_S))
        assert len(ears.weighed) == 1
        assert ears.told == (["停"] if alone else ["站住。"])
        assert len(ears.passes) == (1 if alone else 2)
        assert ears.settled == 1

    suspecting(scenario, "听", "站住。")


def test_beside_a_short_stop_another_one_is_looked_for_as_ever() -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (-9.0,)
        await ears.hear(quiet(2))
        ears.may_answer.clear()
        ears.suspect()
        ears.suspect("停")
        ears.may_answer.set()
        await ears.rest()
        assert ears.expected == [("stop",), ("stop",)]
        assert ears.told == ["Stop."]

    suspecting(scenario, "Shop.", "Stop.")


def test_a_likelihood_that_nobody_needs_any_more_is_no_stop() -> None:
    async def scenario(ears: Listening) -> None:
        ears.likelihoods = (0.0,)
        ears.on_weighing = ears.overhearing.drop
        await ears.hear(quiet(2))
        ears.suspect("停")
        await ears.rest()
        assert ears.told == []
        assert ears.settled == 1

    suspecting(scenario, "Nobody asks.")


def test_without_a_suspicion_the_recogniser_is_told_nothing() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(np.concatenate((quiet(1), COMMAND, quiet(1))))
        assert set(ears.expected) == {()}

    suspecting(scenario, "Go to the kitchen.")


def test_a_suspicion_that_is_not_confirmed_is_settled_once_when_nobody_talks_on() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.suspect()
        await ears.rest()
        assert ears.settled == 1
        await ears.hear(quiet(1))
        assert (ears.hinted, ears.settled, ears.told) == (1, 1, [])

    suspecting(scenario, "Shop.")


def test_somebody_who_talks_on_is_listened_to_once_more_within_a_third_of_a_second() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(np.concatenate((quiet(1), LONG[: RATE // 2 * 3])))
        ears.suspect()
        await ears.rest()
        assert (ears.hinted, ears.settled) == (1, 0)
        await ears.hear(LONG[RATE // 2 * 3 :][: round(0.32 * RATE)])
        assert (ears.hinted, ears.settled) == (2, 1)
        assert ears.told == []

    suspecting(scenario, "go to the")


def test_the_second_look_may_find_what_the_first_did_not() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(np.concatenate((quiet(1), LONG[: RATE // 5])))
        ears.suspect()
        await ears.rest()
        await ears.hear(LONG[RATE // 5 :][: round(0.4 * RATE)])
        assert ears.told == ["Stop!"]
        assert ears.settled == 1

    suspecting(scenario, "st", "Stop!")


@pytest.mark.parametrize(
    "doubtful",
    [
        Transcript("Stop.", 0.4, replace(DECODING, avg_logprob=DOUBTFUL_LOGPROB - 0.05)),
        Rejected("low_confidence", "…", "Stop.", DECODING),
        Rejected("no_speech", "…", "Stop.", DECODING),
    ],
    ids=["unlikely", "low confidence", "no speech"],
)
def test_who_was_told_to_expect_a_doubtful_stop_must_be_sure_of_it(doubtful: Transcript | Rejected) -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.suspect(sure=False)
        await ears.rest()
        assert ears.told == []
        assert ears.settled == 1

    suspecting(scenario, doubtful)


@pytest.mark.parametrize(("logprob", "stops"), [(SURE_LOGPROB + 0.05, True), (SURE_LOGPROB - 0.05, False)])
def test_of_what_the_spotter_is_sure_the_recogniser_need_not_be(logprob: float, stops: bool) -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.suspect(sure=True)
        await ears.rest()
        assert ears.told == ["Stop."] * stops
        assert ears.settled == 1

    suspecting(scenario, Transcript("Stop.", 0.4, replace(DECODING, avg_logprob=logprob)))


def test_a_recogniser_that_fails_leaves_a_suspicion_unsettled() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.suspect()
        await ears.rest()
        assert ears.settled == 0
        ears.suspect()
        await ears.rest()
        assert ears.settled == 1, "the next one is another one"

    suspecting(scenario, ModelError("It has ended."), "Shop.")


def test_a_suspicion_of_what_is_forgotten_is_settled() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.may_answer.clear()
        ears.suspect()
        ears.overhearing.switch(False)
        assert ears.settled == 1
        ears.may_answer.set()
        await ears.rest()
        assert (ears.settled, ears.told) == (1, [])

    suspecting(scenario, "Stop.")


def test_nobody_is_suspected_while_it_is_off() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.overhearing.switch(False)
        assert not ears.overhearing.usable
        ears.suspect()
        assert ears.settled == 1
        assert ears.expected == []

    suspecting(scenario, "Stop.")


def test_a_word_that_is_suspected_twice_has_one_answer() -> None:
    async def scenario(ears: Listening) -> None:
        await ears.hear(quiet(2))
        ears.may_answer.clear()
        ears.suspect()
        ears.suspect()
        ears.may_answer.set()
        await ears.rest()
        assert ears.settled == 1

    suspecting(scenario, "Shop.")
