"""Requests that wait can be dropped and moved; whatever becomes of one, it ends exactly once, and that is told."""

from __future__ import annotations

import pytest

from engine import events
from engine.commands import Command, Drop, EndTask, Halted, Interrupt, Move, Quit, Release, Say, Snapshot, Wake
from tests.session.conversation import Conversation, SlowVoice, converse

THREE = ("beep", "turn left 90 degrees", "raise your arm")


async def three_waiting(talk: Conversation) -> tuple[events.WaitingRequest, ...]:
    """A long drive with three requests behind it; those, as they are told."""
    talk.send(Say("go forward 3 metres", "all", then=THREE))
    await talk.until(events.ActionStarted)
    return talk.bodies(events.RequestsWaiting)[-1].requests


def ends(talk: Conversation) -> list[tuple[str, str, events.Scope | None]]:
    return [(body.text, body.outcome, body.by) for body in talk.bodies(events.RequestEnded)]


def names(talk: Conversation) -> list[str]:
    return [body.name for body in talk.bodies(events.ActionStarted)]


async def answered(talk: Conversation, command: Drop | Move | Snapshot) -> events.Ack:
    talk.send(command)
    return await talk.until(events.Ack, lambda body: body.id == command.id)


def test_the_waiting_list_is_told_with_ids_that_a_snapshot_has_as_well() -> None:
    async def test(talk: Conversation) -> None:
        waiting = await three_waiting(talk)
        assert [(one.text, one.sent_as) for one in waiting] == [(text, "all") for text in THREE]
        assert len({one.request for one in waiting}) == 3
        snapshot = (await answered(talk, Snapshot("now"))).snapshot
        assert snapshot is not None
        assert [one["request"] for one in snapshot["requests"]] == [one.request for one in waiting]

    converse(test)


def test_a_sender_may_give_the_ids_and_gives_none_twice() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 3 metres", "all", then=THREE, requests=("a", "b", "", "b")))
        await talk.until(events.ActionStarted)
        first, second, third = (one.request for one in talk.bodies(events.RequestsWaiting)[-1].requests)
        assert first == "b"
        assert len({first, second, third, "a", ""}) == 5
        talk.send(Say("nod", wait=True, requests=("a", "too many")))
        assert (await answered(talk, Drop("b", "drop"))).ok
        await talk.result(4)
        ended = [body.request for body in talk.bodies(events.RequestEnded)]
        assert ended[:2] == ["b", "a"]
        assert len(set(ended)) == len(ended) == 5

    converse(test)


def test_what_stands_behind_a_stop_keeps_the_ids_that_its_sender_gave() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("beep", then=("stop", "nod"), requests=("a", "b", "c")))
        await talk.result(2)
        ended = [(body.request, body.text, body.outcome) for body in talk.bodies(events.RequestEnded)]
        assert ended == [("a", "beep", "interrupted"), ("b", "stop", "done"), ("c", "nod", "done")]

    converse(test)


def test_one_that_is_dropped_never_begins_and_what_runs_goes_on() -> None:
    async def test(talk: Conversation) -> None:
        waiting, epoch = await three_waiting(talk), talk.epoch.current
        assert (await answered(talk, Drop(waiting[1].request, "drop"))).ok
        assert talk.epoch.current == epoch, "nothing is interrupted"
        assert talk.bodies(events.RequestsWaiting)[-1].texts == ("beep", "raise your arm")
        assert ends(talk) == [("turn left 90 degrees", "dropped", None)]
        await talk.result(3)
        assert names(talk) == ["move_forward", "beep", "arm_up"]
        assert sorted(text for text, *_ in ends(talk)) == sorted(("go forward 3 metres", *THREE))

    converse(test)


@pytest.mark.parametrize(
    ("which", "before", "order"),
    [(2, 0, (2, 0, 1)), (0, None, (1, 2, 0)), (0, 2, (1, 0, 2)), (1, 1, (0, 1, 2)), (2, None, (0, 1, 2))],
)
def test_one_that_is_moved_begins_at_its_new_place(which: int, before: int | None, order: tuple[int, ...]) -> None:
    async def test(talk: Conversation) -> None:
        waiting = await three_waiting(talk)
        there = None if before is None else waiting[before].request
        assert (await answered(talk, Move(waiting[which].request, there, "move"))).ok
        assert talk.bodies(events.RequestsWaiting)[-1].requests == tuple(waiting[at] for at in order)
        await talk.result(4)
        done = ("beep", "move_left", "arm_up")
        assert names(talk) == ["move_forward", *(done[at] for at in order)]

    converse(test)


