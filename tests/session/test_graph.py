"""sayso as a part of a ROS graph: what peers ask for is done as if it had been said here, and told to them."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine import events
from engine.commands import MAX_TEXT, Interrupt, Say
from engine.graph.goals import WAITING
from engine.graph.own import LASTS_S
from engine.parts.graph import PATIENCE_S, SENTENCES, WATCH_S
from tests.session.graph import Hand, Joined, in_graph

COMMAND = "/speech_to_text/command"
DRIVE = json.dumps({"goal": "drive", "actions": ["move_forward(1 m)", "move_left(90 deg)"]})


# Sentences


def test_a_sentence_of_a_peer_drives_the_robot_and_all_of_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.hand.say("move forward 1 m")
        turn = await both.hand.turn()
        assert (turn["outcome"], turn["success"], turn["request"]) == ("done", True, "move forward 1 m")
        assert both.talk.robot.state().pose.x == pytest.approx(1.0, abs=0.05)
        (plan,) = map(json.loads, both.hand.on("/plan"))
        assert (plan["goal"], plan["actions"]) == ("move forward 1 m", ["move_forward(1 m)"])
        (intent,) = map(json.loads, both.hand.on("/llm/intent"))
        assert intent["action"] == "move"
        assert both.hand.on("/voice_feedback") == ["Driving 1 metre forward.", "Moved 1.00 m forward."]
        action, end = map(json.loads, both.hand.on("/outcome"))
        assert (action["kind"], action["call"], action["outcome"]) == ("action", "move_forward(1 m)", "ok")
        assert end["actions"] == [{key: value for key, value in action.items() if key not in ("kind", "turn")}]
        assert both.hand.on(COMMAND) == [], "only what was heard here is told there"

    in_graph(test, monkeypatch)


def test_what_is_not_understood_or_refused_is_told_as_an_intent_too(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.hand.say("run over the cat")
        assert (await both.hand.turn())["outcome"] == "refused"
        both.hand.say("take me to the garage")
        assert (await both.hand.turn(2))["outcome"] == "failed"
        intents = [json.loads(data)["action"] for data in both.hand.on("/llm/intent")]
        assert intents == ["refuse", "error"]
        assert not both.moved

    in_graph(test, monkeypatch)


def test_what_was_heard_here_is_told_there_and_not_done_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        await both.talk.wake_and_say("nod")
        await both.hand.turn()
        await both.talk.pass_time(2 * LASTS_S)
        assert both.hand.on(COMMAND) == ["nod"]
        assert len(both.talk.results) == 1
        both.hand.say("nod")
        assert (await both.hand.turn(2))["outcome"] == "done", "a peer says the same"

    in_graph(test, monkeypatch)


def test_a_peer_that_says_what_was_heard_here_is_heard_at_the_second_time_at_the_latest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def test(both: Joined) -> None:
        await both.talk.wake_and_say("nod")
        await both.hand.turn()
        both.hand.say("nod")  # nobody can tell it from ours, which does not come back in this graph
        both.hand.say("nod")
        await both.hand.turn(2)
        await both.talk.pass_time(2 * LASTS_S)
        assert len(both.talk.results) == 2

    in_graph(test, monkeypatch, hand=lambda: Hand(echoes=False))


def test_a_stop_that_may_be_our_own_stops_what_has_begun_since(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        await both.talk.wake_and_say("stop")
        await both.hand.turn()
        both.talk.send(Say("move forward 5 m"))
        await both.moving()
        both.hand.say("stop")
        assert (await both.hand.turn(2))["outcome"] == "interrupted"

    in_graph(test, monkeypatch, hand=lambda: Hand(echoes=False))


def test_of_a_flood_of_sentences_a_few_wait_and_the_others_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        for number in range(1000):
            both.hand.say(f"move forward {number % 5 + 1} cm")
        await both.hand.turn(SENTENCES)
        await both.talk.pass_time(2.0)
        assert len(both.talk.results) == SENTENCES
        assert both.logs == [
            f"A message on {COMMAND} was refused: {SENTENCES} sentences wait already.",
            f"{1000 - SENTENCES - 1} more messages from the ROS graph were refused.",
        ]
        both.hand.say("nod")
        assert (await both.hand.turn(SENTENCES + 1))["request"] == "nod", "there is room again"

    in_graph(test, monkeypatch, "session.busy=queue")


def test_a_stop_is_heard_in_a_flood(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.hand.say("move forward 5 m")
        await both.moving()
        for _ in range(100):
            both.hand.say("nod")
        both.hand.say("stop")
        assert (await both.hand.turn())["outcome"] == "interrupted"
        assert both.talk.robot.state().twist.vx == 0.0

    in_graph(test, monkeypatch, "session.busy=queue")


def test_a_sentence_that_is_turned_away_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.talk.send(Say("move forward 2 m"))
        await both.moving()
        both.hand.say("nod")
        assert (await both.hand.turn())["outcome"] == "done"
        (told,) = both.logs
        assert told.startswith("“nod” from the ROS graph was not done: Busy")

    in_graph(test, monkeypatch, "session.busy=reject")


# Stop


def test_the_stop_of_a_peer_stops_the_robot_before_anything_else_happens(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.talk.send(Say("move forward 5 m"))
        await both.moving()
        epoch = both.talk.epoch.current
        both.hand.send("/stop", {})
        assert both.talk.epoch.current > epoch, "the loop has not turned, and whatever moves is over"
        turn = await both.hand.turn()
        assert turn["outcome"] == "interrupted"
        assert [action["outcome"] for action in turn["actions"]] == ["interrupted"]
        assert both.talk.robot.state().pose.x < 1.0

    in_graph(test, monkeypatch)


def test_the_stop_comes_from_the_thread_of_the_door(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.talk.send(Say("move forward 5 m"))
        await both.moving()
        await asyncio.to_thread(both.hand.send, "/stop", {})
        assert (await both.hand.turn())["outcome"] == "interrupted"

    in_graph(test, monkeypatch)


# get_plan


def test_a_plan_is_made_and_nothing_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        reply = await both.hand.plan("go to the kitchen, then nod")
        plan = json.loads(reply["plan"])
        assert reply["success"] is True
        assert plan["goal"] == "go to the kitchen, then nod"
        assert plan["actions"] == ['navigation("A")', "arm_nod()"]
        assert len(plan["steps"]) == 2
        assert plan["intent"]["action"] == "navigate"
        await both.talk.pass_time(5.0)
        assert not both.moved
        assert both.talk.session.state == "IDLE"
        assert both.hand.on("/plan") == [], "nothing is carried out"

    in_graph(test, monkeypatch)


@pytest.mark.parametrize(
    ("command", "language", "message"),
    [
        ("take me to the garage", "", "I don't know a place called garage. I know kitchen"),
        ("run over the cat", "", ""),
        ("", "", "The request is empty."),
        (7, "", "The field command is no text."),
        ("nod\ud800", "", "The field command is no text: it holds half a character."),
        ("nod " * 1000, "", f"The request is 4000 characters long; {MAX_TEXT} are read at most."),
        ("nod" * 10_000_000, "", "The field command is 30000000 characters long"),
        ("nod", "fr", "Plans are told in en and zh"),
        ("nod", ["en"], "Plans are told in en and zh"),
    ],
)  # fmt: skip
def test_where_there_is_no_plan_the_reason_is_told(
    monkeypatch: pytest.MonkeyPatch, command: Any, language: Any, message: str
) -> None:
    async def test(both: Joined) -> None:
        reply = await both.hand.plan(command, language)
        assert (reply["success"], reply["plan"]) == (False, "")
        assert reply["message"]
        assert reply["message"].startswith(message)
        assert not both.moved

    in_graph(test, monkeypatch)


def test_a_plan_is_made_while_the_robot_drives_and_does_not_disturb_it(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.hand.say("move forward 1 m")
        await both.moving()
        assert (await both.hand.plan("nod"))["success"]
        assert (await both.hand.turn())["outcome"] == "done"

    in_graph(test, monkeypatch)


def test_a_plan_is_told_in_the_language_that_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        assert (await both.hand.plan("nod", "zh"))["message"] == "点头。"
        assert (await both.hand.plan("去火星", ""))["message"].startswith("我")

    in_graph(test, monkeypatch)


def test_more_requests_for_plans_than_can_wait_are_refused_with_a_message(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        replies = await asyncio.gather(*(both.hand.plan("nod") for _ in range(20)))
        assert sum(reply["success"] for reply in replies) == 8
        assert {reply["message"] for reply in replies if not reply["success"]} == {"8 plans are waited for already."}

    in_graph(test, monkeypatch)


def test_a_planner_that_fails_or_takes_too_long_is_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.talk.planner.fault = ZeroDivisionError("injected")  # type: ignore[assignment]
        assert "ZeroDivisionError" in (await both.hand.plan("nod"))["message"]
        both.talk.planner.fault, both.talk.planner.plan_s = None, 100.0
        assert (await both.hand.plan("nod"))["message"] == "There was no plan within 20 s."

    in_graph(test, monkeypatch, "session.turn_limit_s=20")


def test_a_plan_by_topics(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.hand.write("/get_plan/request", {"id": 7, "command": "nod"})
        response = await both.hand.until("/get_plan/response")
        assert (response["id"], response["success"], response["plan"]["actions"]) == (7, True, ["arm_nod()"])
        both.hand.write("/get_plan/request", {"id": 8})
        response = await both.hand.until("/get_plan/response", lambda data: data["id"] == 8)
        assert (response["success"], response["plan"]) == (False, None)
        assert not both.moved

    in_graph(test, monkeypatch)


# execute_plan


def test_a_plan_is_carried_out_step_by_step_with_feedback(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        plan = (await both.hand.plan("move forward 50 cm, then nod"))["plan"]
        client = both.hand.execute(plan)
        how, result = await client.result()
        assert (how, result["success"], result["outcome"]) == ("succeeded", True, "done")
        assert [told["message"] for told in client.told] == [
            "executing step 1 of 2: move_forward(0.5 m)",
            "executing step 2 of 2: arm_nod()",
        ]
        assert [(told["step"], told["steps"]) for told in client.told] == [(1, 2), (2, 2)]
        results = json.loads(result["results"])
        assert [(one["name"], one["outcome"]) for one in results] == [("move_forward", "ok"), ("arm_nod", "ok")]
        await both.talk.pass_time(5.0)
        assert len(client.ended) == 1

    in_graph(test, monkeypatch)


@pytest.mark.parametrize(
    "plan",
    [
        "move_forward(1 m); move_left(90 deg)",
        '["move_forward(1 m)", "move_left(90 deg)"]',
        '{"steps": ["move_forward(1 m)", "move_left(90)"]}',
        '[{"name": "move_forward", "args": {"distance": 1}}, {"name": "move_left", "args": {"angle": 90}}]',
        "drive 1 m forward, then turn left by 90 degrees",
    ],
)
def test_a_plan_may_be_written_in_several_ways(monkeypatch: pytest.MonkeyPatch, plan: str) -> None:
    async def test(both: Joined) -> None:
        how, result = await both.hand.execute(plan).result()
        assert how == "succeeded"
        names = [(one["name"], one["args"]) for one in json.loads(result["results"])]
        assert [name for name, _ in names] == ["move_forward", "move_left"]
        assert names[0][1]["distance"] == 1.0
        assert names[1][1]["angle"] == 90.0

    in_graph(test, monkeypatch)


@pytest.mark.parametrize(
    ("plan", "message"),
    [
        ('["move_forward(1 m)", "fly_to(moon)"]', "Step 2: There is no skill 'fly_to'."),
        ("fly_to(moon)", "Step 1: There is no skill 'fly_to'."),
        ('["move_forward(200 m)"]', "Step 1: move_forward: distance of 200 m is not allowed: -50 to 50 m."),
        ('["move_forward"]', "Step 1: move_forward(distance m, speed m/s = 0.3): distance is missing."),
        ('["drive to the kitchen"]', "Step 1: Expected ',', '&' or the end"),
        ('["nod()", ""]', "Step 2 is empty."),
        ('["navigation(garage)"]', "Step 1: I don't know a place called 'garage'."),
        ('{"actions": [{"name": "say", "args": {"text": true}}]}', "Step 1: Its argument text is neither"),
        ('{"actions": [{"name": "say", "args": 7}]}', "Step 1: Its args are no object."),
        ('{"actions": [7]}', "Step 1: It is neither a call nor an object with a name."),
        ('{"actions": "move_forward(1 m)"}', "A plan is a list of calls"),
        ('{"goal": "none"}', "A plan is a list of calls"),
        ("[]", "The plan has no steps."),
        ('{"actions": []}', "The plan has no steps."),
        ("{", "The plan is no JSON"),
        ("[" * 10_000, "The plan is no JSON"),
        ('["move_forward(1 m)", "stop()"]', "Words in this plan would be taken for a stop."),
        ("", "The request is empty."),
        (None, "A plan is a list of calls"),
        (b"nod", "A plan is a list of calls"),
        ("\ud800", "The field plan is no text: it holds half a character."),
        ("nod " * 3_000_000, "The field plan is 12000000 characters long"),
        (json.dumps(["move_forward(1 cm)"] * 51), ""),
        (json.dumps(["say(" + "x" * 3000 + ")"]), "The request is 3007 characters long"),
    ],
)  # fmt: skip
def test_a_plan_with_something_wrong_in_it_is_refused_with_the_reason_and_nothing_moves(
    monkeypatch: pytest.MonkeyPatch, plan: Any, message: str
) -> None:
    async def test(both: Joined) -> None:
        client = both.hand.execute(plan)
        how, result = await client.result()
        assert how == "aborted"
        assert result["success"] is False
        assert result["outcome"] == ("refused" if "not allowed" in message else "failed")
        assert result["message"].startswith(message)
        assert json.loads(result["results"]) == []
        await both.talk.pass_time(5.0)
        assert not both.moved
        assert len(client.ended) == 1

    in_graph(test, monkeypatch)


def test_a_plan_ends_at_the_first_step_that_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        client = both.hand.execute('["locate(dragon)", "arm_nod()"]')
        how, result = await client.result()
        assert (how, result["success"]) == ("aborted", False)
        assert [one["name"] for one in json.loads(result["results"])] != ["locate", "arm_nod"]

    in_graph(test, monkeypatch)


def test_what_a_sentence_leaves_open_is_asked_and_ends_the_goal(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        how, result = await both.hand.execute("bring me the cup to the").result()
        assert (how, result["outcome"]) == ("aborted", "clarify")
        assert result["message"] == (await both.hand.turn())["message"]

    in_graph(test, monkeypatch)


def test_a_goal_that_is_cancelled_half_way_stops_the_robot_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        client = both.hand.execute(DRIVE)
        await both.moving()
        epoch = both.talk.epoch.current
        both.hand.works["/execute_plan"].cancel(client)
        assert both.talk.epoch.current > epoch
        how, result = await client.result()
        assert (how, result["success"], result["outcome"]) == ("canceled", False, "interrupted")
        assert [one["outcome"] for one in json.loads(result["results"])] == ["interrupted"]
        turn = await both.hand.turn()
        assert turn["never_started"] == ["move_left(90 deg)"]
        both.hand.works["/execute_plan"].cancel(client)
        both.talk.send(Say("nod"))
        assert (await both.hand.turn(2))["outcome"] == "done", "one that has ended cancels nothing"

    in_graph(test, monkeypatch)


def test_a_goal_that_waits_is_withdrawn_and_what_runs_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.talk.send(Say("move forward 1 m"))
        await both.moving()
        first, second = both.hand.execute(DRIVE), both.hand.execute('["arm_nod()"]')
        await both.talk.pass_time(0.1)
        both.hand.works["/execute_plan"].cancel(first)
        how, result = await first.result()
        assert (how, result["outcome"]) == ("canceled", "interrupted")
        assert result["message"] == "Withdrawn before it started."
        assert (await both.hand.turn())["outcome"] == "done", "nobody has interrupted it"
        assert (await second.result())[0] == "succeeded"
        assert not first.told

    in_graph(test, monkeypatch, "session.busy=queue")


@pytest.mark.parametrize("busy", ["queue", "interrupt"])
def test_a_goal_that_is_cancelled_before_the_session_has_seen_it_never_moves(
    monkeypatch: pytest.MonkeyPatch, busy: str
) -> None:
    async def test(both: Joined) -> None:
        client = both.hand.execute(DRIVE)
        both.hand.works["/execute_plan"].cancel(client)
        how, result = await client.result()
        assert (how, result["outcome"]) == ("canceled", "interrupted")
        await both.talk.pass_time(5.0)
        assert not both.moved

    in_graph(test, monkeypatch, f"session.busy={busy}")


@pytest.mark.parametrize(
    ("busy", "ends"),
    [
        ("interrupt", [("aborted", "interrupted"), ("succeeded", "done")]),
        ("queue", [("succeeded", "done"), ("succeeded", "done")]),
        ("reject", [("succeeded", "done"), ("aborted", "refused")]),
    ],
)
def test_goals_are_requests_like_any_other_where_one_runs_already(
    monkeypatch: pytest.MonkeyPatch, busy: str, ends: list[tuple[str, str]]
) -> None:
    async def test(both: Joined) -> None:
        first = both.hand.execute(DRIVE)
        await both.moving()
        second = both.hand.execute('["arm_nod()"]')
        ended = [await one.result() for one in (first, second)]
        assert [(how, result["outcome"]) for how, result in ended] == ends
        await both.talk.pass_time(5.0)
        assert [len(one.ended) for one in (first, second)] == [1, 1]

    in_graph(test, monkeypatch, f"session.busy={busy}")


def test_whoever_interrupts_ends_goals_that_run_and_that_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        clients = [both.hand.execute(DRIVE) for _ in range(3)]
        await both.moving()
        both.talk.send(Interrupt())
        ended = [await one.result() for one in clients]
        assert [(how, result["outcome"]) for how, result in ended] == [("aborted", "interrupted")] * 3

    in_graph(test, monkeypatch, "session.busy=queue")


def test_more_goals_than_can_wait_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        clients = [both.hand.execute('["arm_nod()"]') for _ in range(100)]
        ended = [await one.result() for one in clients]
        outcomes = [result["outcome"] for _, result in ended]
        assert outcomes == ["done"] * WAITING + ["refused"] * (100 - WAITING)
        await both.talk.pass_time(2.0)
        assert len(both.logs) == 2, "one, and how many more"

    in_graph(test, monkeypatch, "session.busy=queue")


def test_a_goal_that_only_stops_or_ends_the_task_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.hand.say("move forward 5 m")
        await both.moving()
        assert (await both.hand.execute("stop()").result())[1]["outcome"] == "done"
        assert (await both.hand.turn())["outcome"] == "interrupted"
        assert (await both.hand.execute("end the current task").result())[1]["outcome"] == "done"

    in_graph(test, monkeypatch)


def test_goals_by_topics(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        plan = ["move_forward(1 m)", "arm_nod()"]
        both.hand.write("/execute_plan/goal", {"id": "a", "plan": {"actions": plan}})
        both.hand.write("/execute_plan/goal", {"id": "a", "plan": plan})
        both.hand.write("/execute_plan/goal", {"plan": plan})
        twice, nameless = map(json.loads, both.hand.on("/execute_plan/result"))
        assert (twice["id"], twice["status"]) == ("a", "rejected")
        assert (nameless["id"], nameless["status"]) == (None, "aborted")
        result = await both.hand.until("/execute_plan/result", lambda data: data["status"] == "succeeded")
        assert (result["id"], result["outcome"], len(result["results"])) == ("a", "done", 2)
        feedback = [json.loads(data) for data in both.hand.on("/execute_plan/feedback")]
        assert [(told["id"], told["step"], told["steps"]) for told in feedback] == [("a", 1, 2), ("a", 2, 2)]
        both.hand.write("/execute_plan/goal", {"id": "a", "plan": "move_forward(5 m)"})
        await both.talk.pass_time(1.0)
        both.hand.write("/execute_plan/cancel", {"id": "a"})
        result = await both.hand.until("/execute_plan/result", lambda data: data["status"] == "canceled")
        assert (result["id"], result["outcome"]) == ("a", "interrupted")
        both.hand.write("/execute_plan/cancel", {"id": "a"})
        await both.talk.pass_time(0.1)
        assert both.logs == ["A message on /execute_plan/cancel was refused: There is no goal with this id to cancel."]

    in_graph(test, monkeypatch)


# Sound


def test_sound_of_either_type_is_heard(monkeypatch: pytest.MonkeyPatch) -> None:
    samples = np.arange(-3, 3, dtype="<i2")

    async def integers(both: Joined) -> None:
        assert both.hand.takes["/audio_input/raw"][0] == "std_msgs/msg/Int16MultiArray"
        both.hand.say(samples.tolist(), "/audio_input/raw")
        both.hand.say(samples, "/audio_input/raw")
        await both.talk.pass_time(0.1)
        assert both.heard == [samples.tobytes()] * 2

    async def octets(both: Joined) -> None:
        assert both.hand.takes["/audio_input/raw"][0] == "std_msgs/msg/UInt8MultiArray"
        both.hand.say(samples.tobytes(), "/audio_input/raw")
        both.hand.say(list(samples.tobytes()), "/audio_input/raw")
        await both.talk.pass_time(0.1)
        assert both.heard == [samples.tobytes()] * 2

    in_graph(integers, monkeypatch)
    in_graph(octets, monkeypatch, "ros.sound=uint8")


# The graph itself


def test_names_lie_in_the_namespace_and_some_are_switched_off(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        assert set(both.hand.takes) == {
            "/robot1/speech_to_text/command", "/halt", "/robot1/get_plan/request", "/robot1/execute_plan/goal",
            "/robot1/execute_plan/cancel",
        }  # fmt: skip
        assert set(both.hand.answers) == {"/robot1/get_plan"}
        assert set(both.hand.works) == {"/robot1/execute_plan"}
        both.hand.say("nod", "/robot1/speech_to_text/command")
        await both.hand.until("/robot1/plan")
        await both.talk.result()
        assert not both.hand.on("/robot1/outcome")

    names = ("ros.names.audio=null", "ros.names.stop=/halt", "ros.names.outcome=null")
    in_graph(test, monkeypatch, "ros.namespace=robot1", *names)


def test_a_door_that_goes_and_comes_back_is_told_once_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        both.hand.trouble = "the bridge is gone"
        await both.talk.pass_time(10.0)
        both.hand.trouble = "the bridge is still gone"
        await both.talk.pass_time(10.0)
        both.hand.trouble = ""
        await both.talk.pass_time(10.0)
        told = [(status.state, status.detail) for status in both.statuses]
        assert told == [
            ("ready", "ws://peer:9090"),
            ("missing", "No way to the ROS graph: the bridge is gone."),
            ("ready", "ws://peer:9090"),
        ]

    in_graph(test, monkeypatch)


def test_a_door_that_never_opens_is_told_after_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(both: Joined) -> None:
        await both.talk.pass_time(PATIENCE_S - 2 * WATCH_S)
        assert not both.statuses
        await both.talk.pass_time(PATIENCE_S)
        assert [status.state for status in both.statuses] == ["missing"]
        both.talk.send(Say("nod"))
        assert (await both.talk.result()).outcome == "done", "everything else works"

    def shut() -> Hand:
        hand = Hand()
        hand.trouble = "nobody answers"
        return hand

    in_graph(test, monkeypatch, hand=shut)


def test_a_door_that_fails_to_publish_ends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    class Broken(Hand):
        def publish(self, *args: Any, **kwargs: Any) -> None:
            raise OSError("injected")

    async def test(both: Joined) -> None:
        both.hand.say("nod")
        assert (await both.talk.result()).outcome == "done"
        client = both.hand.execute('["arm_nod()"]')
        assert (await client.result())[0] == "succeeded"
        assert "has failed: OSError('injected')." in both.logs[0]

    in_graph(test, monkeypatch, hand=Broken)


JUNK = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=8,
)
KEYS = st.sampled_from(["id", "command", "plan", "language", "actions", "steps", "name", "args", "data"])
OBJECTS = st.dictionaries(KEYS, JUNK | st.dictionaries(KEYS, JUNK, max_size=3), max_size=4)
MESSAGES = JUNK.map(lambda data: {"data": data}) | OBJECTS.map(lambda found: {"data": json.dumps(found, default=repr)})


@settings(max_examples=30, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.lists(st.tuples(st.integers(0, 9), MESSAGES | OBJECTS), min_size=1, max_size=40))
def test_whatever_peers_send_nothing_is_raised_and_everything_ends(sent: list[tuple[int, dict[str, Any]]]) -> None:
    async def test(both: Joined) -> None:
        takes = list(both.hand.takes.values())
        clients, replies, asked = [], [], 0
        for which, message in sent:
            if which < len(takes):
                takes[which][1](message)
            elif which == 8:
                clients.append(both.hand.execute(message.get("plan")))
            else:
                asked += 1
                both.hand.answers["/get_plan"](message, replies.append)
        await both.talk.pass_time(200.0)
        assert len(replies) == asked
        assert [len(client.ended) for client in clients] == [1] * len(clients)
        both.talk.send(Say("nod"))
        await both.talk.until(events.ActionFinished, lambda done: done.name == "arm_nod")

    with pytest.MonkeyPatch.context() as patch:
        in_graph(test, patch)
