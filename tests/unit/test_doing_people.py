"""Acts on people, as actions: who is meant, where they are, and what is asked about."""

from __future__ import annotations

import pytest

from config import load
from config.schema import KnownPerson
from engine.parts.loading import at_home
from engine.plan import Quantity
from engine.planner.doing.acts import calls_of
from engine.planner.doing.doing import Doing, NowhereKnown, Open, Unable
from engine.planner.doing.people import question
from engine.planner.entities import Entities
from engine.planner.worlds.house import build_vocabulary
from engine.skills.people import People
from engine.understanding.meaning import meaning_of
from engine.understanding.notation import read

PEOPLE = People({"William": KnownPerson(aliases=("Bill", "威廉")), "Anna": KnownPerson(gender="female")})


@pytest.fixture(scope="module")
def family() -> Entities:
    return Entities(build_vocabulary(at_home(load(environ={})), people=PEOPLE))


def done(entities: Entities, line: str, holding: str = "") -> str:
    example = read(line)
    calls = calls_of(meaning_of(example.text, example.steps).wanted(), Doing(entities, holding, said=example.text))
    return "; ".join(f"{call.name}({', '.join(map(told, call.positional))})" for call in calls)


def told(argument: Quantity | str) -> str:
    return f"{argument.value:g} {argument.unit}".strip() if isinstance(argument, Quantity) else argument


@pytest.mark.parametrize(
    ("line", "calls"),
    [
        ("find | find {person: Bill} in {place: the kitchen}", "find_person(William, kitchen)"),
        ("find | look for {person: a person waving}", "find_person(person waving)"),
        ("go | go to {person: Anna}", "find_person(Anna)"),
        ("go | go to {person: the woman in the red shirt in the kitchen}", "find_person(woman in red, kitchen)"),
        ("meet | meet {person: Robin} at {place: the desk}", "meet(Robin, desk)"),
        ("follow | follow {person: me}", "person_follow()"),
        ("follow | follow {person: me} to {place: the kitchen}", "person_follow(person, A)"),
        ("follow | follow {person: Anna} from {source: the desk} to {place: the kitchen}",
         "meet(Anna, desk); person_follow(Anna, A)"),
        ("meet follow | meet {1.person: Robin} at {1.place: the desk} and follow {2.person: him}",
         "meet(Robin, desk); person_follow(Robin)"),
        ("go meet follow | go to {1.place: the desk}, meet {2.person: Robin}, and follow {3.person: him}",
         "navigation(N); meet(Robin, desk); person_follow(Robin)"),
        ("guide find | guide {1.person: Robin} to {1.place: the study}, {2.person: him} at {2.place: the desk}",
         "meet(Robin, desk); guide(Robin, D)"),
        ("guide | guide {person: Anna} to {place: the study}", "guide(Anna, D)"),
        ("meet follow guide | meet {1.person: Robin} at {1.place: the desk}, follow {2.person: him}, "
         "take {3.person: him} back",
         "meet(Robin, desk); person_follow(Robin, , 6 s); guide(Robin, N)"),
        ("meet guide | meet {1.person: Robin} at {1.place: the desk} and bring {2.person: him} back here",
         "meet(Robin, desk); guide(Robin, zero)"),
        ("answer | answer {topic: a question} to {person: the person pointing to the left in the kitchen}",
         "find_person(person pointing to the left, kitchen); answer_question(person pointing to the left)"),
        ("tell | say {topic: something about yourself} to {person: Anna}", "tell(Anna, something about yourself)"),
        ("bring | serve {thing: cups} to {person: everyone in the kitchen}", "serve(cup, person, kitchen)"),
        ("bring | 给{person: 厨房里的每个人}送{thing: 杯子}", "serve(cup, person, kitchen)"),
        ("bring | bring {thing: a box} to {person: all the men in the study}", "serve(box, man, study)"),
        ("guide | take {person: me} to {place: the study}", "guide(me, D)"),
        ("tell | tell {person: Anna} that {text: dinner is ready}", "tell(Anna, dinner is ready)"),
        ("find tell | find {1.person: William} in {1.place: the kitchen} and tell {2.person: him} {2.text: to come}",
         "find_person(William, kitchen); tell(William, Please come)"),
        ("tell | let {person: Marta} know {text: the bus is here}", "meet(Marta); tell(Marta, the bus is here)"),
        ("ask come tell | ask {1.person: Anna} {1.text: what she would like to drink}, come and tell {3.person: me}",
         "ask_person(Anna, What would you like to drink?); navigation(zero); report_answer()"),
        ("ask | ask {person: William} {text: to leave}", "tell(William, Please leave.)"),
        ("bring | bring {thing: the blue cup} to {person: William}", "pick_object(blue cup); hand_over(William)"),
        ("bring | bring {thing: the cup} to {person: Robin} at {place: the desk}",
         "pick_object(cup); meet(Robin, desk); hand_over(Robin)"),
        ("pick_up | take {thing: the cup} from {source: Anna}", "take_from(Anna, cup)"),
        ("count | how many {person: people} are in {place: the kitchen}", "count_people(person, kitchen)"),
        ("count | {place: 厨房}里有几个{person: 人}是坐着", "count_people(person sitting, kitchen)"),
        ("count | 有几个{person: 人}在{place: 厨房}里举着右手", "count_people(person raising the right arm, kitchen)"),
        ("count | {place: 厨房}里有几个{person: 人是女的}", "count_people(woman, kitchen)"),
        ("count | {place: 厨房}里有几个{person: 人}是{person: 男孩}", "count_people(man, kitchen)"),
        ("find | 找到{person: 厨房里的男孩}", "find_person(man, kitchen)"),
        ("count | {place: 厨房}里有几个{person: 穿蓝衣服的人}", "count_people(person in blue, kitchen)"),
        ("count | how many {person: people} in {place: the kitchen} are sitting",
         "count_people(person sitting, kitchen)"),
        ("describe | tell me {topic: the name} of {person: the person} at {place: the desk}",
         "find_person(person, desk); describe_person(person, name)"),
        ("introduce | introduce {person: William} to {person: Anna}", "tell(Anna, I would like to introduce William.)"),
        ("meet introduce | meet {1.person: Robin} at {1.place: the desk} and introduce {2.person: him} to "
         "{2.person: everyone} in {2.place: the kitchen}",
         "meet(Robin, desk); tell_everyone(I would like to introduce Robin., person, kitchen)"),
        ("introduce | introduce {person: Robin} at {place: the desk} to {person: Anna} in {place: the kitchen}",
         "meet(Robin, desk); find_person(Anna, kitchen); "
         "tell(Anna, I would like to introduce Robin, who is at the desk.)"),
        ("introduce | 向{person: 威廉}介绍你自己", "tell(William, 你自己)"),
        ("introduce | introduce {person: me} to {person: Anna}", "tell(Anna, Somebody here would like to meet you.)"),
        ("tell | tell {person: the guests} that {text: dinner is ready}", "tell_everyone(dinner is ready, person)"),
        ("ask | ask {person: everyone} in {place: the kitchen} {text: to leave}",
         "tell_everyone(Please leave., person, kitchen)"),
        ("answer | answer {topic: a question} to {person: the person waving in the kitchen}",
         "find_person(person waving, kitchen); answer_question(person waving)"),
        ("find answer | find {1.person: a woman} in {1.place: the kitchen} and tell {2.topic: the time}",
         "find_person(woman, kitchen); tell(woman, the time)"),
        ("tell | 告诉{person: 威廉}{text: 饭好了}", "tell(William, 饭好了)"),
        ("greet | say hello to {person: the guests in the kitchen}", "tell_everyone(Hello., person, kitchen)"),
        ("greet | greet {person: everybody}", "say(Hello.)"),
        ("greet | say hi to {person: the woman in red} at {place: the desk}",
         "find_person(woman in red, desk); say(Hello.)"),
        ("wave | wave to {person: the man at the desk}", "find_person(man, desk); arm_shake()"),
        ("ask tell | ask {1.person: Anna} {1.text: if she is hungry} and tell {2.person: me} {2.topic: what she says}",
         "ask_person(Anna, Are you hungry?); report_answer()"),
        ("follow | follow {person: Robin}", "meet(Robin); person_follow(Robin)"),
        ("guide | show {person: Robin} the way to {place: the study}", "meet(Robin); guide(Robin, D)"),
        ("meet | meet {person: Robin}", "meet(Robin)"),
        ("ask | ask {person: robin} {text: if she wants tea}", "meet(Robin); ask_person(Robin, Do you want tea?)"),
        ("bring tell | bring {1.thing: the cup} to {1.person: Robin} and tell {2.person: her} {2.text: it is hot}",
         "pick_object(cup); meet(Robin); hand_over(Robin); tell(Robin, it is hot)"),
        ("find | 找{person: 厨房里穿红衣服的人}", "find_person(person in red, kitchen)"),
    ],
)  # fmt: skip
def test_acts_on_people_become_calls_of_skills(family: Entities, line: str, calls: str) -> None:
    assert done(family, line) == calls


