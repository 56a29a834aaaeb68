"""One request, several plans: what became of one is thought over before the next, until nothing is left to be done."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from config import load
from engine import events
from engine.commands import Interrupt, Say, Wake
from engine.errors import ExitCode
from engine.llm.chat import Unreachable
from engine.perception.memory import WorldMemory
from engine.plan import Plan, parse_calls
from engine.planner.build import build_registry
from engine.planner.request import NoPlan, PlanRequest, Ran, Said
from engine.robot.camera import Picture
from engine.session.recall import Recall
from tests.session.conversation import Conversation, converse

REGISTRY = build_registry(load(environ={}))


def plan(actions: str, response: str = "", *, finished: bool = True) -> Plan:
    """What a model came up with."""
    resolved = tuple(REGISTRY.resolve(call) for call in parse_calls(actions))
    return Plan("what was asked", resolved, response, "openai", finished=finished)


@dataclass
class Model:
    """Answers one request after the other with what a test has prepared."""

    answers: list[Plan | NoPlan | Exception]
    asked: list[PlanRequest] = field(default_factory=list)
    stages: tuple[Literal["DECIDING", "PLANNING"], ...] = ("PLANNING",)
    understood = "Say anything."

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        self.asked.append(request)
        for stage in self.stages:
            request.enter(stage)
        answer = self.answers[min(len(self.asked), len(self.answers)) - 1]
        if isinstance(answer, Exception):
            raise answer
        return answer


FAILS = "putdown()"
"""Nothing is held."""


def test_a_plan_that_is_not_finished_is_thought_over_with_what_became_of_it() -> None:
    model = Model([plan("beep()", finished=False), plan("wait(1)"), plan("beep()")])

    async def test(talk: Conversation) -> None:
        talk.send(Say("look before you leap"))
        result = await talk.result()
        assert (result.exit_code, result.outcome) == (ExitCode.DONE, "done")
        assert [body.name for body in talk.bodies(events.ActionFinished)] == ["beep", "wait"]
        first, second = model.asked
        assert (first.text, second.text) == ("look before you leap", "")
        assert [type(entry) for entry in second.happened] == [Said, Plan, Ran]
        assert str(second.happened[-1]).startswith("beep(0.2) ok.")
        assert first.cycle == second.cycle != ""
        assert len(talk.results) == 1

    converse(test, plans=model)


def test_a_response_after_feedback_ends_the_turn_with_it() -> None:
    model = Model([plan("beep()", finished=False), plan("", "That was all.")])

    async def test(talk: Conversation) -> None:
        talk.send(Say("beep and tell me"))
        result = await talk.result()
        assert (result.exit_code, result.message) == (ExitCode.DONE, "That was all.")

    converse(test, plans=model)


def test_a_question_after_feedback_makes_the_turn_end_with_5() -> None:
    question = NoPlan("what was asked", "unclear", "Which one?", ExitCode.CLARIFY)
    model = Model([plan("beep()", finished=False), question])

    async def test(talk: Conversation) -> None:
        talk.send(Say("beep at it"))
        assert (await talk.result()).exit_code == ExitCode.CLARIFY
        assert [body.question for body in talk.bodies(events.ClarificationAsked)] == ["Which one?"]
        talk.send(Say("the red one"))
        await talk.result(2)
        assert model.asked[2].happened[-1] == question

    converse(test, plans=model)


def test_what_failed_twice_is_spent_and_its_failure_is_what_is_reported() -> None:
    model = Model([plan(FAILS), plan(FAILS), plan("", "I cannot get there.")])

    async def test(talk: Conversation) -> None:
        talk.send(Say("go somewhere"))
        result = await talk.result()
        assert (result.exit_code, result.message) == (ExitCode.FAILED, "I cannot get there.")
        failed = [str(body.name) for body in talk.bodies(events.ActionFinished) if body.outcome == "failed"]
        assert failed == ["putdown", "putdown"]
        assert [len(request.spent) for request in model.asked] == [0, 0, 1]

    converse(test, plans=model)


def test_a_look_at_which_the_camera_is_lost_is_thought_over_without_a_picture() -> None:
    model = Model([plan("seewhat()", finished=False), plan("", "I cannot see.")])

    async def test(talk: Conversation) -> None:
        looks: list[str] = []
        look = talk.robot.look

        async def counted() -> Picture:
            looks.append("look")
            return await look()

        talk.robot.look = counted  # type: ignore[method-assign]
        talk.send(Say("what is there"))
        result = await talk.result()
        assert (result.exit_code, result.message) == (ExitCode.FAILED, "I cannot see.")
        assert [body.error_code for body in talk.bodies(events.ActionFinished)] == ["camera_lost"]
        assert [request.picture for request in model.asked] == [None, None]
        assert len(looks) == 1, "what failed once is not waited for again"

    converse(test, plans=model)


def test_where_the_camera_is_lost_after_a_look_there_is_no_picture() -> None:
    async def test(talk: Conversation) -> None:
        assert await Recall(talk.robot, WorldMemory()).picture() is None

    converse(test)


def test_a_model_that_fails_after_a_failure_leaves_the_failure_to_be_told() -> None:
    model = Model([plan(FAILS), Unreachable("Nobody there.")])

    async def test(talk: Conversation) -> None:
        talk.send(Say("go somewhere"))
        result = await talk.result()
        assert result.exit_code == ExitCode.FAILED
        assert result.message == talk.bodies(events.ActionFinished)[0].message
        assert [body.message for body in talk.bodies(events.ErrorRaised)] == ["Nobody there."]

    converse(test, plans=model)


def test_a_model_that_fails_before_it_is_finished_does_not_pass_for_having_finished() -> None:
    model = Model([plan("beep()", finished=False), Unreachable("Nobody there.")])

    async def test(talk: Conversation) -> None:
        talk.send(Say("beep and tell me"))
        result = await talk.result()
        assert result.exit_code == ExitCode.MISSING
        assert result.message == "I cannot tell whether that was all. Nobody there."
        assert [body.message for body in talk.bodies(events.ErrorRaised)] == ["Nobody there."]

    converse(test, plans=model)


def test_two_stages_of_thinking_are_entered_in_every_round_once() -> None:
    model = Model([plan("beep()", finished=False), plan("beep()")], stages=("DECIDING", "PLANNING", "PLANNING"))

    async def test(talk: Conversation) -> None:
        talk.send(Say("beep and tell me"))
        assert (await talk.result()).exit_code == ExitCode.DONE
        thinking = [body.state for body in talk.bodies(events.StateChanged) if body.state in ("DECIDING", "PLANNING")]
        assert thinking == ["DECIDING", "PLANNING"] * 2

    converse(test, plans=model)


def test_a_refusal_of_what_was_spoken_takes_no_thinking_and_is_told() -> None:
    model = Model([NoPlan("hit the wall", "refused_damage", "No.", ExitCode.REFUSED)], stages=())

    async def test(talk: Conversation) -> None:
        talk.send(Wake())
        await talk.until_state("LISTENING")
        await talk.until(events.ListenStarted)
        assert talk.hearing.speak("hit the wall")
        result = await talk.result()
        assert (result.exit_code, result.message) == (ExitCode.REFUSED, "No.")

    converse(test, plans=model)


def test_a_model_that_never_finishes_is_stopped_by_the_number_of_rounds() -> None:
    model = Model([plan("beep()", finished=False)])

    async def test(talk: Conversation) -> None:
        talk.send(Say("beep for ever"))
        result = await talk.result()
        assert result.exit_code == ExitCode.FAILED
        assert "After 3 plans I gave up" in result.message
        assert len(talk.bodies(events.ActionFinished)) == 3

    converse(test, "planner.rounds=3", plans=model)


def test_a_request_does_not_lead_to_more_actions_than_are_allowed() -> None:
    model = Model([plan("beep(), beep(), beep()", finished=False)])

    async def test(talk: Conversation) -> None:
        talk.send(Say("beep for ever"))
        assert (await talk.result()).exit_code == ExitCode.FAILED
        assert len(talk.bodies(events.ActionFinished)) == 6

    converse(test, "planner.steps=8", plans=model)


def test_nothing_follows_when_the_thinking_between_two_plans_is_interrupted() -> None:
    model = Model([plan("beep()", finished=False)])

    async def test(talk: Conversation) -> None:
        talk.planner.plan_s = 2.0
        talk.send(Say("beep for ever"))
        await talk.until(events.ActionFinished)
        await talk.until_state("PLANNING")
        talk.send(Interrupt())
        assert (await talk.result()).exit_code == ExitCode.INTERRUPTED
        await talk.pass_time(10.0)
        assert len(talk.bodies(events.ActionStarted)) == 1

    converse(test, plans=model)
