"""A camera on USB, for which a film stands: it comes, is lost, and comes back; what it does not measure is floor."""

from __future__ import annotations

import asyncio
import math
import os
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from config.schema import Camera
from engine.errors import CameraError
from engine.planner.build import build_registry
from engine.robot import usb_camera
from engine.robot.camera import Lens, floor_depth
from engine.robot.camera_news import CameraNews, Lost, Opened
from engine.robot.description import CameraOf, Description, described
from engine.robot.host.memory import Memory
from engine.robot.usb_camera import UsbCamera, path_of
from tests.unit.test_skill_words import SETTINGS

EYE = CameraOf(depth=False, view=50, on_arm=False, at=(0.1, 0.0, 0.3), down=20)


def film(path: Path, frames: int = 8) -> Path:
    """Green pictures of 320 × 240 with a red corner, upper left."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 50, (320, 240))
    picture = np.zeros((240, 320, 3), dtype=np.uint8)
    picture[:] = (0, 200, 0)
    picture[:60, :80] = (0, 0, 220)
    for _ in range(frames):
        writer.write(picture)
    writer.release()
    return path


def with_eye(eye: CameraOf = EYE) -> Description:
    return described("x3plus").model_copy(update={"camera": eye})


class News(list[CameraNews]):
    """What was told of a camera."""

    def __init__(self) -> None:
        super().__init__()
        self._more = asyncio.Event()

    def tell(self, one: CameraNews) -> None:
        self.append(one)
        self._more.set()

    async def until(self, condition: Callable[[], bool]) -> None:
        while not condition():
            self._more.clear()
            await self._more.wait()


def watched(path: Path, test: Callable[[UsbCamera, News], Coroutine[Any, Any, None]]) -> None:
    async def main() -> None:
        memory, news = Memory.create(), News()
        settings = Camera(device=str(path), backend="auto", width=160, height=120)
        camera = UsbCamera(settings, with_eye(), memory, news.tell)
        try:
            await test(camera, news)
        finally:
            await camera.close()
            os.close(memory.fd)

    asyncio.run(main())


def test_it_delivers_pictures_of_the_size_that_is_set(tmp_path: Path) -> None:
    async def test(camera: UsbCamera, news: News) -> None:
        picture = await camera.look()
        assert picture.rgb.shape == (120, 160, 3)
        red, green, _ = picture.rgb[10, 10].tolist()
        assert red > 150 > green, "colours are in the order that everybody here expects"
        opened = next(one for one in news if isinstance(one, Opened))
        assert "320×240, no depth: on the floor it is right to about 2 cm at 0.5 m, 6 cm at 1 m" in opened.detail

    watched(film(tmp_path / "film.avi", 200), test)


def test_it_is_lost_and_comes_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(usb_camera, "AGAIN_S", 0.05)

    async def test(camera: UsbCamera, news: News) -> None:
        await camera.look()
        await news.until(lambda: sum(isinstance(one, Opened) for one in news) == 2)
        assert any(isinstance(one, Lost) for one in news), "the film had come to its end"
        await camera.look()

    watched(film(tmp_path / "film.avi"), test)


def test_one_that_is_not_there_is_told_to_whoever_looks(tmp_path: Path) -> None:
    async def test(camera: UsbCamera, news: News) -> None:
        with pytest.raises(CameraError, match="cannot be opened"):
            await camera.look()
        assert any(isinstance(one, Lost) for one in news)

    watched(tmp_path / "nothing.avi", test)


def test_a_camera_is_meant_by_number_name_or_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for number, name in ((0, "Integrated Webcam"), (2, "Astra Pro HD Camera")):
        (tmp_path / f"video{number}").mkdir()
        (tmp_path / f"video{number}" / "name").write_text(f"{name}\n")
    monkeypatch.setattr(usb_camera, "NAMES", tmp_path)
    assert path_of("0") == "/dev/video0"
    assert path_of("astra") == "/dev/video2"
    assert path_of("/dev/v4l/by-id/one") == "/dev/v4l/by-id/one"
    with pytest.raises(CameraError, match="There is no camera called 'kinect'") as error:
        path_of("kinect")
    assert "Integrated Webcam, Astra Pro HD Camera" in error.value.hint


def test_what_is_on_the_floor_is_where_it_is() -> None:
    lens, mount = Lens.of_view(160, 120, math.radians(EYE.view)), EYE.mount
    depth = floor_depth(lens, mount)
    spot = np.array([[0.9, 0.1, 0.0]])
    (column, row), z = lens.project(mount.into(spot))[0], mount.into(spot)[0, 2]
    assert depth[int(row), int(column)] == pytest.approx(z, abs=0.05)
    assert np.isinf(depth[0]).all(), "there is no floor above the horizon"


def test_skills_that_need_depth_are_not_offered_without(monkeypatch: pytest.MonkeyPatch) -> None:
    def offered(eye: CameraOf | None) -> set[str]:
        made = described("x3plus").model_copy(update={"camera": eye})
        monkeypatch.setattr("engine.planner.build.description_of", lambda robot: made)
        return {skill.name for skill in build_registry(SETTINGS)}

    without, flat, deep = offered(None), offered(EYE), offered(EYE.model_copy(update={"depth": True}))
    assert flat - without == {"follow_line", "apriltag_follow", "get_dist"}
    assert {"pick_object", "locate", "clean_room"} <= deep - flat
