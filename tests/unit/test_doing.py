"""What is meant, as actions of this house: the roles decide which skill serves."""

from __future__ import annotations

import pytest

from config import load
from engine.parts.loading import at_home
from engine.plan import Quantity
from engine.planner.doing.acts import calls_of
from engine.planner.doing.conditions import of_itself
from engine.planner.doing.doing import Doing, NowhereKnown, Open, Unable
from engine.planner.doing.people import message
from engine.planner.doing.sought import sought
from engine.planner.entities import Entities
from engine.planner.worlds.house import build_vocabulary
from engine.understanding.meaning import Condition, If, meaning_of
from engine.understanding.notation import read


@pytest.fixture(scope="module")
def flat() -> Entities:
    return Entities(build_vocabulary(at_home(load())))


def done(flat: Entities, line: str, holding: str = "") -> str:
    example = read(line)
    calls = calls_of(meaning_of(example.text, example.steps).wanted(), Doing(flat, holding, said=example.text))
    return "; ".join(f"{call.name}({', '.join(map(told, call.positional))})" for call in calls)


def told(argument: Quantity | str) -> str:
    return f"{argument.value:g} {argument.unit}".strip() if isinstance(argument, Quantity) else argument


@pytest.mark.parametrize(
    ("line", "calls"),
    [
        ("go | over to {place: the desk}", "navigation(N)"),
        ("go | drive up to {thing: the red box}", "navigate_to_object(red box)"),
        ("forward | roll on {amount: half a metre}", "move_forward(0.5 m)"),
        ("backward | 后退{amount: 一米}", "move_forward(-1 m)"),
        ("forward | straight on for {time: three seconds}", "set_cmdvel(0.3 m/s, 0 m/s, 0 rad/s, 3 s)"),
        ("turn_left | to your left", "move_left(90 deg)"),
        ("turn_right | right by {amount: 45}", "move_right(45 deg)"),
        ("turn_around | spin {times: twice}", "move_left(720 deg)"),
        ("sideways_right | shift {amount: 20 cm} to the right {manner: slowly}", "move_sideways(-0.2 m, 0.1 m/s)"),
        ("bring | get {person: me} {thing: the bottle} from {source: the kitchen}", "carry(bottle, zero, kitchen)"),
        ("bring | {thing: the ball} to {place: the study}", "carry(ball, D)"),
        ("put | {thing: the ball} onto {place: the desk}", "pick_object(ball); place_object(desk)"),
        ("put | {thing: the ball} in {place: the trash can}", "pick_object(ball); place_in_bin()"),
        ("pick_up put | grab {1.thing: the ball} and put {2.thing: it} on {2.place: the desk}",
         "pick_object(ball); place_object(desk)"),
        ("look | have a look at {place: the kitchen}", "scan_room(kitchen)"),
        ("look | check {place: the desk}", "navigation(N); seewhat()"),
        ("look | look {place: behind you}", "move_left(180 deg); seewhat()"),
        ("find | where is {thing: the blue cup}", "locate(blue cup)"),
        ("throw_away | dump {thing: the rubbish in the kitchen}", "clean_room(kitchen)"),
        ("pick_up | gather up {thing: the litter} from the floor", "clear_rubbish()"),
        ("pick_up | pick up {thing: the nearest thing}", "pick_object(nearest thing)"),
        ("pick_up | {thing: 最大的盒子}", "pick_object(biggest box)"),
        ("bring | get {person: me} {thing: the left most object} from {source: the desk}",
         "navigation(N); carry(leftmost thing, zero)"),
        ("bring | get {person: me} {thing: the box to the right of the blue cup}",
         "carry(box right of blue cup, zero)"),
        ("describe | what is {thing: the smallest object} on {place: the desk}", "list_things(smallest thing, desk)"),
        ("describe | which are {thing: the three biggest boxes} on {place: the desk}",
         "list_things(biggest box, desk, 3)"),
        ("describe | 告诉我{place: 书桌}上{thing: 最大的三个盒子}是哪些", "list_things(biggest box, desk, 3)"),
        ("count | how many {thing: cups} are on {place: the desk}", "list_things(cup, desk)"),
        ("find | find {thing: two cups} in {place: the kitchen}", "list_things(cup, kitchen)"),
        ("beep | honk {times: three times}", "beep(); beep(); beep()"),
        ("light | go {colour: 红色}", "light(red)"),
        ("light | make it {colour: green coloured}", "light(green)"),
        ("repeat forward end | {0.times: twice} {1.amount: 1 m}", "move_forward(1 m); move_forward(1 m)"),
        ("go look | go to {1.place: every room} and look",
         "scan_room(hall); scan_room(living room); scan_room(kitchen); scan_room(study); scan_room(bedroom)"),
        ("clean | clean {place: all rooms} but {except: the hall} and {except: the study}",
         "clean_room(living room); clean_room(kitchen); clean_room(bedroom)"),
        ("bring | {thing: all the cups} but {except: the blue one} to {place: the desk}", "carry(white cup, N)"),
        ("put | 除了{except: 红色的}，{thing: 所有的盒子}都放到{place: 书桌上}",
         "; ".join(f"pick_object({colour} box); place_object(desk)" for colour in ("blue", "green", "yellow"))),
        ("put | {thing: all the red things} on {place: the desk}", "tidy(red, desk)"),
        ("follow until event end | follow {1.person: me} until {2.topic: I say stop}", "person_follow()"),
        ("turn_left until seen end | turn left until you see {2.thing: the ball}", "locate(ball)"),
        ("bring put | take {1.thing: the ball} over to {1.place: the bedroom}, put {2.thing: it} on {2.place: the bed}",
         "pick_object(ball); place_object(bed)"),
        ("bring put | get {1.thing: the blue cup} from {1.source: the bedroom}, leave {2.thing: it} on "
         "{2.place: the counter}", "navigation(C); pick_object(blue cup); place_object(counter)"),
        ("bring bring | get {1.thing: the ball} and hand {2.thing: it} to {2.person: me}", "carry(ball, zero)"),
        ("bring bring | {1.thing: the ball} to {1.place: the kitchen}, then to {2.place: the study} {2.thing: it}",
         "carry(ball, A); carry(ball, D)"),
        ("bring put | bring {1.thing: the ball} to {1.place: the kitchen} and put {2.thing: it} down",
         "carry(ball, A)"),
        ("tidy | remove {thing: any red things higher than 5 cm}", "color_remove_higher(red, 0.05 m)"),
        ("tidy | clear {thing: tagged blocks that stick up over ten centimetres}", "apriltag_remove_higher(0.1 m)"),
        ("tidy | 把{thing: 高过五厘米的方块}清掉", "apriltag_remove_higher(0.05 m)"),
        ("put | put {thing: block three} in {place: its proper place}", "apriltag_sort(3)"),
        ("sort | put {thing: block three} where it belongs", "apriltag_sort(3)"),
        ("follow tidy | along {1.thing: the blue line} and clear {2.thing: whatever is in the way}",
         "follow_line_clear(blue)"),
        ("bring bring | get {1.person: me} {1.thing: the red box}, then {2.thing: the blue one} ~2.person",
         "carry(red box, zero); carry(blue box, zero)"),
        ("bring bring | 给{1.person: 我}拿{1.thing: 红色的盒子}，再拿{2.thing: 蓝的那个}",
         "carry(red box, zero); carry(blue box, zero)"),
        ("put | {thing: all the blue stuff} on {place: the bed}", "tidy(blue, bed)"),
        ("pick_up | {thing: the one with the number two tag on it}", "pick_object(block 2)"),
        ("remember go go_back | save it, go to {2.place: the desk}, back to {3.place: the saved position}",
         "get_current_pose(); navigation(N); navigation(zero)"),
        ("patrol | make the rounds through {place: the house}", "patrol()"),
        ("pick_up put | gather {1.thing: whatever is red} and put {2.thing: it} on {2.place: the desk}",
         "tidy(red, desk)"),
        ("bring put | get {1.thing: the bottle} and {1.thing: the ball}, put {2.thing: them both} on "
         "{2.place: the desk}",
         "pick_object(bottle); place_object(desk); pick_object(ball); place_object(desk)"),
        ("put | {thing: everything that is red} goes on {place: the desk}", "tidy(red, desk)"),
        ("go | get over to {place: the settee}", "navigation(H)"),
        ("put | {thing: the ball} {place: next to the desk}", "carry(ball, N)"),
        ("put | {thing: the ball} on {place: the worktop}", "pick_object(ball); place_object(counter)"),
        ("greet | say hi to {person: my neighbour}", "say(Hello.)"),
        ("leave go | leave {1.place: the kitchen} for {2.place: the study}", "navigation(D)"),
        ("look report | look at {1.place: the desk} and {2.topic: report}", "navigation(N); seewhat()"),
        ("go report | go to {1.place: the desk} and report {2.topic: where you are}", "navigation(N); report_pose()"),
        ("light wait switch_off | {1.colour: red} light, wait {2.time: a second}, turn {3.thing: it} off",
         "light(red); wait(1 s); light(off)"),
        ("meet | meet {person: me} in {place: the kitchen}", "navigation(A)"),
        ("put | put {thing: the ball} {place: next to the bottle}",
         "pick_object(ball); navigate_to_object(bottle); putdown()"),
        ("put | put {thing: the ball} {place: where the blue cup is}",
         "pick_object(ball); navigate_to_object(blue cup); putdown()"),
        ("push | move {thing: the ball} to {place: the sofa}", "pick_object(ball); place_object(sofa)"),
        ("put go | put {1.thing: the ball} down and go to {2.place: the kitchen}",
         "pick_object(ball); putdown(); navigation(A)"),
        ("put | put {thing: the green} and {thing: the yellow box} on {place: the desk}",
         "pick_object(green box); place_object(desk); pick_object(yellow box); place_object(desk)"),
        ("go | go to {place: where the rubbish goes}", "navigation(K)"),
        ("go | 去{place: 充电的地方}", "navigation(F)"),
        ("go | go to {place: the table by the bed}", "navigation(R)"),
        ("tell | tell {person: everyone in the house} {text: food is up}", "tell_everyone(food is up, person)"),
        ("tell | 跟{person: 厨房里的人}都说一声{text: 我出门了}", "tell_everyone(我出门了, person, kitchen)"),
        ("count | how many {person: people} are in {place: the flat}", "count_people(person)"),
        ("follow until seen end | follow {1.person: Tom} until {2.person: he} is in {2.place: the kitchen}",
         "meet(Tom); person_follow(Tom, A)"),
        ("pick_up put | take {1.thing: what Anna gives you} and put {2.thing: it} on {2.place: the desk}",
         "meet(Anna); take_from(Anna); place_object(desk)"),
        ("go | drive to {place: the table for dining}", "navigation(I)"),
        ("go | drive to {place: the table of coffee}", "navigation(G)"),
        ("go | 去{place: 那个出口地方}", "navigation(U)"),
        ("put | 把{thing: 瓶子}放在{place: 凳子的上面}", "pick_object(bottle); place_object(stool)"),
        ("pick_up throw_away | collect {1.thing: all yellow things} and put them in the bin", "tidy(yellow, bin)"),
        ("follow until event end | follow {1.person: Tom} until {2.topic: he gets to the kitchen}",
         "meet(Tom); person_follow(Tom, A)"),
        ("go beep | visit {1.place: the stool} and {1.place: the desk}, and beep at each of them",
         "navigation(L); beep(); navigation(N); beep()"),
        ("bring bring | {1.thing: the ball} to {1.place: the desk}, {2.thing: the yellow box} too",
         "carry(ball, N); carry(yellow box, N)"),
        ("clean report | clean {1.place: the hall} and tell me {2.topic: when you're done}",
         "clean_room(hall); say(Done.)"),
        ("pick_up throw_away | pick up {1.thing: the litter} and throw {2.thing: it} out", "clear_rubbish()"),
        ("go look | go to {1.place: the study} and look at {2.place: the floor}", "navigation(D); seewhat()"),
        ("repeat go beep end | do {0.times: two things}: go to {1.place: the hall} and beep", "navigation(E); beep()"),
        ("wait | wait {place: where you are} {time: ten seconds}", "wait(10 s)"),
        ("find | is {thing: the ball} in {place: the study} or {place: the hall}", "navigation(D); locate(ball)"),
        ("bring | bring {person: me} {thing: the cup that's closest to you}", "carry(nearest cup, zero)"),
        ("bring bring | give {1.person: Mia} {1.thing: the ball} and {2.person: Ben} {2.thing: the bottle}",
         "pick_object(ball); meet(Mia); hand_over(Mia); pick_object(bottle); meet(Ben); hand_over(Ben)"),
        ("clean report | tidy up {1.place: the study}, then tell me {2.topic: what you did}", "clean_room(study)"),
        ("go tell | go to {1.place: the kitchen} and tell {2.person: me}", "navigation(A)"),
        ("bring tell | get {1.thing: the ball}, let {2.person: me} know {2.topic: how it went}", "carry(ball, zero)"),
        ("greet | say hello to {person: everyone} in {place: the kitchen}", "tell_everyone(Hello., person, kitchen)"),
        ("find | is there {thing: anything} on {place: the desk}", "navigation(N); seewhat()"),
        ("wait | wait for {person: me} at {place: the kitchen door}", "navigation(T)"),
        ("throw_away | {thing: everything green} goes in the bin", "tidy(green, bin)"),
        ("put bring | {1.thing: the ball} to {1.place: the desk}, fetch {2.thing: the bottle} from {2.source: there}",
         "pick_object(ball); place_object(desk); carry(bottle, zero, desk)"),
        ("bring throw_away | fetch {1.thing: the ball} and toss {2.thing: it}", "pick_object(ball); place_in_bin()"),
        ("bring put | bring {1.person: me} {1.thing: the ball} and put {2.thing: the bottle} on {2.place: the desk}",
         "carry(ball, zero); pick_object(bottle); place_object(desk)"),
        ("arm_up together beep | arm up and beep", "arm_up(); beep()"),
        ("backward | back {amount: ever so slightly}", "move_forward(-0.2 m)"),
        ("forward | {amount: one metre twenty} ahead", "move_forward(1.2 m)"),
        ("turn | turn {amount: 180 degrees}", "move_left(180 deg)"),
        ("nod again | nod and again", "arm_nod(); arm_nod()"),
        ("clean | clean {place: the room}", "clean_room()"),
        ("go wait | go to {1.place: the desk} and wait {2.place: there} for {2.time: a second}",
         "navigation(N); wait(1 s)"),
        ("bring bring | {1.thing: the ball} to {1.place: the desk}, {2.thing: the bottle} {2.place: there} too",
         "carry(ball, N); carry(bottle, N)"),
        ("face | face {thing: the wall on your right}", "move_right(90 deg)"),
        ("put put | put {1.thing: the ball}, well, put {2.thing: it} on {2.place: the desk}",
         "pick_object(ball); place_object(desk)"),
        ("clean | hoover {place: the whole house}", "clean_room()"),
        ("tidy | sort out {place: the entire apartment}", "clean_room()"),
        ("clean | mop {place: the other half of the kitchen}", "clean_room(kitchen)"),
        ("tidy | {thing: 两个杯子}收到{place: 书桌上}",
         "pick_object(white cup); place_object(desk); pick_object(blue cup); place_object(desk)"),
        ("follow push | on {1.thing: the blue line}, push {2.thing: anything on it} off", "follow_line_clear(blue)"),
        ("follow | 顺着{thing: 走廊里那条蓝线}走", "follow_line(blue)"),
        ("bring | 把{thing: 那杯茶}端给{person: 我}", "carry(cup, zero)"),
        ("tell | let {person: Marta} know {text: the bus is here}", "meet(Marta); tell(Marta, the bus is here)"),
        ("go wait | over to {1.place: the sofa} and wait for {2.person: my brother}", "navigation(H)"),
        ("arm_turn | arm {place: as far to the left as it goes}", "servo1_move(180 deg)"),
        ("beep | hold the horn for {time: two seconds}", "beep(2 s)"),
        ("beep | toot {times: twice}, {time: a second} each", "beep(1 s); beep(1 s)"),
        ("backward | 往后退{amount: 一点点}", "move_forward(-0.2 m)"),
        ("turn_around | do {amount: a full turn}", "move_left(360 deg)"),
        ("forward backward | ahead {1.amount: 80 cm} and then back {2.amount: the same distance}",
         "move_forward(0.8 m); move_forward(-0.8 m)"),
        ("turn_right turn | right {1.amount: forty degrees} and {2.amount: another forty} the same way",
         "move_right(40 deg); move_right(40 deg)"),
        ("turn_left | in the left direction {amount: hundred degree}", "move_left(100 deg)"),
        ("go wait | go to {1.place: the kitchen door}, there you wait", "navigation(T)"),
        ("put put | {1.thing: that ball} on {1.place: the bed}, stick {2.thing: it} on {2.place: the shelf}",
         "navigation(Q); pick_object(ball); place_object(shelf)"),
        ("tidy | {thing: blue stuff} goes on {place: the workbench}", "tidy(blue, workbench)"),
        ("pick_up | {thing: the box of yellow colour}", "pick_object(yellow box)"),
        ("put | {thing: the box of colour green} on {place: the counter}",
         "pick_object(green box); place_object(counter)"),
        ("tidy | {thing: everything blue that's lying around} to {place: the shelf}", "tidy(blue, shelf)"),
        ("put | {thing: the bottle} on {place: the floor by the bed}", "carry(bottle, Q)"),
        ("bring guide | fetch {1.person: Oliver} at {1.place: the exit} and lead {2.person: him} to "
         "{2.place: the sofa}",
         "meet(Oliver, exit); guide(Oliver, H)"),
        ("sort | the hall's an absolute tip, sort {thing: it} out", "clean_room(hall)"),
        ("remember | this is Julia; remember her name, {text: Julia}", "learn_name(Julia)"),
        ("greet | wish {person: them} a good morning", "say(Good morning.)"),
        ("switch_on | turn on {thing: the blue light}", "light(blue)"),
        ("tidy | clear up {thing: any rubbish that you come across}", "clear_rubbish()"),
        ("bring | 把{thing: 三号积木}送到{place: 我床上}", "carry(block 3, Q)"),
        ("turn_around | one complete spin", "move_left(360 deg)"),
        ("turn_around | 转个圈", "move_left(360 deg)"),
        ("turn_around | right about", "move_left(180 deg)"),
        ("turn_left | {amount: a little} to the left", "move_left(30 deg)"),
        ("forward | on {amount: 1 m} {manner: at a crawl}", "move_forward(1 m, 0.1 m/s)"),
        ("bring | {thing: blocks 1 and 2} to {place: the hall}", "carry(block 1, E); carry(block 2, E)"),
        ("bring | {thing: 方块1和2}搬到{place: 走廊}", "carry(block 1, E); carry(block 2, E)"),
        ("pick_up put | you take {1.thing: blue cup} and put {2.thing: him} on {2.place: desk}",
         "pick_object(blue cup); place_object(desk)"),
        ("put bring put | put {1.thing: the ball} on {1.place: the desk}, get {2.thing: the bottle}, put {3.thing: it} "
         "{3.place: there} too",
         "pick_object(ball); place_object(desk); pick_object(bottle); place_object(desk)"),
        ("pick_up pick_up | 拿{1.thing: 瓶子}，拿完再拿{2.thing: 蓝杯子}",
         "carry(bottle, zero); carry(blue cup, zero)"),
        ("bring | bring {thing: the ball} back {place: where it was}, {source: the desk}",
         "carry(ball, N)"),
        ("put bring | put {1.thing: the ball} on {1.place: the desk} and {2.thing: the bottle} {2.place: next to it}",
         "pick_object(ball); place_object(desk); carry(bottle, N)"),
        ("put | {thing: the ball} on {place: the floor of the study}", "carry(ball, D)"),
        ("throw_away | {thing: everything that's lying about} in {source: the study}", "clean_room(study)"),
        ("tidy | get {thing: the rubbish} off {source: the floor}", "clean_room()"),
        ("find | is there {thing: any rubbish} in {place: the hall}", "scan_room(hall)"),
        ("look | say what you see {place: from where you are standing}", "seewhat()"),
        ("remember go go_back | remember this spot, go to {2.place: the desk}, come back to {3.place: it}",
         "get_current_pose(); navigation(N); navigation(zero)"),
        ("remember | save {place: this spot} as {text: plant corner}", "remember_place(plant corner)"),
        ("remember | this is my friend, {text: her name is julia}, remember her", "learn_name(Julia)"),
        ("ask report | ask {1.person: Nina} {1.text: if shes hungry} and report back",
         "meet(Nina); ask_person(Nina, Are you hungry?); report_answer()"),
        ("find report | track down {1.thing: the ball} and tell me {2.topic: where it's got to}", "locate(ball)"),
        ("tell | 喊{person: 厨房里的人}{text: 都来吃西瓜}", "tell_everyone(来吃西瓜, person, kitchen)"),
        ("tell | tell {person: my husband Walter} {text: it is time}", "meet(Walter); tell(Walter, it is time)"),
        ("greet | welcome {person: the guest} at {place: the exit}", "find_person(person, exit); say(Welcome.)"),
    ],
)  # fmt: skip
def test_acts_become_calls_of_skills(flat: Entities, line: str, calls: str) -> None:
    assert done(flat, line) == calls


