"""What becomes of a condition whose meaning is known: what is looked for, whether it holds, and what is done then."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import pytest

from config import load
from engine.events import Outcome
from engine.parts.loading import at_home
from engine.perception.memory import WorldMemory
from engine.perception.people import Looks, PeopleMemory
from engine.plan import Action, Plan
from engine.planner import build
from engine.planner.request import Happened, Heard, Language, NoPlan, PlanRequest, Ran, Said
from engine.planner.text.conditions import without_empty_branches
from engine.planner.understood import Understood
from engine.robot.robot import Robot
from engine.session.recall import Recall
from tests.unit.test_people import saw, somebody
from tests.unit.test_understood import Written


@pytest.fixture
def reader() -> Written:
    return Written()


@pytest.fixture
def understood(reader: Written, monkeypatch: pytest.MonkeyPatch) -> Understood:
    monkeypatch.setattr(build, "learned_reader", lambda folder: reader)
    planner = build.build_planner(at_home(load()))
    assert planner._learned is not None
    return planner._learned


def shown(found: Plan | NoPlan | None) -> str:
    """Actions, or what is said instead."""
    if isinstance(found, Plan):
        return "; ".join(map(str, found.actions)) or found.response
    return "" if found is None else found.answer


def first(understood: Understood, text: str, language: Language = "en") -> str:
    """What is done first."""
    heard = Heard(PlanRequest(text), text, language)
    return shown(understood.plan(heard) or understood.no_order(heard))


def plan(understood: Understood, text: str) -> Plan:
    found = understood.plan(Heard(PlanRequest(text), text, "en"))
    assert isinstance(found, Plan)
    return found


def happening(text: str, *plans: Plan, seen: str = "", outcome: Outcome = "ok") -> PlanRequest:
    """What is asked after these plans, the last of which came to this."""
    ran: list[Happened] = []
    for one in plans:
        ran += [one, *(Ran(action, outcome) for action in one.actions)]
    return PlanRequest("", (Said(text), *ran), sees=lambda thing: thing == seen)


def then(understood: Understood, text: str, tried: Plan, outcome: Outcome) -> str:
    """What is done after a plan that came to this."""
    return shown(understood.decided(Heard(happening(text, tried, outcome=outcome), text, "en")))


def after(understood: Understood, text: str, *seen: str, language: Language = "en") -> str:
    """What is done after the look, where these things were seen, by their names."""
    request = PlanRequest("", sees=lambda thing: thing in seen)
    return shown(understood.decided(Heard(request, text, language)))


@pytest.mark.parametrize(
    ("line", "seen", "done"),
    [
        (
            "if seen then tell end | {1.person: someone} in {1.place: the hall}? tell {2.person: them} {2.text: hi}",
            "person",
            "tell(person, hi)",
        ),
        (
            "if seen then follow end | if {1.person: somebody} is in {1.place: the hall} follow {2.person: them}",
            "person",
            "person_follow(person, , 0)",
        ),
        (
            "if seen then pick_up end | if {1.thing: the ball} is in {1.place: the hall} pick {2.thing: him} up",
            "ball",
            "pick_object(ball)",
        ),
        (
            "if seen then go end | if {1.thing: the ball} is in {1.place: the hall} go to {2.thing: it}",
            "ball",
            "navigate_to_object(ball)",
        ),
        (
            "if seen then sort end | if {1.thing: block 3} is in {1.place: the study} sort {2.thing: it}",
            "block 3",
            "apriltag_sort(3)",
        ),
        (
            "if unseen then go wait end | if {1.place: the study} holds {1.person: nobody} go {2.place: in} and wait "
            "{3.time: ten seconds}",
            "",
            "navigation(D); wait(10)",
        ),
        (
            "if unseen then find end | if {1.thing: the ball} isn't in {1.place: the hall} try {2.place: the kitchen}",
            "",
            "navigation(A); locate(ball)",
        ),
    ],
)
def test_what_depends_on_a_condition_is_about_what_it_found(
    understood: Understood, reader: Written, line: str, seen: str, done: str
) -> None:
    assert after(understood, reader.knows(line), seen) == done


def test_only_one_of_several_was_seen_so_it_is_that(understood: Understood, reader: Written) -> None:
    for which in ("it", "the cup"):
        text = reader.knows(
            f"if seen then bring end | is {{1.thing: a cup}} in {{1.place: the bedroom}}? bring {{2.person: me}} "
            f"{{2.thing: {which}}}"
        )
        assert after(understood, text, "cup", "blue cup") == "carry(blue cup, zero, )"
        assert after(understood, text, "cup", "blue cup", "white cup").startswith("Which one")
    other = reader.knows(
        "if seen then bring end | {1.thing: a cup} in {1.place: the bedroom}? bring {2.person: me} "
        "{2.thing: the other cup}"
    )
    assert "blue" not in after(understood, other, "cup", "blue cup").partition("(")[2]


def test_there_in_a_condition_is_where_that_leads_which_depends_on_it(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if unseen then bring end | take {2.thing: the white cup} to {2.place: the bedroom} unless {1.thing: a cup} is "
        "in {1.place: there}"
    )
    assert first(understood, text) == "navigation(C); seewhat()"
    assert after(understood, text) == "carry(white cup, C, )"


@pytest.mark.parametrize(
    "line",
    [
        "if seen then beep end | if {1.thing: something} is on {1.place: the stool}, beep",
        "if seen then beep end | if there's {1.thing: something lying} on {1.place: the stool}, beep",
        "if seen then beep end | if {1.thing: stuff} is on {1.place: the stool}, beep",
    ],
)
def test_something_is_any_thing_and_no_question(understood: Understood, reader: Written, line: str) -> None:
    text = reader.knows(line)
    assert first(understood, text) == "navigation(L); seewhat()"
    assert after(understood, text, "thing").startswith("beep")
    assert after(understood, text) == "I see nothing there."


def test_the_floor_of_a_room_is_that_room(understood: Understood, reader: Written) -> None:
    for place in ("the bedroom floor", "the floor in the bedroom", "the floor of the bedroom"):
        text = reader.knows(f"if seen then beep end | if {{1.thing: the ball}} is on {{1.place: {place}}}, beep")
        assert first(understood, text) == "navigation(C); seewhat()"
    here = reader.knows(
        "go if seen then beep end | to {1.place: the study}; is {2.thing: the ball} on {2.place: the floor}"
    )
    assert first(understood, here) == "navigation(D); seewhat()"


def test_what_was_seen_is_told_among_other_things(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if seen then beep else come tell end | if {1.thing: the ball} is in {1.place: the hall} beep, if not come "
        "back and tell {4.person: me}"
    )
    assert after(understood, text) == "navigation(zero); say(I see no ball there.)"


@pytest.mark.parametrize(
    "line",
    [
        "bring if unseen then bring end | bring {1.person: me} {1.thing: the red box} or if you can't find "
        "{2.thing: that} {3.thing: the blue box}",
        "if unseen then bring else bring end | bring {2.thing: the red box}, or {3.thing: the blue box} if "
        "{1.thing: the red one} is nowhere to be found",
        "bring if unseen then bring end | 拿{1.thing: 红盒子}，找不到{2.thing: 红的}就拿{3.thing: 蓝盒子}",
    ],
)
def test_what_may_be_missing_is_tried_and_how_that_went_decides(
    understood: Understood, reader: Written, line: str
) -> None:
    text = reader.knows(line)
    tried = plan(understood, text)
    assert (shown(tried), tried.finished, tried.minds_failure) == ("carry(red box, zero, )", False, True)
    assert then(understood, text, tried, "failed") == "carry(blue box, zero, )"
    assert then(understood, text, tried, "ok") == "All right."


def test_where_it_lies_has_to_be_said_for_a_look(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "bring if unseen then bring end | bring {1.thing: the red box} from {1.source: the desk} or if {2.thing: it} "
        "isn't there {3.thing: the blue box}"
    )
    assert first(understood, text) == "navigation(N); seewhat()"


def test_what_is_seen_elsewhere_is_not_there(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if unseen then put end | unless {1.thing: the ball} is on {1.place: the shelf} put {2.thing: it} "
        "{2.place: there}"
    )

    def decided(spot: str) -> str:
        request = PlanRequest("", sees=lambda thing: thing == "ball", may_be_at=lambda thing, place: place == spot)
        return shown(understood.decided(Heard(request, text, "en")))

    assert decided("shelf") == "The ball is there."
    assert decided("coffee table") == "pick_object(ball); place_object(shelf)"


def test_one_condition_after_the_other_is_looked_at(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if seen then throw_away end | if {1.thing: the bottle} is on {1.place: the counter} or {1.place: the desk} "
        "bin {2.thing: it}"
    )
    counter = plan(understood, text)
    assert shown(counter) == "navigation(M); seewhat()"
    desk = understood.decided(Heard(happening(text, counter), text, "en"))
    assert isinstance(desk, Plan)
    assert (shown(desk), desk.decided) == ("navigation(N); seewhat()", (False,))
    there = happening(text, counter, desk, seen="bottle")
    assert shown(understood.decided(Heard(there, text, "en"))) == "pick_object(bottle); place_in_bin()"
    assert shown(understood.decided(Heard(happening(text, counter, desk), text, "en"))) == "I see no bottle there."


def test_a_thing_is_at_one_of_two_places(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if seen then bring end if seen then stop end | if {1.thing: the ball} is on {1.place: the sofa} {2.thing: it} "
        "goes to {2.place: the kitchen}, and if {3.thing: it} is on {3.place: the stool} it stays"
    )
    sofa = plan(understood, text)
    assert shown(understood.decided(Heard(happening(text, sofa, seen="ball"), text, "en"))) == "carry(ball, A, )"
    stool = replace(happening(text, sofa, seen="ball"), may_be_at=lambda thing, place: place == "stool")
    assert shown(understood.decided(Heard(stool, text, "en"))) == "The ball is there.", "it was seen from the sofa"
    assert shown(understood.decided(Heard(happening(text, sofa), text, "en"))) == "navigation(L); seewhat()"


@pytest.mark.parametrize("words", ["put", "drop", "leave"])
def test_what_is_left_as_it_is_is_not_taken(understood: Understood, reader: Written, words: str) -> None:
    text = reader.knows(
        f"if seen then {words} else throw_away end | if {{1.thing: the ball}} is in {{1.place: the hall}} leave it "
        "alone, if it's anywhere else bin {3.thing: it}"
    )
    assert after(understood, text, "ball") == "The ball is there."
    assert after(understood, text) == "pick_object(ball); place_in_bin()"


def test_whoever_is_only_named_is_asked_for_the_name(understood: Understood, reader: Written) -> None:
    for name in ("Tom's", "tom", "汤姆"):
        text = reader.knows(
            f"if seen then tell end | if {{1.person: {name}}} in {{1.place: the hall}} tell "
            "{2.person: him} {2.text: hi}"
        )
        tried = plan(understood, text)
        who = {"汤姆": "汤姆"}.get(name, "Tom")
        assert (shown(tried), tried.minds_failure) == (f"meet({who}, hall)", True)
        assert then(understood, text, tried, "ok") == f"tell({who}, hi)"
        assert then(understood, text, tried, "failed") == "I see nobody there."


def test_a_mess_is_what_lies_about(understood: Understood, reader: Written) -> None:
    text = reader.knows("if is then clean end | if {1.place: the hall} is {1.state: a bit messy} clean {2.place: it}")
    assert first(understood, text) == "navigation(E); seewhat()"
    assert after(understood, text, "thing") == "clean_room(hall)"
    assert after(understood, text) == "I see nothing there."


def test_it_and_there_are_what_was_told_of_before(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if seen then bring end | The bottle was on the dining table just now. If {1.thing: it}'s still "
        "{1.place: there} take {2.thing: it} to {2.place: the counter}"
    )
    assert first(understood, text) == "navigation(I); seewhat()"
    text = reader.knows(
        "if seen then pick_up put end | take {2.thing: the blocks} off {2.source: the desk} if there are "
        "{1.thing: any} on {1.place: it} and put {3.thing: them} on {3.place: the shelf}"
    )
    assert first(understood, text) == "navigation(N); seewhat()"
    assert after(understood, text, "block 2", "block") == "navigation(N); pick_object(block 2); place_object(shelf)"


@pytest.mark.parametrize(
    "ending",
    [
        "; otherwise leave it alone", ", if it isn't, do nothing", "; if not, never mind", ", else don't bother",
    ],
)  # fmt: skip
def test_what_is_done_with_nothing_otherwise_is_not_read(understood: Understood, reader: Written, ending: str) -> None:
    text = reader.knows(f"if seen then beep end | if {{1.thing: the ball}} is in {{1.place: the hall}} beep{ending}")
    assert without_empty_branches(text).rstrip() == text.removesuffix(ending)
    assert len(without_empty_branches(text)) == len(text)
    assert first(understood, text) == "navigation(E); seewhat()"
    assert after(understood, text) == "I see no ball there."


def test_without_a_condition_it_takes_all_back() -> None:
    for ending in ("，不在就算了。", "，没有的话就不用管", "，在别处不用管"):
        assert without_empty_branches(f"如果球在走廊就响一声{ending}").rstrip(" 。") == "如果球在走廊就响一声"
    for text in ("go to the kitchen, otherwise leave it alone", "if it isn't there, do nothing", "别动，不用了"):
        assert without_empty_branches(text) == text


def test_rubbish_is_all_that_lies_there(understood: Understood, reader: Written) -> None:
    text = reader.knows("if seen then clean end | do {2.place: the study} if there's {1.thing: junk} in {1.place: it}")
    assert after(understood, text, "thing") == "clean_room(study)"


def test_what_is_tidy_is_not_tidied(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if is then clean end | is {1.place: the hall} {1.state: tidy}? clean {2.place: it} if it isn't"
    )
    assert after(understood, text, "thing") == "clean_room(hall)"
    assert after(understood, text) == "I see nothing there."


def test_more_than_one_is_counted_as_a_state_too(understood: Understood, reader: Written) -> None:
    text = reader.knows("if is then nod end | {1.place: 茶几上}{1.state: 超过一个盒子}的话就点头")
    assert after(understood, text, "red box", "blue box", language="zh") == "arm_nod()"
    assert after(understood, text, "red box", language="zh") != "arm_nod()"


def test_nowhere_is_not_there(understood: Understood, reader: Written) -> None:
    text = reader.knows("find if unseen then nod end | find {1.thing: the ball}, if {2.thing: its nowhere} nod")
    assert after(understood, text) == "arm_nod()"
    assert after(understood, text, "ball") == "The ball is there."


def test_to_stop_when_told_to_needs_no_condition(understood: Understood, reader: Written) -> None:
    text = reader.knows("patrol if event then stop end | 在{1.place: 各个房间}巡逻，{2.topic: 我喊停}你再停")
    assert first(understood, text, "zh") == "patrol()"


@pytest.mark.parametrize(
    ("line", "holding"),
    [
        ("if is then put else beep end | if {1.state: got your hands full} put {2.thing: it} down, else beep", "ball"),
        ("if is then put else beep end | 手上要是{1.state: 拿着东西}就把{2.thing: 它}放下，不然响一声", "ball"),
        ("if is then put else beep end | if what {1.person: you're} carrying is {1.state: a box} put {2.thing: it} "
         "down, else beep", "red box"),
    ],
)  # fmt: skip
def test_what_it_holds_is_asked_in_many_words(understood: Understood, reader: Written, line: str, holding: str) -> None:
    text = reader.knows(line)
    held = [shown(understood.plan(Heard(PlanRequest(text, holding=what), text, "en"))) for what in (holding, "")]
    assert held == ["putdown()", "beep(0.2)"]


def test_all_of_them_have_to_be_there(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if seen then nod else shake end | if {1.thing: all three blocks} are in {1.place: the study} nod, else shake"
    )
    assert after(understood, text, "block 1", "block 2", "block 3") == "arm_nod()"
    assert after(understood, text, "block", "block 1", "block 2") == "arm_shake()"


def test_a_colour_is_seen_and_of_another_colour_it_is_another_thing(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if is then throw_away else bring end | if {1.thing: the box on the desk} is {1.state: red} bin {2.thing: it}, "
        "else bring {3.thing: it} to {3.place: the hall}"
    )
    assert first(understood, text) == "navigation(N); seewhat()"
    assert after(understood, text, "red box") == "pick_object(red box); place_in_bin()"
    assert after(understood, text, "blue box").startswith("Which one")


def test_somebody_who_may_be_the_speaker_is_asked_about(understood: Understood, reader: Written) -> None:
    me = reader.knows("if seen then beep end | if {1.person: I'm} in {1.place: the hall} beep")
    assert "whether that is you" in after(understood, me, "person")


def test_whoever_has_no_name_and_shows_nothing_is_no_condition(understood: Understood, reader: Written) -> None:
    for who in ("the postman", "the dog", "you"):
        text = reader.knows(f"if seen then beep end | if {{1.person: {who}}} is in {{1.place: the hall}} beep")
        assert "cannot tell people apart" in first(understood, text)


def test_people_are_counted_where_it_depends_on_how_many_there_are(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if seen then nod else shake end | if {1.person: more than two people} are in {1.place: the hall} nod, "
        "else shake"
    )
    assert first(understood, text) == "count_people(person, hall)"

    def decided(**found: int) -> str:
        ran = Ran(Action("count_people", {"who": "person", "where": "hall"}), "ok", "In the hall I see …", found)
        request = PlanRequest("", (ran,), sees=lambda thing: True)
        return shown(understood.decided(Heard(request, text, "en")))

    assert [decided(people=2), decided(people=3)] == ["arm_shake()", "arm_nod()"]
    assert decided() == "", "nobody was counted"


@pytest.mark.parametrize(
    ("condition", "answer", "done"),
    [
        ("event | {topic: she says yes}", "Yes, please.", "bring"),
        ("event | {topic: she says yes}", "No, thank you.", "nod"),
        ("event | {topic: she says no}", "I do not want any.", "bring"),
        ("event | {topic: she doesn't}", "I don't.", "bring"),
        ("event | {topic: so}", "I would like some.", "bring"),
        ("is | {person: she} is {state: thirsty}", "I am.", "bring"),
        ("is_not | {person: she} isn't {state: thirsty}", "No.", "bring"),
        ("event | {topic: she wants tea}", "Tea, please.", "bring"),
        ("event | {topic: she wants tea}", "Coffee, please.", "nod"),
        ("event | {topic: she says yes}", "The weather is fine.", "ask"),
        ("event | {topic: 她说要}", "不用了。", "nod"),
    ],
)
def test_what_somebody_answers_decides(
    understood: Understood, reader: Written, condition: str, answer: str, done: str
) -> None:
    kind, _, words = condition.partition(" | ")
    text = reader.knows(
        f"ask if {kind} then bring else nod end | ask {{1.person: Anna}} {{1.text: whether she is thirsty}} and if "
        f"{words.replace('{', '{2.')} bring {{3.person: her}} {{3.thing: the bottle}}, else nod"
    )
    assert first(understood, text) == "meet(Anna, ); ask_person(Anna, Are you thirsty?)"
    ran = Ran(Action("ask_person", {"who": "Anna", "question": "…"}), "ok", "", {"answer": answer})
    request = PlanRequest("", (ran,), sees=lambda thing: False)
    found = shown(understood.decided(Heard(request, text, "en")))
    does = {"bring": "pick_object(bottle); hand_over(Anna)", "nod": "arm_nod()"}
    assert found == does.get(done, f"The answer was: “{answer}”. What shall I do?")


def test_no_answer_decides_what_was_not_asked(understood: Understood, reader: Written) -> None:
    for line in (
        "ask if event then nod end | ask {1.person: Anna} {1.text: how she is} and if {2.topic: the bell rings} nod",
        "go if event then nod end | go to {1.place: the hall} and if {2.topic: she says yes} nod",
    ):
        assert "cannot tell" in first(understood, reader.knows(line))


@pytest.mark.parametrize(
    ("line", "who"),
    [
        (
            "if is then nod end | if {1.person: anybody} is {1.state: sitting} in {1.place: the hall} nod",
            "person sitting",
        ),
        ("if is then nod end | if {1.person: the guest in the hall} is {1.state: wearing red} nod", "person in red"),
        ("if is then nod end | if {1.person: Anna} is {1.state: waving} in {1.place: the hall} nod", "Anna waving"),
        ("if is then nod end | 如果{1.place: 走廊}里有{1.person: 人}{1.state: 坐着}就点头", "person sitting"),
    ],
)
def test_how_somebody_looks_is_seen(understood: Understood, reader: Written, line: str, who: str) -> None:
    text = reader.knows(line)
    assert first(understood, text) == "navigation(E); seewhat()"
    assert after(understood, text, "person", who) == "arm_nod()"
    assert after(understood, text) == "I see nobody there."
    asleep = reader.knows("if is then nod end | if {1.person: the guest} is {1.state: asleep} nod")
    assert "not whether it is asleep" in first(understood, asleep)


def test_there_already_is_where_it_is_to_go(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if is_not then bring end | take {2.thing: the blue box} to {2.place: the bedroom} if {1.thing: it} isn't "
        "{1.state: there already}"
    )
    assert first(understood, text) == "navigation(C); seewhat()"
    assert after(understood, text) == "carry(blue box, C, )"


@pytest.mark.parametrize(
    ("line", "worked", "failed"),
    [
        ("if is then nod else shake end | if {1.person: you} {1.state: found it} nod, else shake", "nod", "shake"),
        ("if event then nod end | if {1.topic: that worked} nod", "nod", "All right."),
        ("if event then nod end | if {1.topic: that didn't work} nod", "All right.", "nod"),
        ("if is_not then nod end | unless {1.person: you} {1.state: managed it} nod", "All right.", "nod"),
        ("if event then nod end | 如果{1.topic: 没找到}就点头", "All right.", "nod"),
    ],
)
def test_how_the_last_action_went_is_on_record(
    understood: Understood, reader: Written, line: str, worked: str, failed: str
) -> None:
    text = reader.knows(line)
    ran = [Ran(Action("locate", {"object": "ball"}), outcome) for outcome in ("ok", "failed")]
    found = [shown(understood.plan(Heard(PlanRequest(text, (one,)), text, "en"))) for one in ran]
    assert [one.removeprefix("arm_").removesuffix("()") for one in found] == [worked, failed]


def test_a_plan_goes_on_where_an_action_has_worked(understood: Understood, reader: Written) -> None:
    worked = reader.knows("pick_up if event then nod end | grab {1.thing: the ball}, and if {2.topic: that works} nod")
    assert first(understood, worked) == "pick_object(ball); arm_nod()"
    failed = reader.knows("pick_up if event then nod end | grab {1.thing: the ball}, if {2.topic: that fails} nod")
    tried = plan(understood, failed)
    assert (shown(tried), tried.finished) == ("pick_object(ball)", False)
    assert then(understood, failed, tried, "failed") == "arm_nod()"
    assert then(understood, failed, tried, "ok") == "All right."


@pytest.mark.parametrize(
    ("line", "looks"),
    [
        ("if seen then else bring end | if {1.thing: the ball} is in {1.place: the hall}, leave it. If it's anywhere "
         "else, bring {2.person: me} {2.thing: it}", True),
        ("if seen then bring end | if {1.thing: the ball} is in {1.place: the hall}, bring {2.person: me} "
         "{2.thing: it}, and if it's in {1.place: the study}, don't", True),
        ("if seen then bring end | bring {2.person: me} {2.thing: the ball} if {1.thing: it} is in "
         "{1.place: the hall}, no", False),
    ],
)  # fmt: skip
def test_what_is_to_be_left_in_one_branch_is_not_all_taken_back(
    understood: Understood, reader: Written, line: str, looks: bool
) -> None:
    assert first(understood, reader.knows(line)).startswith("navigation") == looks


def test_of_several_the_one_that_is_there_is_meant_or_the_one_that_is_told_more_of(
    understood: Understood, reader: Written
) -> None:
    there = reader.knows("bring | bring {person: me} {thing: the cup} from {source: the stool}")
    assert first(understood, there) == "carry(cup, zero, stool)"
    told = reader.knows("pick_up | pick up {thing: the cup}, the white one")
    assert first(understood, told) == "pick_object(white cup)"
    for text in ("pick_up | pick up {thing: the cup}", "go bring | go to {1.place: the hall}, get {2.thing: the cup}"):
        assert first(understood, reader.knows(text)).startswith("Which one")


def test_he_is_who_was_named_before(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "find if is then tell end | find {1.person: Tom} and if {2.person: he} is {2.state: sitting} tell "
        "{3.person: him} {3.text: to get up}"
    )
    assert first(understood, text).startswith("meet(Tom, )")
    assert after(understood, text, "person", "Tom sitting") == "tell(Tom sitting, Please get up)"


def test_what_lies_about_is_named_first_and_thrown_away_as_it(understood: Understood, reader: Written) -> None:
    text = reader.knows("fact throw_away | there's {1.thing: litter} lying about, throw {2.thing: it} out")
    assert first(understood, text) == "clear_rubbish()"


def test_two_or_more_may_stand_behind_what_is_counted(understood: Understood, reader: Written) -> None:
    text = reader.knows("if seen then nod end | {1.thing: two boxes or more} on {1.place: the stool}? nod")
    assert after(understood, text, "red box", "blue box") == "arm_nod()"
    assert after(understood, text, "red box") == "It is not so."


def test_whether_or_not_is_no_condition(understood: Understood, reader: Written) -> None:
    for whatever in ("whether or not", "no matter if", "even if"):
        text = reader.knows(f"go | {whatever} the ball is in the hall, go to {{1.place: the bedroom}}")
        assert first(understood, text) == "navigation(C)"
        read = reader.knows(
            f"if seen then go end | {whatever} {{1.thing: the ball}} is in {{1.place: the hall}}, go to "
            "{2.place: the bedroom}"
        )
        assert first(understood, read) == "navigation(C)", "whatever the reader makes of it"


def test_a_place_with_somebody_in_it_is_not_empty(understood: Understood, reader: Written) -> None:
    text = reader.knows("if is then nod end | if {1.place: the study} is {1.state: empty} nod")
    assert after(understood, text) == "arm_nod()"
    assert after(understood, text, "person") == "There is something there."
    assert after(understood, text, "thing") == "There is something there."


def test_whether_it_holds_something_needs_no_look_in_any_words(understood: Understood, reader: Written) -> None:
    text = reader.knows("if is then nod end | if {1.person: you've} {1.state: got the ball} nod")
    held = Heard(PlanRequest(text, holding="ball"), text, "en")
    assert shown(understood.plan(held)) == "arm_nod()"
    zh = reader.knows("if is then put end | 要是{1.state: 手里拿着东西}就放下")
    assert shown(understood.plan(Heard(PlanRequest(zh, holding="ball"), zh, "zh"))) == "putdown()"


def test_who_was_seen_is_known_by_what_shows() -> None:
    memory = WorldMemory(PeopleMemory({"Cleo": Looks("green")}))
    robot = cast(Robot, None)  # only its memory is asked
    saw(memory.people, somebody("green", y=-0.5), somebody("red", y=0.5), t=5.0)
    sees = Recall(robot, memory).since(4.0)
    assert (sees("Cleo"), sees("Tom"), sees("person in red"), sees("person in blue")) == (True, False, True, False)
    assert sees("person")
    assert not sees("woman"), "that does not show"
    assert not Recall(robot, memory).since(6.0)("Cleo")


# What lies somewhere is known after a look


def test_all_that_lies_somewhere_is_looked_at_before_it_is_taken(understood: Understood, reader: Written) -> None:
    text = reader.knows("tidy | tidy {1.thing: everything} on {1.source: the sofa} to {1.place: the shelf}")
    assert first(understood, text) == "navigation(H); seewhat()"
    assert after(understood, text, "ball", "block 1", "thing") == (
        "pick_object(ball); place_object(shelf); pick_object(block 1); place_object(shelf)"
    )
    assert after(understood, text) == "I see nothing there."


@pytest.mark.parametrize(
    "line",
    [
        "pick_up ; put | take {1.thing: the boxes} off {1.source: the sofa} and put {2.thing: them} on "
        "{2.place: the shelf}",
        "tidy | tidy {1.thing: all boxes} on {1.source: the sofa} to {1.place: the shelf}",
    ],
)
def test_of_a_kind_those_are_taken_that_lie_there(understood: Understood, reader: Written, line: str) -> None:
    text = reader.knows(line)
    assert first(understood, text) == "navigation(H); seewhat()"
    assert after(understood, text, "red box", "blue box", "box") == (
        "pick_object(red box); place_object(shelf); pick_object(blue box); place_object(shelf)"
    )


def test_whichever_lies_there_is_brought(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "bring | {1.thing: whichever of the two cups} is on {1.source: the sofa}, bring it to {1.person: me}"
    )
    assert first(understood, text) == "navigation(H); seewhat()"
    assert after(understood, text, "blue cup", "cup") == "carry(blue cup, zero, )"


def test_one_look_decides_several_conditions(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if seen then put end if seen then put end | "
        "look at {1.place: the sofa}, if {1.thing: the white cup} is there put {2.thing: it} on "
        "{2.place: the counter}, if {3.thing: the blue cup} is there put {4.thing: it} on {4.place: the shelf}"
    )
    both = "pick_object(white cup); place_object(counter); pick_object(blue cup); place_object(shelf)"
    assert after(understood, text, "white cup", "blue cup") == both
    assert after(understood, text, "blue cup") == "pick_object(blue cup); place_object(shelf)"


def test_readings_that_look_alike_are_as_likely_together_as_their_sum(understood: Understood, reader: Written) -> None:
    text = "if the ball is on the sofa put it on the shelf else the desk will do"
    begin = "if {1.thing: the ball} is on {1.place: the sofa} put {2.thing: it} on {2.place: the shelf} else"
    reader.knows(f"if seen then put else nod end | {begin} the desk will do", 0.3)
    reader.knows(f"if seen then put else beep end | {begin} the desk will do", 0.3)
    assert first(understood, text) == "navigation(H); seewhat()"
    assert after(understood, text, "ball") == "pick_object(ball); place_object(shelf)"


# Who, how many, whether it worked, what is held


def test_she_is_who_was_named_in_what_depends_on_it(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if seen then bring else put end | take {2.thing: the ball} to {2.person: Anna} if {1.person: she's} in "
        "{1.place: the study}, else leave {3.thing: it} on {3.place: the desk}"
    )
    tried = plan(understood, text)
    assert shown(tried) == "meet(Anna, study)"
    assert then(understood, text, tried, "failed") == "pick_object(ball); place_object(desk)"


@pytest.mark.parametrize(
    "line",
    [
        "count ; if seen then beep end | count {1.person: the people} in {1.place: the hall}, beep if there are "
        "{2.person: at least two}",
        "count ; if seen then beep end | count {1.person: the people in the hall} and if {2.thing: more than one} beep",
    ],
)
def test_what_was_counted_is_what_there_has_to_be_so_many_of(
    understood: Understood, reader: Written, line: str
) -> None:
    assert first(understood, reader.knows(line)) == "count_people(person, hall)"


@pytest.mark.parametrize("role", ["person: you", "topic: you can't"])
def test_who_cannot_do_it_has_failed_and_says_so(understood: Understood, reader: Written, role: str) -> None:
    kind, end = ("unseen", " can't") if role.startswith("person") else ("event", "")
    text = reader.knows(
        f"find ; if {kind} then come ; say end | find {{1.thing: the ball}}, if {{2.{role}}}{end} come and say "
        "{4.text: so}"
    )
    tried = plan(understood, text)
    assert shown(tried) == "locate(ball)"
    assert then(understood, text, tried, "failed") == "navigation(zero); say(It did not work.)"
    assert then(understood, text, tried, "ok") == "All right."


@pytest.mark.parametrize(
    "line",
    [
        "if unseen then pick_up end | if there's {1.thing: nothing} in {1.place: your hand} take {2.thing: the ball}",
        "if is then pick_up end | if there is {1.state: nothing in your hand} take {2.thing: the ball}",
    ],
)
def test_the_robot_knows_what_is_in_its_hand(understood: Understood, reader: Written, line: str) -> None:
    text = reader.knows(line)
    assert first(understood, text) == "pick_object(ball)"
    held = Heard(PlanRequest(text, holding="red box"), text, "en")
    assert shown(understood.plan(held)) == "All right."


def test_the_box_is_the_one_that_was_named(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if is then put else put end | if {1.place: the desk} is {1.state: empty}, put {2.thing: the blue box} on "
        "{2.place: it}; otherwise put {3.thing: the box} on {3.place: the shelf}"
    )
    assert after(understood, text, "ball", "thing") == "pick_object(blue box); place_object(shelf)"


def test_a_room_that_nobody_is_in_is_tidied(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if unseen then tidy end | if {1.person: nobody} is in {1.place: the hall}, tidy {2.place: it} up"
    )
    assert after(understood, text) == "clean_room(hall)"


def test_what_is_fetched_instead_is_not_where_it_was_looked_for(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "bring ; if unseen then bring end | bring me {1.thing: the white cup}, {3.thing: the blue one} if there is "
        "none on {2.place: the desk}"
    )
    assert first(understood, text) == "navigation(N); seewhat()"
    assert after(understood, text, "white cup") == "carry(white cup, zero, )"
    assert after(understood, text) == "carry(blue cup, zero, )"


def test_beside_a_piece_of_furniture_is_somewhere_in_its_room(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if seen then bring end | if {1.thing: the white cup} is {1.place: by my bed}, bring {2.thing: it} to me"
    )
    request = PlanRequest(
        "",
        sees=lambda thing: thing == "white cup",
        may_be_at=lambda thing, place: place in ("bedroom", "bedside table"),
    )
    assert shown(understood.decided(Heard(request, text, "en"))) == "carry(white cup, zero, )"


def test_one_of_those_that_are_there_is_taken(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "if seen then bring end | if there are {1.thing: two cups on the counter}, bring {2.thing: one} to "
        "{2.place: the desk}"
    )
    assert after(understood, text, "white cup", "blue cup", "cup") == "carry(white cup, N, )"
    text = reader.knows(
        "if unseen then put end | if there's no {1.thing: bottle} on {1.place: the desk} put {2.thing: one} "
        "{2.place: there}"
    )
    assert after(understood, text) == "pick_object(bottle); place_object(desk)"


def test_what_is_counted_may_be_told_as_a_fact(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "count ; if event then applaud end | count {1.thing: the blocks} on {1.place: the shelf}, when "
        "{2.topic: it is three} clap"
    )
    assert first(understood, text) == "navigation(O); seewhat()"
    assert after(understood, text, "block 1", "block 2", "block 3", "block") == "arm_applaud()"
    assert after(understood, text, "block 1", "block") == "It is not so."


def test_what_was_asked_about_is_what_is_brought(understood: Understood, reader: Written) -> None:
    text = reader.knows(
        "ask ; if event then bring end | ask {1.person: Anna} {1.text: if she would like the bottle}, if "
        "{2.topic: she says yes} bring {3.thing: it} to {3.person: her}"
    )
    tried = plan(understood, text)
    ran = tuple(Ran(action, "ok", data={"answer": "yes please"}) for action in tried.actions)
    request = PlanRequest("", (Said(text), tried, *ran), sees=lambda thing: False)
    assert shown(understood.decided(Heard(request, text, "en"))) == "pick_object(bottle); hand_over(Anna)"


@pytest.mark.parametrize(
    "line",
    [
        "if is then go else clean end | if {1.place: the hall} is {1.state: free of clutter} go to "
        "{2.place: the exit}, else clean {3.place: it}",
        "if unseen then go else clean end | if there is no {1.thing: mess} in {1.place: the hall} go to "
        "{2.place: the exit}, else clean {3.place: it}",
    ],
)
def test_a_mess_is_all_that_lies_there(understood: Understood, reader: Written, line: str) -> None:
    text = reader.knows(line)
    assert after(understood, text, "thing") == "clean_room(hall)"
    assert after(understood, text) == "navigation(U)"
