"""The console in Chinese looks as it looked: two columns a character, and every column where it is in English."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import msgspec
import pytest
from syrupy.assertion import SnapshotAssertion

from config import load
from engine.wording import build_wording
from tests.tui import scripted
from tests.tui.desk import console
from tests.tui.house import offer
from tests.tui.scripted import ScriptedEngine, Step, flat, robot_at

pytestmark = pytest.mark.filterwarnings("ignore:\\s*Can not relate snapshot")  # pictures are named by what they show

SIZES = [(120, 40), (80, 24)]
REQUEST = "去厨房，然后向左转90度"
SAID: Final = {
    "Go to the kitchen and turn left 90 degrees": REQUEST,
    "go to the kitchen and turn left 90 degrees": REQUEST,
    "go to the kitchen and": "去厨房，",
    "Remember this place.": "记住这个位置。",
    "Go to the kitchen.": "去厨房。",
    "Turn left 90 degrees.": "向左转90度。",
    "Wait 2 seconds.": "等2秒。",
    "Going to the kitchen.": "我去厨房。",
    "en": "zh",
}
"""What people and robot said in the scenes, as they say it in Chinese."""
SHOWN = {"acting_zh": (), "map_zh": ("m", "tab", "enter"), "help_zh": ("question_mark",), "turn_zh": ("enter",),
         "palette_zh": ("ctrl+p",)}  # fmt: skip
"""What is pressed before the picture is taken."""


def in_chinese(steps: Sequence[Step]) -> list[Step]:
    """The same scene, in which Chinese is spoken."""
    return [Step(step.after, _said(step.body)) for step in steps]


def _said(body: Any) -> Any:
    words = {name: getattr(body, name) for name in body.__struct_fields__}
    told = {
        name: SAID.get(word, word) if isinstance(word, str) else tuple(SAID.get(part, part) for part in word)
        for name, word in words.items()
        if isinstance(word, str) or (isinstance(word, tuple) and word and isinstance(word[0], str))
    }
    return msgspec.structs.replace(body, **told)


@pytest.mark.parametrize("size", SIZES, ids=lambda size: "x".join(map(str, size)))
@pytest.mark.parametrize("picture", SHOWN)
async def test_a_page_in_chinese_looks_as_in_its_picture(
    picture: str, size: tuple[int, int], screenshot: SnapshotAssertion, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SAYSO_CONFIG_DIR", "/home/me/.config/sayso")
    engine = ScriptedEngine(robot=robot_at(-1.35, 0.05, 0.4, speed=0.5), floor=flat())
    engine.offers = offer()
    wording = build_wording(load(environ={}))
    keys = SHOWN[picture]
    async with console(engine, size=size, language="zh", wording=wording.told, in_line=not keys) as desk:
        engine.play(in_chinese(scripted.acting()))
        await desk.settled()
        await desk.press(*keys)
        assert await desk.picture() == screenshot(name=f"{picture}_{size[0]}x{size[1]}")
