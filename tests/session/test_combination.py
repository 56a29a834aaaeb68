"""Actions that start together: they overlap as far as what they occupy allows, and fail together."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

from engine import events
from engine.commands import Interrupt, Say
from engine.errors import RobotError
from engine.plan import Plan, parse_calls
from engine.planner.planner import NoPlan, PlanRequest
from engine.robot.geometry import Twist
from engine.robot.robot import Capability
from engine.skills.context import SkillContext
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import Skill, SkillRegistry
from tests.session.conversation import Conversation, converse

Work = Callable[[SkillContext], Coroutine[Any, Any, Result]]


class Given:
    """A planner that has one plan, written as actions."""

    understood = ""

    def __init__(self, actions: str, registry: SkillRegistry) -> None:
        self._plan = Plan("test", tuple(map(registry.resolve, parse_calls(actions))), "", "direct")

    async def plan(self, request: PlanRequest) -> Plan | NoPlan:
        request.enter("PLANNING")
        return self._plan


def act(
    actions: str, test: Callable[[Conversation], Coroutine[Any, Any, None]], **more: tuple[Work, set[Capability]]
) -> None:
    """Run ``test`` while a session carries out ``actions``; ``more`` are skills by name, with what they occupy."""
    registries: list[SkillRegistry] = []

    def with_more(registry: SkillRegistry) -> SkillRegistry:
        extra = [
            Skill(name, name, (), frozenset(occupies), run, endless=name == "endless")
            for name, (run, occupies) in more.items()
        ]
        every: frozenset[Capability] = frozenset({"base", "arm", "camera", "voice"})
        registries.append(SkillRegistry([*registry, *extra], capabilities=every))
        return registries[0]

    async def begun(talk: Conversation) -> None:
        talk.planner.real = Given(actions, registries[0])  # type: ignore[assignment]
        talk.send(Say("go"))
        await test(talk)

    converse(begun, skills=with_more)


def order(talk: Conversation) -> list[str]:
    """What started (+) and ended (-), in that order."""
    return [
        f"{'+' if isinstance(event.body, events.ActionStarted) else '-'}{event.body.name}"
        for event in talk.seen
        if isinstance(event.body, events.ActionStarted | events.ActionFinished)
    ]


def test_arm_and_base_move_at_the_same_time_where_the_plan_says_so() -> None:
    async def test(talk: Conversation) -> None:
        assert (await talk.result()).outcome == "done"
        assert order(talk) == ["+move_forward", "+arm_nod", "-arm_nod", "-move_forward", "+beep", "-beep"]

    act("move_forward(1) & arm_nod, beep", test)


def test_without_that_they_move_one_after_the_other() -> None:
    async def test(talk: Conversation) -> None:
        await talk.result()
        assert order(talk) == ["+move_forward", "-move_forward", "+arm_nod", "-arm_nod"]

    act("move_forward(1), arm_nod", test)


def test_two_that_need_the_base_never_overlap_whatever_the_plan_says() -> None:
    async def test(talk: Conversation) -> None:
        await talk.result()
        assert order(talk) == ["+move_forward", "-move_forward", "+move_left", "-move_left"]

    act("move_forward(1) & move_left(90)", test)


def test_a_failure_cuts_what_runs_beside_it_and_starts_nothing_more() -> None:
    async def broken(context: SkillContext) -> Result:
        await context.sleep(0.5)
        return fail("not_supported", "It broke.")

    async def test(talk: Conversation) -> None:
        result = await talk.result()
        assert (result.outcome, result.message) == ("failed", "It broke. I did not start: beeping.")
        ended = {body.name: body for body in talk.bodies(events.ActionFinished)}
        assert (ended["broken"].outcome, ended["move_forward"].outcome) == ("failed", "interrupted")
        assert "because broken failed" in ended["move_forward"].message
        assert talk.robot.state().twist.is_zero  # in the same epoch: the dispatcher itself has stopped the base

    act("move_forward(5) & broken, beep", test, broken=(broken, {"arm"}))


def test_an_interruption_ends_all_that_run_together_each_once() -> None:
    async def test(talk: Conversation) -> None:
        await talk.until(events.ActionStarted, lambda body: body.name == "arm_nod")
        talk.send(Interrupt())
        await talk.result()
        await talk.pass_time(10.0)
        outcomes = sorted((body.name, body.outcome) for body in talk.bodies(events.ActionFinished))
        assert outcomes == [("arm_nod", "interrupted"), ("move_forward", "interrupted")]

    act("move_forward(5) & arm_nod, beep", test)


def test_a_skill_that_does_not_let_go_is_given_up_and_moves_nothing_more() -> None:
    async def stubborn(context: SkillContext) -> Result:
        end = context.robot.state().t + 5.0
        while context.robot.state().t < end:
            try:
                context.drive(Twist(0.3))
                await context.say("I go on")
                context.progress(0.5, "still here")
                await context.sleep(0.1)
            except asyncio.CancelledError:
                continue
        return ok("Done at last.")

    async def test(talk: Conversation) -> None:
        await talk.until(events.ActionStarted)
        await talk.pass_time(1.0)
        talk.send(Interrupt())
        assert talk.robot.state().twist.is_zero
        stopped = asyncio.get_running_loop().time()
        assert (await talk.result()).outcome == "interrupted"
        (finished,) = talk.bodies(events.ActionFinished)
        assert (finished.outcome, finished.error_code) == ("uncertain", "cancelled")
        before = len(talk.bodies(events.ActionProgress)), len(talk.bodies(events.SpeechStarted))
        await talk.pass_time(10.0)
        assert before == (len(talk.bodies(events.ActionProgress)), len(talk.bodies(events.SpeechStarted)))
        assert len(talk.bodies(events.ActionFinished)) == 1
        assert all(when <= stopped for when, _, _ in talk.robot.moved)
        assert talk.robot.refused > 0
        assert any("ended late" in body.message for body in talk.bodies(events.Log))

    act("stubborn", test, stubborn=(stubborn, {"base"}))


def test_an_end_that_comes_after_the_stop_counts_as_interrupted_and_keeps_its_report() -> None:
    async def quick(context: SkillContext) -> Result:
        await context.sleep(0.1)
        return ok("Just in time.")

    async def test(talk: Conversation) -> None:
        await talk.until(events.ActionStarted)
        loop = asyncio.get_running_loop()
        loop.call_later(0.1, talk.epoch.advance)  # in the thread of a key handler, before the loop hears of it
        loop.call_later(0.5, talk.send, Interrupt())
        assert (await talk.result()).outcome == "interrupted"
        (finished,) = talk.bodies(events.ActionFinished)
        assert finished.outcome == "interrupted"
        assert "Its last report: Just in time." in finished.message

    act("quick", test, quick=(quick, {"arm"}))


def test_a_skill_with_a_fault_ends_its_action_and_not_the_session() -> None:
    async def faulty(context: SkillContext) -> Result:
        raise ValueError("oops")

    async def test(talk: Conversation) -> None:
        assert (await talk.result()).outcome == "failed"
        (finished,) = talk.bodies(events.ActionFinished)
        assert (finished.outcome, finished.error_code) == ("failed", "crashed")
        assert talk.session.state == "WAITING"

    act("faulty", test, faulty=(faulty, set()))


def test_a_lost_robot_makes_every_running_action_uncertain() -> None:
    async def lost(context: SkillContext) -> Result:
        raise RobotError("The robot process died.")

    async def test(talk: Conversation) -> None:
        assert (await talk.result()).exit_code == 3
        (finished,) = talk.bodies(events.ActionFinished)
        assert (finished.outcome, finished.error_code) == ("uncertain", "robot_lost")

    act("lost", test, lost=(lost, {"base"}))


def test_what_waited_for_the_base_does_not_start_once_the_epoch_is_over() -> None:
    async def test(talk: Conversation) -> None:
        await talk.until(events.ActionStarted)
        talk.epoch.advance()  # in another thread, of which the loop hears later
        await talk.pass_time(0.6)
        talk.send(Interrupt())
        await talk.result()
        assert order(talk) == ["+short", "-short"]

    async def short(context: SkillContext) -> Result:
        await context.sleep(0.3)
        return ok()

    act("short & short", test, short=(short, {"base"}))


def test_a_time_limit_and_an_interruption_together_leave_a_skill_its_time_to_clean_up() -> None:
    cleaned: list[str] = []

    async def tidy(context: SkillContext) -> Result:
        try:
            await context.sleep(1e3)
        finally:
            await asyncio.sleep(0.3)
            cleaned.append("up")
        return ok()

    async def test(talk: Conversation) -> None:
        asyncio.get_running_loop().call_later(600.1, talk.send, Interrupt())  # a moment after the limit
        assert (await talk.result()).outcome == "timeout"
        (finished,) = talk.bodies(events.ActionFinished)
        assert (finished.outcome, finished.error_code) == ("interrupted", "time_limit")
        assert cleaned == ["up"]

    act("tidy", test, tidy=(tidy, {"arm"}))


def test_what_goes_on_until_told_otherwise_knows_no_time_limit() -> None:
    async def endless(context: SkillContext) -> Result:
        while True:
            await context.sleep(1.0)

    async def test(talk: Conversation) -> None:
        await talk.pass_time(1500.0)
        assert talk.session.state == "ACTING"
        talk.send(Interrupt())
        assert (await talk.result()).outcome == "interrupted"

    act("endless", test, endless=(endless, {"base"}))