@pytest.mark.parametrize("unknown", [Drop("nobody's", "it"), Move("nobody's", None, "it")])
def test_an_id_that_nothing_has_is_an_error_that_says_so(unknown: Drop | Move) -> None:
    async def test(talk: Conversation) -> None:
        waiting = await three_waiting(talk)
        ack = await answered(talk, unknown)
        assert (ack.ok, ack.message) == (
            False,
            'No request with the id "nobody\'s" waits: it has begun, or ended, or never was.',
        )
        ack = await answered(talk, Move(waiting[0].request, "nobody's", "there"))
        assert not ack.ok
        assert talk.bodies(events.RequestsWaiting)[-1].requests == waiting

    converse(test)


def test_one_that_has_begun_is_not_dropped_any_more() -> None:
    async def test(talk: Conversation) -> None:
        waiting = await three_waiting(talk)
        await talk.until(events.ActionStarted, lambda body: body.name == "beep")
        assert not (await answered(talk, Drop(waiting[0].request, "late"))).ok

    converse(test)


def test_a_session_that_is_to_end_after_them_does_so_behind_what_was_moved() -> None:
    async def test(talk: Conversation) -> None:
        waiting = await three_waiting(talk)
        talk.send(Quit(drain=True, id="quit"))
        assert (await answered(talk, Move(waiting[0].request, None, "move"))).ok
        await talk.until(events.Ack, lambda body: body.id == "quit")
        assert names(talk) == ["move_forward", "move_left", "arm_up", "beep"]

    converse(test)


def test_what_was_asked_for_behind_the_end_of_the_session_is_told_to_be_left() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 1 metre"))
        await talk.until(events.ActionStarted)
        talk.send(Quit(drain=True, id="quit"))
        talk.send(Say("beep", "late", wait=True))
        await talk.until(events.Ack, lambda body: body.id == "quit")
        assert names(talk) == ["move_forward"]
        assert ends(talk) == [("go forward 1 metre", "done", None), ("beep", "interrupted", "shutdown")]
        assert [body.ok for body in talk.bodies(events.Ack) if body.id == "late"] == [False]

    converse(test)


@pytest.mark.parametrize(
    ("command", "scope"),
    [
        (Interrupt(), "interrupt"), (EndTask(), "end_task"), (Wake("key"), "wake"), (Say("stop"), "stop"),
        (Say("nod"), "replaced"), (Halted("it tipped over"), "halted"), (Quit(), "shutdown"), (Release(), "release"),
    ],
)  # fmt: skip
def test_every_interruption_is_the_one_end_of_what_waited(command: Command, scope: events.Scope) -> None:
    async def test(talk: Conversation) -> None:
        waiting = await three_waiting(talk)
        if isinstance(command, Halted):
            talk.send(Halted(command.reason, talk.epoch.current))
        else:
            talk.send(command)
        await talk.pass_time(20)
        outcome = "replaced" if scope == "replaced" else "interrupted"
        ended = [body for body in talk.bodies(events.RequestEnded) if body.text in THREE]
        assert [(body.request, body.outcome, body.by) for body in ended] == [
            (one.request, outcome, scope) for one in waiting
        ]
        assert [event.turn for event in talk.seen if event.body in ended] == [None] * 3
        assert names(talk)[:1] == ["move_forward"]
        assert not {"beep", "move_left", "arm_up"} & set(names(talk))

    converse(test)


def test_a_request_that_is_replaced_while_it_is_planned_ends_as_replaced_with_its_turn() -> None:
    async def test(talk: Conversation) -> None:
        talk.planner.plan_s = 2.0
        talk.send(Say("go forward 3 metres"))
        await talk.until_state("PLANNING")
        talk.send(Say("beep"))
        await talk.result(2)
        assert ends(talk) == [("go forward 3 metres", "replaced", "replaced"), ("beep", "done", None)]
        turns = [event.turn for event in talk.seen if isinstance(event.body, events.RequestEnded)]
        said = [event.turn for event in talk.seen if isinstance(event.body, events.TranscriptFinal)]
        assert turns == said

    converse(test)


