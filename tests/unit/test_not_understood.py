"""What nobody could understand is told so, and moves nothing: nonsense, single letters, pieces of names."""

from __future__ import annotations

import asyncio
from functools import cache
from importlib.resources import files

import pytest

from config import load
from engine.errors import ExitCode
from engine.parts.loading import at_home
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.planner import Planner
from engine.planner.request import NoPlan, PlanRequest, Said
from engine.understanding.lexicon import WORDS, lexicon, words_in, written
from engine.understanding.training.lexicon import made

NONSENSE = (
    "zzz blah", "asdf", "blah blah blah", "xyzzy", "lorem ipsum dolor", "hjkl", "gnarf", "wibble wobble", "brrr", "kkk",
    "zz", "sdfkjh sdf", "mumble mumble", "ffff ffff", "tralala", "ooga booga", "snorf the blick", "flurb the wug",
    "glorp", "pfft", "flurb", "x y z", "...", "?!",
    "呵呵呵", "阿巴阿巴", "哔哩哔哩", "咕噜咕噜", "天地玄黄", "啦啦啦",
)  # fmt: skip
PIECES = (
    *"abcdefghijklmnopqrstuvwxyzAGIM", "m m", "A B", "M C", "m please", "go m", "1234", "tsk", "qwerty", "aaaa", "ki",
    "kit", "kitch", "kitche", "bedr", "liv", "livin", "st", "stu", "sof", "cof", "din", "tab", "cou", "hom", "offi",
    "wo", "ro", "des", "in", "on", "th", "kichen", "bedrom", "zzz kitchen", "kitchen 7",
    "厨", "客", "卧", "书", "房", "门", "茶", "沙", "饭", "餐", "室", "充", "垃圾", "柜", "m号",
)  # fmt: skip


@cache
def real() -> Planner:
    return build_planner(at_home(load(environ={})))


def planned(text: str, *happened: NoPlan | Said) -> Plan | NoPlan:
    return asyncio.run(real().plan(PlanRequest(text, happened)))


@pytest.mark.parametrize("text", NONSENSE)
def test_nonsense_is_told_not_to_be_understood(text: str) -> None:
    found = planned(text)
    assert isinstance(found, NoPlan), found
    assert found.code == "not_understood"
    assert text in found.answer


@pytest.mark.parametrize("before", ["go to the moon", "go to the kitchen"])
@pytest.mark.parametrize("text", ["flurb", "please flurb", "glorp"])
def test_nonsense_does_not_say_how_to_do_once_more_what_was_asked_for_before(before: str, text: str) -> None:
    found = planned(text, Said(before), planned(before))
    assert isinstance(found, NoPlan), found
    assert found.code == "not_understood"


@pytest.mark.parametrize("text", ["quickly", "a bit slower", "慢一点", "快点"])
def test_known_words_do(text: str) -> None:
    before = "去厨房" if not text.isascii() else "go to the kitchen"
    assert isinstance(planned(text, Said(before), planned(before)), Plan)


@pytest.mark.parametrize("text", PIECES)
def test_letters_and_pieces_of_names_are_no_orders(text: str) -> None:
    assert isinstance(found := planned(text), NoPlan), found


@pytest.mark.parametrize(
    ("text", "near", "symbol"),
    [("m", "counter", "M"), ("M", "counter", "M"), ("b", "living room", "B"), ("liv", "living room", "B"),
     ("sof", "sofa", "H"), ("bedrom", "bedroom", "C"), ("kichen", "kitchen", "A"), ("zzz kitchen", "kitchen", "A"),
     ("客", "客厅", "B"), ("充", "充电座", "F")],
)  # fmt: skip
def test_the_place_that_may_be_meant_is_asked_about_and_a_yes_goes_there(text: str, near: str, symbol: str) -> None:
    asked = planned(text)
    assert isinstance(asked, NoPlan)
    assert (asked.code, asked.exit_code, asked.suggestions) == ("did_you_mean", ExitCode.CLARIFY, (near,))
    assert near in asked.answer
    found = planned("yes" if text.isascii() else "是的", Said(text), asked)
    assert isinstance(found, Plan)
    assert [str(action) for action in found.actions] == [f"navigation({symbol})"]


