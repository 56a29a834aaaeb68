"""Stop and the end of a task are understood in every language, whatever language plans are made in."""

from __future__ import annotations

import pytest

from engine.planner.phrases.stopping import is_end_task, is_only_stop, is_stop
from engine.planner.text.language import all_phrases

LANGUAGES = sorted(all_phrases())


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_phrase_of_every_language_does_what_it_is_listed_for(language: str) -> None:
    sections = all_phrases()[language]
    stop = sections["stop"]
    comma = "，" if language == "zh" else ", "
    rest = "左转" if language == "zh" else "turn left"
    assert [said for said in stop["anywhere"] + stop["alone"] if not is_only_stop(said)] == []
    assert [said for said in stop["anywhere"] if not is_stop(f"{said}{comma}{rest}")] == []
    assert [said for said in stop["anywhere"] if not is_stop(f"{rest}{comma}{said}")] == []
    assert [said for said in sections["end_task"] if not is_end_task(said) or is_stop(said)] == []
    assert [said for said in stop["fillers"] if is_stop(said) or is_end_task(said)] == []


@pytest.mark.parametrize(
    "said",
    [
        "停",
        "停！",
        "停。",
        "停停停",
        "停，停，停！",
        "停下",
        "停止",
        "别动！",
        "站住",
        "不要动",
        "等一下",
        "停车",
        "请停车。",
        "機器人，請停下來！",  # traditional characters
        "別動",
        "停下来，然后左转",
        "停下来然后左转",  # recognisers leave out the comma …
        "前面有猫 停下",  # … or write a space for it
        "不，停！",
        "哎呀快停下",
        "马上停下来吧",
        "OK停",
        "stop, 停!",
        "停～～",
    ],
)
def test_a_chinese_stop_is_understood_however_it_is_written(said: str) -> None:
    assert is_stop(said)
    assert not is_end_task(said)


@pytest.mark.parametrize(
    "said",
    [
        "在停车场等我",
        "去停车场",
        "不停地转",
        "不停",
        "不要停",
        "别停下来",
        "说停",
        "去厨房然后停下",
        "等一下再走",
        "停五秒",
        "停了吗",
        "停电了",
        "停止任务",
        "你好",
        "好的，谢谢",
    ],
)
def test_a_chinese_word_that_only_holds_a_stop_stops_nothing(said: str) -> None:
    assert not is_stop(said)


@pytest.mark.parametrize(
    "said",
    [
        "结束任务",
        "结束当前任务。",
        "請結束當前任務！",
        "休息一下吧",
        "好的，就这样",
        "没事了，谢谢",
        "再见！",
        "OK，再見",
    ],
)
def test_the_end_of_a_task_is_understood_in_chinese(said: str) -> None:
    assert is_end_task(said)
    assert not is_stop(said)


@pytest.mark.parametrize("said", ["结束任务，然后去厨房", "去休息室", "没事了吗", "重新开始音乐"])
def test_the_end_of_a_task_is_a_whole_sentence_in_chinese_too(said: str) -> None:
    assert not is_end_task(said)


def test_a_chinese_stop_with_more_behind_it_is_not_only_a_stop() -> None:
    assert is_only_stop("停，停下来！")
    assert not is_only_stop("停下来，然后左转")


@pytest.mark.parametrize("said", ["Wait", "Please wait", "Cancel", "Hold on", "等一下", "不行"])
def test_what_stops_only_by_itself_is_no_stop_while_somebody_talks_on(said: str) -> None:
    assert is_stop(said)
    assert not is_stop(said, ended=False)


@pytest.mark.parametrize("said", ["Stop", "No, stop", "wait, stop", "Freeze!", "Stop and turn", "停", "喂，停下来"])
def test_a_stop_is_one_whatever_follows(said: str) -> None:
    assert is_stop(said, ended=False)


def test_a_very_long_text_is_not_looked_at() -> None:
    assert is_stop("停" * 1000)
    assert not is_stop("停" * 1001)