def test_what_is_held_is_not_picked_up_again(flat: Entities) -> None:
    assert done(flat, "put | put {thing: it} on {place: the desk}", "red box") == "place_object(desk)"
    assert done(flat, "bring | bring {thing: the box} to {person: me}", "red box") == "navigation(zero); putdown()"
    into = "bring put | take {1.thing: it} into {1.place: the study} and leave {2.thing: it} {2.place: there}"
    assert done(flat, into, "red box") == "navigation(D); putdown()"
    assert done(flat, "throw_away | straight into {source: the bin}", "red box") == "place_in_bin()"


@pytest.mark.parametrize(
    ("line", "question"),
    [("forward | go on", "how_far"), ("bring | bring {person: me} something nice", "which_thing"),
     ("put | put {thing: it} on {place: the desk}", "which_thing"), ("wait | wait", "how_long"),
     ("say | say something", "what")],
)  # fmt: skip
def test_what_was_not_said_is_asked_for(flat: Entities, line: str, question: str) -> None:
    with pytest.raises(Open) as gap:
        done(flat, line)
    assert gap.value.question == question


@pytest.mark.parametrize(
    ("line", "what"),
    [("open | open {thing: the door}", "act"),
     ("forward until seen end | on until you see {2.thing: the ball}", "until"),
     ("pick_up | take {thing: everything} but {except: the ball}", "role"),
     ("follow until is end | follow {1.person: me} until {2.thing: the lamp} is {2.state: on}", "until"),
     ("repeat beep end | {0.times: many times} beep", "times")],
)  # fmt: skip
def test_what_no_skill_does_is_told_and_nothing_of_it_is_left_out(flat: Entities, line: str, what: str) -> None:
    with pytest.raises(Unable) as why:
        done(flat, line)
    assert why.value.what == what