def test_a_request_that_a_newer_one_overtakes_before_it_begins_ends_as_replaced() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 3 metres", then=("beep",)))
        talk.send(Say("raise your arm"))
        await talk.result(1)
        assert ends(talk) == [
            ("go forward 3 metres", "replaced", None),
            ("beep", "replaced", None),
            ("raise your arm", "done", None),
        ]

    converse(test)


@pytest.mark.parametrize(
    ("command", "scope"),
    [(Interrupt(), "interrupt"), (Release(), "release"), (Wake("key"), "wake"), (Say("stop"), "stop")],
)
def test_a_request_that_is_interrupted_before_it_is_looked_at_ends_as_interrupted(
    command: Command, scope: events.Scope
) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 3 metres"))
        talk.send(command)
        talk.send(Say("beep"))
        await talk.pass_time(20)
        assert ends(talk)[0] == ("go forward 3 metres", "interrupted", scope)
        assert names(talk) == ["beep"]

    converse(test)


def test_one_that_is_turned_away_ends_as_rejected() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 1 metre"))
        await talk.until(events.ActionStarted)
        talk.send(Say("beep", then=("turn left 90 degrees",)))
        await talk.result(1)
        assert ends(talk) == [
            ("beep", "rejected", None),
            ("turn left 90 degrees", "rejected", None),
            ("go forward 1 metre", "done", None),
        ]

    converse(test, "session.busy=reject")


def test_what_was_to_follow_something_is_left_wherever_it_was_moved_to() -> None:
    async def test(talk: Conversation) -> None:
        await talk.wake_and_say("go forward 2 metres")
        await talk.until(events.ActionStarted)
        assert talk.hearing.go_on("and raise your arm", adds=True)
        talk.send(Say("beep", wait=True))
        await talk.until(events.RequestsWaiting, lambda body: len(body.texts) == 2)
        talk.send(Move(talk.bodies(events.RequestsWaiting)[-1].requests[0].request, None, "move"))
        await talk.until(events.Ack, lambda body: body.id == "move")
        talk.robot.lost = True  # the drive fails by itself, and nothing is interrupted
        await talk.result(1)
        talk.robot.lost = False
        await talk.result(2)
        assert names(talk) == ["move_forward", "beep"]
        assert [(text, outcome) for text, outcome, _ in ends(talk)] == [
            ("and raise your arm", "left"),
            ("beep", "done"),
        ]

    converse(test)


@pytest.mark.parametrize("busy", ["interrupt", "queue", "reject"])
@pytest.mark.parametrize(
    "text",
    [
        "and then raise your arm", "Then raise your arm", "afterwards raise your arm", "after that raise your arm",
        "and after that, raise your arm", "and raise your arm", "然后举起手臂", "接着举起手臂",
    ],
)  # fmt: skip
def test_what_begins_as_something_for_afterwards_interrupts_nothing(text: str, busy: str) -> None:
    async def test(talk: Conversation) -> None:
        waiting = [one.text for one in await three_waiting(talk)]
        talk.send(Say(text))
        await talk.until(events.RequestsWaiting, lambda body: len(body.texts) == 4)
        assert talk.bodies(events.RequestsWaiting)[-1].texts == (*waiting, text), "behind what waits already"
        await talk.result(5)
        assert names(talk) == ["move_forward", "beep", "move_left", "arm_up", "arm_up"]

    converse(test, f"session.busy={busy}")


@pytest.mark.parametrize("text", ["and stop", "then stop!", "然后停"])
def test_no_stop_waits_however_it_begins(text: str) -> None:
    async def test(talk: Conversation) -> None:
        await three_waiting(talk)
        talk.send(Say(text))
        assert talk.robot.state().twist.is_zero
        await talk.pass_time(20)
        assert not {"beep", "move_left", "arm_up"} & set(names(talk)), "what waited is dropped"

    converse(test)


def test_where_nothing_runs_what_is_for_afterwards_begins_at_once() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("and then raise your arm"))
        await talk.result()
        assert names(talk) == ["arm_up"]

    converse(test)


