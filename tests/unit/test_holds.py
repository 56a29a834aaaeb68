"""Who may use what of the robot: nobody together, nobody twice, and nobody who is not there any more."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any

from engine.robot.robot import Capability
from engine.session.holds import Hold, Holds
from tests.virtual_time import run

EPOCH = 7


class Actions:
    """Actions that hold what they occupy for some seconds, and a record of when."""

    def __init__(self) -> None:
        self.holds = Holds()
        self.order: list[str] = []
        """What began (+) and ended (-), in that order."""

    async def act(self, name: str, occupies: set[Capability], seconds: float = 1.0, epoch: int = EPOCH) -> None:
        hold = await self.holds.acquire(occupies, epoch)
        self.order.append(f"+{name}")
        try:
            await asyncio.sleep(seconds)
        finally:
            self.order.append(f"-{name}")
            self.holds.release(hold)

    async def begin(self, name: str, occupies: set[Capability], seconds: float = 1.0) -> asyncio.Task[None]:
        """Start an action and let it come as far as it can at once."""
        task = asyncio.create_task(self.act(name, occupies, seconds))
        await settle()
        return task


async def settle() -> None:
    """Let everybody run who can; no time passes."""
    for _ in range(5):
        await asyncio.sleep(0)


def order(*actions: tuple[str, set[Capability], float]) -> list[str]:
    """What begins and ends when these are asked for one after the other in the same moment."""

    async def work() -> list[str]:
        them = Actions()
        tasks = [await them.begin(*action) for action in actions]
        await asyncio.gather(*tasks)
        assert_free(them.holds)
        return them.order

    return run(work())


def assert_free(holds: Holds) -> None:
    every: tuple[Capability, ...] = ("base", "arm", "camera", "voice")
    assert [holds.holder(capability) for capability in every] == [None] * len(every)


def test_two_that_need_the_base_never_overlap() -> None:
    assert order(("drive", {"base"}, 2.0), ("turn", {"base"}, 1.0)) == ["+drive", "-drive", "+turn", "-turn"]


def test_two_that_need_different_things_overlap() -> None:
    assert order(("drive", {"base"}, 2.0), ("nod", {"arm"}, 1.0)) == ["+drive", "+nod", "-nod", "-drive"]


def test_what_needs_nothing_never_waits() -> None:
    assert order(("drive", {"base"}, 2.0), ("wait", set(), 1.0)) == ["+drive", "+wait", "-wait", "-drive"]


def test_those_who_wait_for_the_same_are_served_in_the_order_in_which_they_came() -> None:
    happened = order(("d", {"base"}, 1.0), ("a", {"base"}, 1.0), ("c", {"base"}, 1.0), ("b", {"base"}, 1.0))
    assert happened == ["+d", "-d", "+a", "-a", "+c", "-c", "+b", "-b"]


def test_who_needs_two_things_is_not_starved_by_those_who_need_one_of_them() -> None:
    assert order(
        ("drive", {"base"}, 2.0),
        ("dance", {"base", "arm"}, 1.0),  # waits for the base
        ("nod", {"arm"}, 1.0),  # the arm is free, but not this one's turn
        ("look", {"camera"}, 0.5),  # in nobody's way
    ) == ["+drive", "+look", "-look", "-drive", "+dance", "-dance", "+nod", "-nod"]


def test_all_that_one_action_occupies_is_held_at_once_or_not_at_all() -> None:
    async def work() -> None:
        them = Actions()
        driving = await them.begin("drive", {"base"})
        dancing = await them.begin("dance", {"base", "arm"})
        assert them.holds.holder("arm") is None
        await driving
        await settle()
        assert them.holds.holder("arm") is them.holds.holder("base") is not None
        await dancing

    run(work())


def test_a_new_epoch_revokes_the_holds_of_older_ones() -> None:
    async def work() -> None:
        holds = Holds()
        await holds.acquire({"base", "arm"}, EPOCH)
        new = await at_once(holds.acquire({"base"}, EPOCH + 1))
        assert holds.holder("base") is new
        assert holds.holder("arm") is None

    run(work())


def test_a_hold_of_the_same_epoch_is_not_revoked() -> None:
    async def work() -> None:
        holds = Holds()
        first = await holds.acquire({"base"}, EPOCH)
        second = asyncio.create_task(holds.acquire({"base"}, EPOCH))
        await settle()
        assert holds.holder("base") is first
        holds.release(first)
        assert holds.holder("base") is await second

    run(work())


def test_a_late_release_does_not_free_what_somebody_else_holds_by_then() -> None:
    async def work() -> None:
        holds = Holds()
        old = await holds.acquire({"base"}, EPOCH)
        new = await holds.acquire({"base"}, EPOCH + 1)
        waiting = asyncio.create_task(holds.acquire({"base"}, EPOCH + 1))
        holds.release(old)
        await settle()
        assert holds.holder("base") is new
        assert not waiting.done()
        holds.release(new)
        assert holds.holder("base") is await waiting

    run(work())


def test_releasing_twice_frees_nothing_of_anybody_else() -> None:
    async def work() -> None:
        holds = Holds()
        first = await holds.acquire({"base"}, EPOCH)
        holds.release(first)
        second = await holds.acquire({"base"}, EPOCH)
        holds.release(first)
        assert holds.holder("base") is second

    run(work())


def test_who_is_cancelled_while_waiting_leaves_nothing_and_stands_in_nobodys_way() -> None:
    async def work() -> None:
        them = Actions()
        driving = await them.begin("drive", {"base"})
        dancing = await them.begin("dance", {"base", "arm"})
        nodding = await them.begin("nod", {"arm"})
        dancing.cancel()
        await settle()
        assert them.order == ["+drive", "+nod"]  # at once: it waited only behind the one that has gone
        await asyncio.gather(driving, nodding)
        assert_free(them.holds)

    run(work())


def test_who_is_cancelled_in_the_moment_of_being_served_leaves_nothing() -> None:
    async def work() -> None:
        holds = Holds()
        first = await holds.acquire({"base"}, EPOCH)
        second = asyncio.create_task(holds.acquire({"base"}, EPOCH))
        await settle()
        holds.release(first)  # the second has it now, and does not know yet
        assert holds.holder("base") is not None
        second.cancel()
        await asyncio.wait([second])
        assert second.cancelled()
        assert_free(holds)

    run(work())


async def at_once(work: Coroutine[Any, Any, Hold]) -> Hold:
    """What ``work`` brings without any waiting."""
    task = asyncio.create_task(work)
    await settle()
    assert task.done(), "it waits"
    return task.result()