@pytest.mark.parametrize(
    ("line", "empty", "ball"),
    [
        ("if is then beep end | if {1.person: you} are {1.state: holding something} beep", False, True),
        ("if event then beep end | if {1.topic: you're carrying something} beep", False, True),
        ("if is then beep end | if {1.thing: your hand} is {1.state: empty} beep", True, False),
        (
            "if is_not then beep end | if {1.person: you} aren't {1.state: holding} {1.thing: the ball} beep",
            True,
            False,
        ),
        ("if is then beep end | {1.person: 你}要是{1.state: 拿着东西}就响一声", False, True),
        ("if is then beep end | if {1.thing: the box} is {1.state: empty} beep", None, None),
        ("if event then beep end | if {1.topic: it rains} beep", None, None),
    ],
)
def test_what_it_holds_is_known_without_a_look(
    flat: Entities, line: str, empty: bool | None, ball: bool | None
) -> None:
    example = read(line)
    [node] = meaning_of(example.text, example.steps).wanted()
    assert isinstance(node, If)
    assert [of_itself(Doing(flat, held), node.condition) for held in ("", "ball")] == [empty, ball]


@pytest.mark.parametrize("words", ["the box you're holding", "the box in your hand", "手里的盒子", "你拿着的那个盒子"])
def test_what_is_said_to_be_held_is_what_is_held(flat: Entities, words: str) -> None:
    line = f"put | put {{thing: {words}}} on {{place: the desk}}"
    assert done(flat, line, holding="green box") == "place_object(desk)"