def test_an_answer_may_begin_like_that_as_well() -> None:
    async def test(talk: Conversation) -> None:
        await asked_about_the_second(talk)
        talk.send(Say("then the kitchen"))
        await talk.result(4)
        assert names(talk) == ["beep", "navigation", "arm_up"]

    converse(test)


# A question about one of them

ASKS = "go to the bedrom"
"""A name that is no place's: the robot asks whether it is another one."""


async def asked_about_the_second(talk: Conversation) -> None:
    """Three requests; the robot asks about the second one, and the third one waits."""
    talk.send(Say("beep", then=(ASKS, "raise your arm")))
    assert (await talk.result(2)).outcome == "clarify"
    await talk.pass_time(60)


@pytest.mark.parametrize("busy", ["interrupt", "queue", "reject"])
def test_what_waits_behind_a_question_begins_when_that_is_answered(busy: str) -> None:
    async def test(talk: Conversation) -> None:
        await asked_about_the_second(talk)
        assert names(talk) == ["beep"]
        talk.send(Say("yes"))
        assert (await talk.result(3)).outcome == "done"
        await talk.result(4)
        assert names(talk) == ["beep", "navigation", "arm_up"]
        assert [(text, outcome) for text, outcome, _ in ends(talk)] == [
            ("beep", "done"), (ASKS, "clarify"), ("yes", "done"), ("raise your arm", "done"),
        ]  # fmt: skip

    converse(test, f"session.busy={busy}")


@pytest.mark.parametrize(
    ("said", "does"), [("no", []), ("never mind", []), ("不", []), ("turn left 90 degrees", ["move_left"])]
)
def test_a_question_is_let_go_by_a_no_or_by_another_request_in_its_place(said: str, does: list[str]) -> None:
    async def test(talk: Conversation) -> None:
        await asked_about_the_second(talk)
        talk.send(Say(said))
        await talk.result(4)
        assert names(talk) == ["beep", *does, "arm_up"]

    converse(test)


def test_an_answer_may_be_spoken_and_nothing_that_waits_is_dropped_by_waking() -> None:
    async def test(talk: Conversation) -> None:
        await asked_about_the_second(talk)
        await talk.wake_and_say("")
        assert (await talk.result(3)).outcome == "unheard"
        await talk.pass_time(60)
        assert names(talk) == ["beep"], "nothing was said: the question is still open"
        await talk.wake_and_say("yes")
        await talk.result(5)
        assert names(talk) == ["beep", "navigation", "arm_up"]

    converse(test)


@pytest.mark.parametrize("busy", ["interrupt", "queue"])
def test_an_answer_while_the_question_is_being_put_goes_before_what_waits(busy: str) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say(ASKS, then=("raise your arm",)))
        await talk.until_state("CLARIFYING")
        talk.send(Say("yes"))
        await talk.result(3)
        assert names(talk) == ["navigation", "arm_up"]

    converse(test, f"session.busy={busy}", voice=SlowVoice())


def test_what_is_added_to_the_queue_during_a_question_is_no_answer() -> None:
    async def test(talk: Conversation) -> None:
        await asked_about_the_second(talk)
        talk.send(Say("turn left 90 degrees", wait=True))
        await talk.pass_time(60)
        assert names(talk) == ["beep"]
        talk.send(Say("yes"))
        await talk.result(5)
        assert names(talk) == ["beep", "navigation", "arm_up", "move_left"]

    converse(test)


@pytest.mark.parametrize("command", [Interrupt(), Say("stop"), EndTask()])
def test_an_interruption_drops_what_waits_for_an_answer(command: Command) -> None:
    async def test(talk: Conversation) -> None:
        await asked_about_the_second(talk)
        talk.send(command)
        await talk.pass_time(60)
        assert names(talk) == ["beep"]
        assert ("raise your arm", "interrupted") in [(text, outcome) for text, outcome, _ in ends(talk)]

    converse(test)


def test_a_session_that_is_to_end_waits_for_no_answer() -> None:
    async def test(talk: Conversation) -> None:
        await asked_about_the_second(talk)
        talk.send(Quit(drain=True, id="quit"))
        await talk.until(events.Ack, lambda body: body.id == "quit")
        assert names(talk) == ["beep", "arm_up"]

    converse(test)


