"""What the doctor examines beside a running engine: nothing twice that the engine has, and nothing for ever."""

from __future__ import annotations

import threading

from config import load
from config.schema import Settings
from engine.handle import PartStatus
from tui.doctor.diagnosis import CHECKS
from tui.doctor.examiner import Examiner
from tui.doctor.finding import Check, Finding

SETTINGS = load(environ={})


def forbidden(settings: Settings) -> Finding:
    raise AssertionError("the engine has it")


def fine(settings: Settings) -> Finding:
    return Finding("fine", "ok", "as it should be")


def test_what_the_engine_has_is_not_looked_at_a_second_time_the_engine_is_asked() -> None:
    checks = [Check("recogniser", forbidden, "recogniser"), Check("microphone", forbidden, "microphone", device=True)]
    parts = [PartStatus("recogniser", "ready", "whisper-base"), PartStatus("microphone", "missing", "It is gone.")]
    found = list(Examiner(SETTINGS, checks=checks).examine(parts))
    assert found == [
        Finding("recogniser", "ok", "whisper-base"),
        Finding("microphone", "missing", "It is gone."),
    ]


def test_a_part_that_loads_is_told_as_that() -> None:
    [found] = Examiner(SETTINGS, checks=[Check("large model", forbidden, "model")]).examine(
        [PartStatus("model", "loading", "40 %")]
    )
    assert (found.state, found.detail) == ("limited", "loading 40 %")


def test_a_device_that_only_one_can_have_is_left_alone_even_when_the_engine_tells_nothing_of_it() -> None:
    [found] = Examiner(SETTINGS, checks=[Check("loudspeaker", forbidden, "voice", device=True)]).examine([])
    assert found.state == "limited"
    assert "not looked at" in found.detail


def test_every_check_that_opens_a_device_or_loads_a_model_has_a_part_to_ask() -> None:
    asked = {check.name for check in CHECKS if check.part is not None}
    assert asked == {
        "recogniser", "large model", "microphone", "voice", "loudspeaker", "simulation", "graphics", "wake module",
        "wake words", "robot", "ROS graph",
    }  # fmt: skip
    assert {check.name for check in CHECKS if check.device} >= {"microphone", "loudspeaker"}


def test_a_check_that_hangs_is_told_and_the_others_go_on_and_it_is_not_begun_again_while_it_hangs() -> None:
    begun, go_on = [], threading.Event()

    def hangs(settings: Settings) -> Finding:
        begun.append(True)
        go_on.wait(30)
        return fine(settings)

    examiner = Examiner(SETTINGS, checks=[Check("hangs", hangs), Check("fine", fine)], limit_s=0.05)
    first = list(examiner.examine([]))
    again = list(examiner.examine([]))
    go_on.set()
    assert [finding.state for finding in first] == [finding.state for finding in again] == ["limited", "ok"]
    assert "no answer within 0.05 s" in first[0].detail
    assert "still" in again[0].detail
    assert len(begun) == 1


def test_a_check_with_a_fault_is_a_finding() -> None:
    [found] = Examiner(SETTINGS, checks=[Check("odd", forbidden)]).examine([])
    assert found.state == "limited"
    assert "AssertionError" in found.detail
