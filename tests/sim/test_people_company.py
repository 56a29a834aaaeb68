"""Sentences and news between the engine and the people in the host's process."""

from __future__ import annotations

import os
import signal

import pytest

from engine.errors import RobotError
from engine.robot.company import News
from engine.robot.host.memory import Memory
from engine.robot.sim.robot import SimRobot
from tests.sim.rig import beating, run, running, settings

QUESTIONS = [f"Where is thing {number}?" for number in range(20)]


async def news_after(robot: SimRobot, *texts: str, ticks: int = 60) -> list[News]:
    assert robot.company is not None
    for text in texts:
        robot.company.tell(text)
    found: list[News] = []
    for _ in range(ticks):
        await robot.tick()
        found += robot.company.news()
    return found


def test_what_is_said_is_heard_in_the_hosts_process_and_nothing_is_lost() -> None:
    async def talk() -> None:
        async with running(scene="family") as robot, beating(robot):
            news = await news_after(robot, *QUESTIONS)
            assert [n.text for n in news if n.does == "hears"] == QUESTIONS
            assert {n.who for n in news} == {"James"}, "the only one within 3 m"
            says = [n for n in news if n.does == "says"]
            assert [n.text for n in says] == ["I do not know."] * 20
            assert says[0].t == pytest.approx(0.8, abs=0.05)

    run(talk)


def test_a_sentence_that_is_too_long_is_cut_between_two_characters() -> None:
    async def talk() -> None:
        async with running(scene="family") as robot, beating(robot):
            news = await news_after(robot, "好" * 500, ticks=3)
            assert news[0].text == "好" * 170

    run(talk)


def test_nobody_hears_where_nobody_is() -> None:
    assert SimRobot(settings(scene="flat")).company is None


def test_a_robot_that_has_not_started_is_not_heard() -> None:
    company = SimRobot(settings(scene="family")).company
    assert company is not None
    company.tell("Hello?")
    assert company.news() == ()


def test_after_the_host_was_replaced_people_hear_what_is_said_from_then_on() -> None:
    async def lose() -> None:
        async with running(scene="family") as robot, beating(robot):
            await news_after(robot, "Hello.")
            assert robot.pid is not None
            os.kill(robot.pid, signal.SIGKILL)
            with pytest.raises(RobotError):
                await news_after(robot, "Hello?")
            await robot.start()
            news = await news_after(robot, "What is your name?")
            assert [n.text for n in news] == ["What is your name?", "I am James."]

    run(lose)


def test_a_reader_who_falls_behind_misses_the_oldest_and_nothing_else() -> None:
    memory = Memory.create()
    try:
        for number in range(100):
            memory.speech.scratch["text"] = str(number).encode()
            memory.speech.put()
        records, seen = memory.speech.since(0)
        texts = [int(record["text"].item()) for record in records]
        assert seen == 100
        assert texts == list(range(texts[0], 100))
        assert len(texts) > 60
        assert memory.speech.since(seen) == ([], 100)
    finally:
        os.close(memory.fd)