@pytest.mark.parametrize(
    ("line", "gap"),
    [("follow | follow {person: him}", "who"), ("meet | meet {person: my aunt}", "where_person"),
     ("follow | follow {person: my aunt}", "where_person"), ("guide | guide {person: Anna}", "where"),
     ("bring | bring {thing: the cup} to {person: my aunt}", "where_person"), ("ask | ask {person: Anna}", "what"),
     ("tell | 告诉{person: 我姑妈}{text: 饭好了}", "where_person")],
)  # fmt: skip
def test_what_was_not_said_is_asked_for(family: Entities, line: str, gap: str) -> None:
    with pytest.raises(Open) as asked:
        done(family, line)
    assert asked.value.question == gap


def test_nobody_is_looked_for_where_this_house_has_no_such_place(family: Entities) -> None:
    with pytest.raises(NowhereKnown):
        done(family, "meet | meet {person: Anna} at {place: the swimming pool}")
    with pytest.raises(Unable):
        done(family, "find | find {person: the person with the gr33n t4ttoo}")


@pytest.mark.parametrize(
    ("told_of", "asked"),
    [("what she would like to drink", "What would you like to drink?"),
     ("her name", "What is your name?"), ("when she goes home", "When do you go home?"),
     ("where he lives", "Where do you live?"),
     ("if she wants tea", "Do you want tea?"), ("whether he is hungry", "Are you hungry?"),
     ("how old they are", "How old are you?"), ("what is the time", "What is the time?"),
     ("her favourite colour", "What is your favourite colour?"), ("他想喝什么", "请问，您想喝什么？")],
)  # fmt: skip
def test_a_question_is_put_to_whom_it_is_about(told_of: str, asked: str) -> None:
    assert question(told_of) == asked
