"""What the command line takes options to mean."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.errors import ExitCode
from tui.cli import build_parser
from tui.commands.settings import overrides


def test_settings_before_the_command_are_joined_to_those_after_it() -> None:
    before = ["--set", "a=1", "--config", "a.yaml", "--scene", "flat", "--speed", "real"]
    after = ["--set", "b=2", "--config", "b.yaml", "--scene", "workshop"]
    given = build_parser().parse_args([*before, "config", "show", *after])
    assert given.config == [Path("a.yaml"), Path("b.yaml")]
    assert overrides(given) == ["a=1", "b=2", "robot.scene=workshop", "robot.speed=real"]


@pytest.mark.parametrize("place", [slice(0, 0), slice(1, 1)], ids=["before", "after"])
def test_settings_hold_wherever_they_stand(place: slice) -> None:
    argv = ["skills"]
    argv[place] = ["--set", "a=1", "--model", "m"]
    given = build_parser().parse_args(argv)
    assert (given.config, overrides(given)) == (None, ["a=1", "asr.model=m"])


@pytest.mark.parametrize("seconds", ["-1", "0", "nan", "inf", "soon"])
def test_a_time_limit_is_a_number_of_seconds_above_0(seconds: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        build_parser().parse_args(["ask", f"--timeout={seconds}", "beep"])
    assert left.value.code == ExitCode.USAGE
    assert "above 0" in capsys.readouterr().err


def test_a_time_limit_may_be_a_part_of_a_second() -> None:
    assert build_parser().parse_args(["ask", "--timeout", "0.5", "beep"]).timeout == 0.5