# What becomes of the question


def questions(talk: Conversation) -> list[tuple[str, str, events.Scope | None]]:
    return [(body.text, body.outcome, body.by) for body in talk.bodies(events.QuestionEnded)]


@pytest.mark.parametrize(
    ("said", "outcome"),
    [
        ("yes", "answered"), ("no", "declined"), ("don't go to the kitchen", "declined"), ("don't", "declined"),
        ("the kitchen", "answered"), ("turn left 90 degrees", "replaced"),
        ("go to the laundry", "replaced"), ("thank you", "withdrawn"),
    ],
)  # fmt: skip
def test_it_is_told_once_what_becomes_of_a_question(said: str, outcome: str) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say(ASKS))
        await talk.result(1)
        asked = next(event.turn for event in talk.seen if isinstance(event.body, events.ClarificationAsked))
        assert questions(talk) == []
        talk.send(Say(said))
        await talk.result(2)
        assert questions(talk) == [(ASKS, outcome, None)]
        assert [event.turn for event in talk.seen if isinstance(event.body, events.QuestionEnded)] == [asked]

    converse(test)


def asked(talk: Conversation) -> list[str]:
    return [body.question for body in talk.bodies(events.ClarificationAsked)]


NONSENSE = ("snorf the blick", "flurb the wug")


@pytest.mark.parametrize(
    ("said", "outcome", "does"),
    [
        ("yes", "answered", ["navigation"]), ("no", "declined", []), (NONSENSE[1], "withdrawn", []),
        ("turn left 90 degrees", "replaced", ["move_left"]),
    ],
)  # fmt: skip
def test_a_question_is_put_once_more_where_the_answer_is_not_understood(
    said: str, outcome: str, does: list[str]
) -> None:
    async def test(talk: Conversation) -> None:
        await asked_about_the_second(talk)
        talk.send(Say(NONSENSE[0]))
        assert (await talk.result(3)).outcome == "clarify"
        await talk.pass_time(60)
        assert all(body.leaves_open for body in talk.bodies(events.ClarificationAsked))
        first, again = asked(talk)
        assert again == f"I did not understand: “{NONSENSE[0]}”. {first}"
        assert questions(talk) == [], "it is still open"
        assert names(talk) == ["beep"], "what waits still does"
        talk.send(Say(said))
        await talk.result(5)
        assert questions(talk) == [(ASKS, outcome, None)]
        turns = [event.turn for event in talk.seen if isinstance(event.body, events.ClarificationAsked)]
        assert [event.turn for event in talk.seen if isinstance(event.body, events.QuestionEnded)] == turns[:1]
        assert said == "no" or len(turns) == 2, "it is not put a third time"
        assert names(talk) == ["beep", *does, "arm_up"]

    converse(test)


def test_an_answer_may_complete_the_request_also_after_the_question_was_put_once_more() -> None:
    async def test(talk: Conversation) -> None:
        for number, text in enumerate(("go", NONSENSE[0], "to the kitchen"), 1):
            talk.send(Say(text))
            await talk.result(number)
        assert questions(talk) == [("go", "answered", None)]
        assert names(talk) == ["navigation"]

    converse(test)


@pytest.mark.parametrize("answer", ["to the moon", NONSENSE[0]])
def test_a_second_answer_that_names_nothing_here_gives_the_request_up(answer: str) -> None:
    async def test(talk: Conversation) -> None:
        for number, text in enumerate(("go", answer, answer), 1):
            talk.send(Say(text))
            await talk.result(number)
        assert len(asked(talk)) == 2
        assert questions(talk) == [("go", "withdrawn", None)]
        assert names(talk) == []

    converse(test)


def test_a_stop_ends_a_question_that_was_put_twice_once() -> None:
    async def test(talk: Conversation) -> None:
        for number, text in enumerate((ASKS, NONSENSE[0]), 1):
            talk.send(Say(text))
            await talk.result(number)
        talk.send(Interrupt())
        await talk.pass_time(20)
        talk.send(Say(NONSENSE[0]))
        await talk.result(3)
        assert questions(talk) == [(ASKS, "withdrawn", "interrupt")]
        assert len(asked(talk)) == 2

    converse(test)


