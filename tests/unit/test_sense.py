"""The words of a request say whether a condition is negated."""

from __future__ import annotations

import pytest

from engine.planner.accounted import accounted
from engine.planner.doing.sense import in_its_sense
from engine.understanding.meaning import If, Meaning, meaning_of
from engine.understanding.notation import read


def meaning(line: str) -> Meaning:
    example = read(line)
    return in_its_sense(meaning_of(example.text, example.steps))


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        ("if unseen then nod end | if {1.thing: nothing} is on {1.place: the stool}, nod", "unseen"),
        ("if seen then nod end | if {1.thing: nothing} is on {1.place: the stool}, nod", "unseen"),
        ("if seen then nod end | if {1.person: nobody} is in {1.place: the hall}, nod", "unseen"),
        ("if unseen then nod end | if there are {1.thing: no cups} on {1.place: the stool}, nod", "unseen"),
        ("if unseen then nod end | if {1.thing: a cup} is on {1.place: the stool}, nod", "seen"),
        ("if seen then nod end | unless {1.thing: a cup} is on {1.place: the stool}, nod", "unseen"),
        ("if seen then nod end | unless {1.thing: nothing} is on {1.place: the stool}, nod", "seen"),
        ("if seen then nod end | if {1.thing: a cup} isn't on {1.place: the stool}, nod", "unseen"),
        ("if seen then nod end | check for {1.thing: a cup} on {1.place: the stool} and if there's none nod", "unseen"),
        ("if seen then nod end | see if {1.thing: a cup} is on {1.place: the stool} and if it isn't nod", "unseen"),
        ("if seen then nod end | see if {1.thing: a cup} is on {1.place: the stool} and if it is nod", "seen"),
        ("if seen then nod else beep end | if {1.thing: a cup} is on {1.place: the stool} nod, if not beep", "seen"),
        ("if unseen then nod else beep end | no sign of {1.thing: a cup}? nod, otherwise beep", "unseen"),
        ("if seen then nod end | see if {1.thing: a cup} is {1.place: there}, if so nod, if not never mind", "seen"),
        ("if seen then nod end | if {1.thing: a cup} is {1.place: there} nod, if not never mind", "seen"),
        ("if seen then nod end | is {1.thing: a cup} {1.place: there}? if not never mind, if it is nod", "seen"),
        ("if seen then nod end | if you don't see {1.thing: a cup} never mind, if you do nod", "seen"),
        ("if seen then nod end | 看看{1.place: 凳子}上有没有{1.thing: 杯子}，有就点头，没有就算了", "seen"),
        ("if seen then nod end | {1.place: 凳子}上要是有{1.thing: 没见过的杯子}就点头", "seen"),
        ("if unseen then nod end | {1.place: 凳子}上要是没有{1.thing: 杯子}就点头", "unseen"),
        ("if seen then nod end | 看看{1.place: 凳子}上有没有{1.thing: 杯子}，没有的话就点头", "unseen"),
    ],
)
def test_the_words_say_whether_a_condition_is_negated(line: str, kind: str) -> None:
    (node,) = meaning(line).nodes
    assert isinstance(node, If)
    assert node.condition.kind == kind
    assert not node.condition.words("thing").startswith("no")
    assert not node.condition.words("person").startswith("no")


@pytest.mark.parametrize(
    ("line", "stands"),
    [
        ("if unseen then beep end | if you don't see {1.thing: the ball} beep", True),
        ("if unseen then beep end | if you can't find {1.thing: the ball} beep", True),
        ("if unseen then beep end | if you don't see {1.thing: the ball} don't beep", False),
        ("if unseen then beep end | don't beep if {1.thing: the ball} is gone", False),
        ("if seen then beep end | if {1.thing: the ball} is there don't beep", False),
    ],
)
def test_a_negation_in_a_condition_forbids_nothing_and_any_other_does(line: str, stands: bool) -> None:
    assert accounted(meaning(line)) == stands
