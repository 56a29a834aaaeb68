"""Tests at a real (virtual) microphone: they need programs that not every machine has."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.audio.server import SoundServer, missing


@pytest.fixture
def server() -> Iterator[SoundServer]:
    """A running sound server of the test's own."""
    if reason := missing():
        pytest.fail(reason) if "TEST_AUDIO" in os.environ else pytest.skip(reason)  # make test-audio sets it
    with tempfile.TemporaryDirectory(prefix="sound") as folder, SoundServer(Path(folder)) as server:
        yield server
