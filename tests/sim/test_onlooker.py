"""Perception in a process of its own: it says the same, and its end is neither the engine's nor left over."""

from __future__ import annotations

import asyncio
import fcntl
import os
import signal
import sys
import termios
from collections.abc import Iterator
from typing import Final

import psutil
import pytest

from engine.errors import CameraError
from engine.perception.onlooker import Onlooker
from engine.perception.perceive import perceive
from engine.perception.sighting import Sight
from engine.robot.camera import Picture
from engine.robot.floor_map import FloorMap
from tests.open_files import open_files
from tests.sim.rig import run, running

RAYS: Final = {"backend": "rays", "width": 160, "height": 120}
LIMIT_S: Final = 30.0
ME: Final = psutil.Process()


@pytest.fixture(autouse=True)
def _nothing_is_left() -> Iterator[None]:
    before = open_files()
    yield
    assert [child for child in ME.children() if "onlooker_worker" in " ".join(child.cmdline())] == []
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


async def in_the_middle_of_a_picture(
    onlooker: Onlooker, pid: int, scene: tuple[Picture, FloorMap]
) -> asyncio.Future[Sight]:
    """A process that has been given a picture and does not go on."""
    os.kill(pid, signal.SIGSTOP)
    waiting = asyncio.ensure_future(onlooker.perceive(*scene))
    link = onlooker._link
    assert link is not None
    async with asyncio.timeout(LIMIT_S):
        while not int.from_bytes(fcntl.ioctl(link.fileno(), termios.TIOCOUTQ, bytes(4)), sys.byteorder):  # noqa: ASYNC110
            await asyncio.sleep(0)
    return waiting


def test_it_sees_what_perception_sees_and_goes_with_whoever_made_it(scene: tuple[Picture, FloorMap]) -> None:
    async def test() -> None:
        onlooker = Onlooker(prompt=False)
        assert onlooker.pid is None, "nobody looks on, and there is no process"
        for _ in range(2):
            sight = await onlooker.perceive(*scene)
            assert facts(sight) == facts(perceive(*scene))
            assert sight.picture is scene[0]
        assert onlooker.pid is not None
        await onlooker.close()
        with pytest.raises(CameraError, match="has ended"):
            await onlooker.perceive(*scene)
        onlooker.begin()
        assert onlooker.pid is None

    run(test)


def test_a_process_that_is_lost_is_told_and_replaced_with_the_next_picture(scene: tuple[Picture, FloorMap]) -> None:
    async def test() -> None:
        onlooker = Onlooker(prompt=False)
        pid = await process_of(onlooker, scene)
        waiting = await in_the_middle_of_a_picture(onlooker, pid, scene)
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


def test_closing_ends_it_in_the_middle_of_a_picture(scene: tuple[Picture, FloorMap]) -> None:
    async def test() -> None:
        onlooker = Onlooker(prompt=False)
        pid = await process_of(onlooker, scene)
        waiting = await in_the_middle_of_a_picture(onlooker, pid, scene)
        await onlooker.close()
        with pytest.raises(CameraError, match="has ended"):
            await waiting

    run(test)