def test_what_is_held_has_other_names(flat: Entities) -> None:
    assert done(flat, "throw_away | bin {thing: what you've got in your hand}", "bottle") == "place_in_bin()"
    assert done(flat, "put | {thing: 你手里拿着的东西}放{place: 书桌上}", "ball") == "place_object(desk)"


def test_a_place_that_is_not_here_is_named_as_it_was_said(flat: Entities) -> None:
    with pytest.raises(NowhereKnown) as unknown:
        done(flat, "go | off to {place: the old garage}")
    assert unknown.value.words == "old garage"


def test_a_million_times_are_cut_short(flat: Entities) -> None:
    assert done(flat, "repeat beep end | {0.times: 1000000 times} beep").count("beep") < 100


@pytest.mark.parametrize(
    ("line", "thing", "there", "look"),
    [
        ("if seen then beep end | if there is {1.thing: a ball} in {1.place: the hall} beep", "ball", True,
         "navigation(E); seewhat()"),
        ("if is then beep end | if {1.thing: the ball} is {1.state: in the hall} beep", "ball", True,
         "navigation(E); seewhat()"),
        ("if is_not then beep end | if {1.thing: the ball} isn't {1.state: there} beep", "ball", False, "seewhat()"),
        ("if is then beep end | if {1.thing: the ball} is {1.state: gone} from {1.place: the hall} beep", "ball", False,
         "navigation(E); seewhat()"),
        ("if is then beep end | if {1.thing: the desk} is {1.state: empty} beep", "thing", False,
         "navigation(N); seewhat()"),
        ("if is_not then beep end | 如果{1.place: 书桌}不是{1.state: 空}的就叫一声", "thing", True,
         "navigation(N); seewhat()"),
    ],
)  # fmt: skip
def test_a_state_of_being_there_is_looked_for(flat: Entities, line: str, thing: str, there: bool, look: str) -> None:
    found = sought(Doing(flat), condition_of(line))
    assert (found.thing, found.there) == (thing, there)
    assert "; ".join(f"{call.name}({', '.join(map(told, call.positional))})" for call in found.look) == look