def test_what_was_no_order_is_not_asked_about_again() -> None:
    async def test(talk: Conversation) -> None:
        for number, text in enumerate(("don't go to the kitchen", NONSENSE[0]), 1):
            talk.send(Say(text))
            await talk.result(number)
        assert len(asked(talk)) == 1
        assert not talk.bodies(events.ClarificationAsked)[0].leaves_open
        assert questions(talk) == []

    converse(test)


def test_a_request_that_is_asked_about_twice_keeps_its_words() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go"))
        await talk.result(1)
        talk.send(Say("to the bedrom"))
        await talk.result(2)
        talk.send(Say("beep"))
        await talk.result(3)
        assert questions(talk) == [("go", "answered", None), ("go", "replaced", None)]

    converse(test)


@pytest.mark.parametrize("while_put", [True, False])
@pytest.mark.parametrize(
    ("command", "scope"), [(Interrupt(), "interrupt"), (Release(), "release"), (Say("stop"), "stop")]
)
def test_a_question_that_is_interrupted_is_withdrawn_and_a_later_yes_does_nothing(
    command: Command, scope: events.Scope, *, while_put: bool
) -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say(ASKS))
        await (talk.until_state("CLARIFYING") if while_put else talk.result(1))
        talk.send(command)
        await talk.pass_time(20)
        assert questions(talk) == [(ASKS, "withdrawn", scope)]
        talk.send(Say("yes"))
        await talk.pass_time(60)
        assert names(talk) == []
        assert len(questions(talk)) == 1

    converse(test, voice=SlowVoice())


def test_what_is_added_to_the_queue_during_a_question_waits_also_where_nothing_else_does() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say(ASKS))
        await talk.result(1)
        talk.send(Say("turn left 90 degrees", wait=True))
        await talk.pass_time(60)
        assert names(talk) == []
        assert talk.bodies(events.RequestsWaiting)[-1].texts == ("turn left 90 degrees",)
        talk.send(Say("yes"))
        await talk.result(3)
        assert names(talk) == ["navigation", "move_left"]

    converse(test)


# A stop among several lines


@pytest.mark.parametrize("wait", [True, False])
@pytest.mark.parametrize("stop", ["stop", "Stop!", "停"])
def test_a_stop_among_several_lines_stops_at_once_whatever_stands_before_it(stop: str, *, wait: bool) -> None:
    async def test(talk: Conversation) -> None:
        waiting = await three_waiting(talk)
        talk.send(Say("nod", then=("dance", stop), wait=wait))
        assert talk.robot.state().twist.is_zero, "when the call returns"
        await talk.pass_time(60)
        assert names(talk) == ["move_forward"]
        interrupted = {(one.text, "interrupted", "stop") for one in waiting}
        assert set(ends(talk)) == interrupted | {
            ("go forward 3 metres", "interrupted", "stop"), ("nod", "interrupted", "stop"),
            ("dance", "interrupted", "stop"), (stop, "done", None),
        }  # fmt: skip

    converse(test)


def test_what_stands_behind_the_stop_is_asked_for_anew() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("go forward 3 metres"))
        await talk.until(events.ActionStarted)
        talk.send(Say("nod", "all", then=("stop", "dance", "stop", "beep", "raise your arm")))
        await talk.result(4)
        assert names(talk) == ["move_forward", "beep", "arm_up"]
        assert [(text, outcome) for text, outcome, _ in ends(talk)] == [
            ("go forward 3 metres", "interrupted"), ("nod", "interrupted"), ("stop", "interrupted"),
            ("dance", "interrupted"), ("stop", "done"), ("beep", "done"), ("raise your arm", "done"),
        ]  # fmt: skip

    converse(test)


def test_an_emergency_stop_among_several_lines_is_pressed_at_once() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("nod", then=("emergency stop", "stop")))
        assert talk.robot.state().estop
        await talk.pass_time(60)
        assert names(talk) == []

    converse(test)


def test_the_end_of_the_task_among_several_lines_comes_in_its_turn() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("beep", then=("nod", "that's all")))
        await talk.until(events.TaskEnded)
        assert names(talk) == ["beep", "arm_nod"]

    converse(test)
