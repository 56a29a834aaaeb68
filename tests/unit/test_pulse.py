"""Whoever waits for a result without a screen gives a silent engine up, but not one that was only paused with him."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from tui.commands import headless
from tui.commands.headless import LOOK_S, SILENT_S, Pulse


class Left(BaseException):
    """The process has been ended."""


class Clocked:
    """An engine, and the time at which somebody feels its pulse."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = self.beaten = 100.0
        monkeypatch.setattr(headless, "time", SimpleNamespace(monotonic=lambda: self.now))
        monkeypatch.setattr(headless, "os", SimpleNamespace(_exit=self._leave))

    def pulse(self) -> float:
        return self.now - self.beaten

    def _leave(self, code: int) -> None:
        raise Left(code)


def test_an_engine_that_stays_silent_ends_the_process(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    engine = Clocked(monkeypatch)
    pulse = Pulse(engine)  # type: ignore[arg-type]

    def wait() -> None:
        while engine.now < 100 + 10 * SILENT_S:
            engine.now += LOOK_S
            pulse.silence()

    with pytest.raises(Left, match="1"):
        wait()
    assert engine.pulse() == pytest.approx(SILENT_S, abs=2 * LOOK_S)
    assert "not answered" in capsys.readouterr().err


def test_an_engine_that_was_paused_together_with_us_gets_the_time_to_show_that_it_lives(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    engine = Clocked(monkeypatch)
    pulse = Pulse(engine)  # type: ignore[arg-type]
    engine.now += 3600
    assert pulse.silence() == 0.0
    engine.now += LOOK_S
    engine.beaten = engine.now
    assert pulse.silence() == 0.0