@pytest.mark.parametrize(
    ("words", "few", "many"),
    [
        ("two boxes", False, True),
        ("at least two boxes", False, True),
        ("more than one box", False, True),
        ("fewer than three boxes", True, False),
        ("two or more boxes", False, True),
        ("至少两个盒子", False, True),
    ],
)
def test_things_are_counted_by_their_names(flat: Entities, words: str, few: bool, many: bool) -> None:
    found = sought(Doing(flat), condition_of(f"if seen then beep end | if you see {{1.thing: {words}}} beep"))
    assert [found.holds(seen.__contains__) for seen in (["red box"], ["red box", "blue box", "green box"])] == [
        few,
        many,
    ]


@pytest.mark.parametrize(
    ("kind", "none", "one", "both"), [("seen", False, False, True), ("unseen", True, False, False)]
)
def test_several_things_are_all_there_or_none_is(flat: Entities, kind: str, none: bool, one: bool, both: bool) -> None:
    line = (
        f"if {kind} then beep end | if {{1.thing: the ball}} and {{1.thing: the bottle}} are, or are not, there: beep"
    )
    found = sought(Doing(flat), condition_of(line))
    sights: list[list[str]] = [[], ["ball"], ["ball", "bottle"]]
    assert [found.holds(seen.__contains__) for seen in sights] == [none, one, both]


def test_what_has_no_names_of_its_own_is_not_counted(flat: Entities) -> None:
    with pytest.raises(Unable, match="count"):
        sought(Doing(flat), condition_of("if seen then beep end | if you see {1.thing: two spoons} beep"))


def condition_of(line: str) -> Condition:
    example = read(line)
    node = meaning_of(example.text, example.steps).wanted()[0]
    assert isinstance(node, If)
    return node.condition


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("she is late", "You are late"),
        ("to take her medicine", "Please take your medicine"),
        ("he has to feed his cat", "You have to feed your cat"),
        ("she is waiting for him", "she is waiting for him"),
        ("dinner is ready", "dinner is ready"),
        ("她迟到了", "她迟到了"),
    ],
)
def test_what_is_told_is_said_to_its_hearer(text: str, said: str) -> None:
    assert message(text) == said
