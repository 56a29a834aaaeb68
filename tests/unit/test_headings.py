"""Headings as people read them are degrees, 0° east, counter-clockwise, wherever they stand."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

import engine
import tui
from engine.robot.geometry import heading_in_degrees


@pytest.mark.parametrize(
    ("yaw", "told"),
    [
        (0.0, 0), (math.pi / 2, 90), (math.pi, 180), (-math.pi / 2, 270), (-0.001, 0),
        (2 * math.pi - 0.001, 0), (7.0, 41),
    ],
)  # fmt: skip
def test_a_heading_is_whole_degrees_from_east_counter_clockwise(yaw: float, told: float) -> None:
    assert heading_in_degrees(yaw) == told


def test_no_pose_is_told_in_another_way() -> None:
    """Only the one function makes words of a yaw; a formatted one anywhere else is a second way to tell it."""
    formatted = re.compile(r"\{[^{}]*\.yaw\b[^{}]*:[^{}\"]*[fg]\}")
    for package in (engine, tui):
        for file in Path(package.__file__ or "").parent.rglob("*.py"):
            for number, line in enumerate(file.read_text("utf-8").splitlines(), 1):
                found = formatted.search(line)
                assert found is None or "heading_in_degrees" in found[0], f"{file}:{number}: {line.strip()}"