@pytest.mark.parametrize(("text", "names"), [("st", "the study or the stool"), ("书", "书房还是书架还是书桌")])
def test_of_several_places_one_is_asked_which(text: str, names: str) -> None:
    asked = planned(text)
    assert isinstance(asked, NoPlan)
    assert names in asked.answer
    found = planned(asked.options[0], Said(text), asked)
    assert isinstance(found, Plan)
    assert [str(action) for action in found.actions] == ["navigation(D)"]


@pytest.mark.parametrize(("text", "step"), [("beeep", "Beep"), ("danse", "Dance"), ("spinn around", "Turn left")])
def test_a_misspelt_act_is_asked_about(text: str, step: str) -> None:
    asked = planned(text)
    assert isinstance(asked, NoPlan)
    assert (asked.code, bool(asked.offer)) == ("unsure", True)
    assert step in asked.answer


@pytest.mark.parametrize(
    ("text", "action"),
    [("stop", "stop()"), ("kitchen", "navigation(A)"), ("the kitchen", "navigation(A)"), ("Kitchen!", "navigation(A)"),
     ("home", "navigation(F)"), ("bedroom please", "navigation(C)"), ("the big kitchen", "navigation(A)"),
     ("sofa", "navigation(H)"), ("bed", "navigation(Q)"), ("bin", "navigation(K)"), ("to the study", "navigation(D)"),
     ("here", "navigation(zero)"), ("beep", "beep(0.2)"), ("nod", "arm_nod()"), ("left", "move_left(90, 1)"),
     ("go to M", "navigation(M)"), ("go forwrd 1 metre", "move_forward(1, 0.3)"),
     ("厨房", "navigation(A)"), ("客厅", "navigation(B)"), ("桌子", "navigation(I)"), ("家", "navigation(F)"),
     ("回家", "navigation(F)"), ("去厨房", "navigation(A)"), ("停", "stop()")],
)  # fmt: skip
def test_short_orders_in_known_words_are_done_as_before(text: str, action: str) -> None:
    found = planned(text)
    assert isinstance(found, Plan), found
    assert [str(one) for one in found.actions] == [action]


@pytest.mark.parametrize(
    "text",
    ["hello", "hello Grzegorz", "thanks", "good job", "great", "yes", "ok", "you are funny", "你好", "谢谢", "好的"],
)
def test_talk_in_known_words_is_answered_as_before(text: str) -> None:
    found = planned(text)
    assert isinstance(found, Plan), found
    assert found.actions == ()
    assert found.response


def test_go_alone_asks_where_to() -> None:
    found = planned("go")
    assert isinstance(found, NoPlan)
    assert found.answer.startswith("Where to?")


def test_the_list_of_words_is_that_of_the_sentences_that_the_reader_learns_from() -> None:
    assert (files("assets") / "understanding" / WORDS).read_text("utf-8") == made()


def test_what_is_written_in_the_list_is_read_again() -> None:
    assert written(sorted(lexicon())) == (files("assets") / "understanding" / WORDS).read_text("utf-8")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Go to M, 5 metres!", ["go", "to", "m", "metres"]),
        ("去厨房", ["去厨", "厨房"]),
        ("停！", ["停."]),
        ("go 去", ["go", "去."]),
    ],
)
def test_two_chinese_characters_next_to_one_another_are_a_word(text: str, words: list[str]) -> None:
    assert list(words_in(text)) == words


@pytest.mark.parametrize("text", ["我叫你去拿瓶子的话，声音小了吗", "my name is on that box"])
def test_what_is_no_name_is_not_learned_as_one(text: str) -> None:
    found = planned(text)
    assert not isinstance(found, Plan) or not found.actions
