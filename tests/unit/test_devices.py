"""What is news of a device: it was there and is not any more, or is there again. A loose plug is one piece of news."""

from __future__ import annotations

import asyncio

import pytest

from engine.events import Log
from engine.handle import PartName, PartState, PartStatus
from engine.llm.chain import LONGEST_REST_S
from tests import virtual_time
from tests.unit.test_chain import Chained, Model, gone
from tui.shown.devices import QUIET_S, Devices, News


def parts(state: PartState, detail: str = "", name: PartName = "microphone") -> list[PartStatus]:
    return [PartStatus("planner", "ready"), PartStatus(name, state, detail)]


def test_nothing_is_news_at_the_start_whatever_comes_of_it() -> None:
    for state in ("ready", "missing", "failed"):
        devices = Devices()
        assert devices.look(parts("loading"), 0.0) == ()
        assert devices.look(parts(state), 1.0) == ()
        assert devices.look(parts(state), 2.0) == ()
        assert devices.due(2.0) is None


@pytest.mark.parametrize("name", ["microphone", "voice", "camera", "model", "wake", "wake words"])
def test_what_was_there_and_is_not_any_more_is_told_once_and_again_when_it_is_back(name: PartName) -> None:
    devices = Devices()
    devices.look(parts("ready", name=name), 0.0)
    assert devices.look(parts("failed", "unplugged", name), 10.0) == (News(name, there=False),)
    assert devices.look(parts("failed", "unplugged", name), 20.0) == ()
    assert devices.look(parts("ready", name=name), 30.0) == (News(name, there=True),)


def test_what_was_missing_at_the_start_and_is_plugged_in_is_told() -> None:
    devices = Devices()
    devices.look(parts("missing"), 0.0)
    assert devices.look(parts("ready"), 9.0) == (News("microphone", there=True),)


def test_a_robot_that_is_started_again_is_lost_meanwhile_and_a_model_that_loads_is_not() -> None:
    for name, news in (("robot", (News("robot", there=False),)), ("model", ())):
        devices = Devices()
        devices.look(parts("ready", name=name), 0.0)
        assert devices.look(parts("loading", name=name), 9.0) == news


def test_the_microphone_of_a_satellite_is_told_as_a_satellite_by_what_it_was() -> None:
    devices = Devices()
    devices.look(parts("ready", "satellite at 192.168.1.7:10700"), 0.0)
    assert devices.look(parts("failed", "Nothing answers."), 9.0) == (News("satellite", there=False),)


def test_a_loose_plug_is_told_at_once_then_once_in_five_seconds_with_a_count() -> None:
    devices, told = Devices(), []
    devices.look(parts("ready"), 0.0)
    for number in range(1, 100):  # every 100 ms it comes or goes
        now = number / 10
        told += [(now, news) for news in devices.look(parts("failed" if number % 2 else "ready"), now)]
    assert told == [(0.1, News("microphone", False)), (0.1 + QUIET_S, News("microphone", False, 50))]


def test_what_must_wait_is_told_in_the_end_even_when_nothing_else_happens() -> None:
    devices = Devices()
    devices.look(parts("ready"), 0.0)
    devices.look(parts("failed"), 1.0)
    assert devices.look(parts("ready"), 2.0) == ()
    due = devices.due(2.0)
    assert due == QUIET_S - 1.0
    assert devices.look(parts("ready"), 2.0 + due) == (News("microphone", there=True),)
    assert devices.due(2.0 + due) is None


def test_two_devices_do_not_wait_for_each_other() -> None:
    devices = Devices()
    devices.look([PartStatus("microphone", "ready"), PartStatus("camera", "ready")], 0.0)
    news = devices.look([PartStatus("microphone", "failed"), PartStatus("camera", "loading")], 1.0)
    assert {(one.device, one.there) for one in news} == {("microphone", False), ("camera", False)}


def test_a_service_that_another_one_stands_in_for_is_told_by_what_the_chain_says() -> None:
    async def conversation() -> list[str]:
        chained = Chained((Model("cloud", gone()), Model("local")))
        await chained.answers()
        chained.models[0].error = None
        await asyncio.sleep(LONGEST_REST_S)
        await chained.answers()
        return chained.told

    devices = Devices()
    lines = virtual_time.run(conversation())
    heard = [devices.hear(Log("warning", "model", line), 100.0 * number) for number, line in enumerate(lines)]
    assert heard == [(News("service", there=False),), (News("service", there=True),)]
    assert devices.hear(Log("warning", "model", "The model is slow today."), 900.0) == ()
