"""Perception in a process of its own: it says the same, and its end is neither the engine's nor left over."""

from __future__ import annotations

import asyncio
import os
import signal
import threading
from collections.abc import Iterator
from multiprocessing.connection import Connection
from typing import Final

import psutil
import pytest

from engine.errors import CameraError
from engine.perception.onlooker import Onlooker
from engine.perception.perceive import perceive
from engine.perception.sighting import Sight
from engine.robot.camera import Picture
from engine.robot.floor_map import FloorMap
from tests.children import children
from tests.open_files import open_files
from tests.sim.rig import run, running

RAYS: Final = {"backend": "rays", "width": 160, "height": 120}
LIMIT_S: Final = 30.0
PROCESS: Final = "engine.perception.onlooker_worker"


@pytest.fixture(autouse=True)
def _nothing_is_left() -> Iterator[None]:
    before = open_files()
    yield
    assert children(PROCESS) == []
    assert open_files() == before


@pytest.fixture(scope="module")
def scene() -> tuple[Picture, FloorMap]:
    """A picture with something in it, and the house that it was taken in."""
    taken: list[tuple[Picture, FloorMap]] = []

    async def take() -> None:
        async with running(scene="workshop", camera=RAYS) as robot:
            taken.append((await robot.look(), robot.floor_map))

    run(take)
    return taken[0]


def facts(sight: Sight) -> object:
    return sight.objects, [(tag.id, tag.position, tag.corners.tolist()) for tag in sight.tags]


async def process_of(onlooker: Onlooker, scene: tuple[Picture, FloorMap]) -> int:
    """That has understood a picture."""
    assert facts(await onlooker.perceive(*scene)) == facts(perceive(*scene))
    pid = onlooker.pid
    assert pid is not None
    return pid


@pytest.fixture
def given(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """A process has been given a picture, and is waited for."""
    given, poll = threading.Event(), Connection.poll

    def told(link: Connection, timeout: float | None = 0.0) -> bool:
        given.set()
        return poll(link, timeout)

    monkeypatch.setattr(Connection, "poll", told)
    return given


async def in_the_middle_of_a_picture(
    scene: tuple[Picture, FloorMap], given: threading.Event
) -> tuple[Onlooker, int, asyncio.Future[Sight]]:
    """One whose process has been given a picture and does not go on."""
    onlooker = Onlooker(prompt=False)
    pid = await process_of(onlooker, scene)
    os.kill(pid, signal.SIGSTOP)
    given.clear()
    waiting = asyncio.ensure_future(onlooker.perceive(*scene))
    assert await asyncio.to_thread(given.wait, LIMIT_S)
    return onlooker, pid, waiting


def test_it_sees_what_perception_sees_and_goes_with_whoever_made_it(scene: tuple[Picture, FloorMap]) -> None:
    async def test() -> None:
        onlooker = Onlooker(prompt=False)
        assert onlooker.pid is None, "nobody looks on, and there is no process"
        for _ in range(2):
            sight = await onlooker.perceive(*scene)
            assert facts(sight) == facts(perceive(*scene))
            assert sight.picture is scene[0]
        assert [child.pid for child in children(PROCESS)] == [onlooker.pid]
        await onlooker.close()
        with pytest.raises(CameraError, match="has ended"):
            await onlooker.perceive(*scene)
        onlooker.begin()
        assert onlooker.pid is None

    run(test)


def test_a_process_that_is_lost_is_told_and_replaced_with_the_next_picture(
    scene: tuple[Picture, FloorMap], given: threading.Event
) -> None:
    async def test() -> None:
        onlooker, pid, waiting = await in_the_middle_of_a_picture(scene, given)
        os.kill(pid, signal.SIGKILL)
        with pytest.raises(CameraError, match="killed by SIGKILL"):
            await waiting
        again = await process_of(onlooker, scene)
        assert again != pid
        os.kill(again, signal.SIGKILL)
        psutil.wait_procs([psutil.Process(again)], LIMIT_S)
        assert await process_of(onlooker, scene) != again, "nobody was waiting, and nobody has to know"
        await onlooker.close()

    run(test)


def test_closing_ends_it_in_the_middle_of_a_picture(scene: tuple[Picture, FloorMap], given: threading.Event) -> None:
    async def test() -> None:
        onlooker, _, waiting = await in_the_middle_of_a_picture(scene, given)
        await onlooker.close()
        with pytest.raises(CameraError, match="has ended"):
            await waiting

    run(test)
