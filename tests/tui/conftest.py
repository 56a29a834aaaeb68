"""Textual without animations and in full colour, set before anything imports it; tests as coroutines; pictures."""

from __future__ import annotations

import os

os.environ["TEXTUAL_ANIMATIONS"] = "none"
os.environ["TEXTUAL_COLOR_SYSTEM"] = "truecolor"
os.environ.pop("NO_COLOR", None)

import asyncio
import inspect
from pathlib import Path

import pytest
from syrupy.assertion import SnapshotAssertion
from syrupy.extensions.image import SVGImageSnapshotExtension
from syrupy.location import PyTestLocation
from syrupy.types import SnapshotIndex

from tests.tui import idle
from tests.tui.pictures import SCREENSHOTS

idle.use()


def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Run tests that are coroutines."""
    if not inspect.iscoroutinefunction(pyfuncitem.obj):
        return None
    names = pyfuncitem._fixtureinfo.argnames
    asyncio.run(pyfuncitem.obj(**{name: pyfuncitem.funcargs[name] for name in names}))
    return True


class _Screenshot(SVGImageSnapshotExtension):
    """One SVG per test case in ``screenshots/``, named by the case: ``acting_120x40.svg``, ``states/idle.svg``."""

    @classmethod
    def dirname(cls, *, test_location: PyTestLocation) -> str:
        return str(SCREENSHOTS)

    @classmethod
    def get_snapshot_name(cls, *, test_location: PyTestLocation, index: SnapshotIndex = 0) -> str:
        return Path(str(index)).name  # as it is called when files are looked for that no test uses any more

    def get_location(self, *, test_location: PyTestLocation, index: SnapshotIndex) -> str:
        return str(Path(self.dirname(test_location=test_location)) / f"{index}.svg")


@pytest.fixture
def screenshot(snapshot: SnapshotAssertion) -> SnapshotAssertion:
    """Compare a picture with its baseline: ``assert svg == screenshot(name="acting_120x40")``."""
    return snapshot.use_extension(_Screenshot)
