"""Work that is cancelled gets a short grace, and nobody waits longer for it than that."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from dataclasses import dataclass
from typing import Any

import pytest

from engine.cancellation import GRACE_S, Remains, bounded
from tests.virtual_time import run

WORK_S = 1.0


@dataclass
class Ended:
    """How it was for the one who waited for cancelled work."""

    remains: Remains[str]
    late: list[str | BaseException]
    """What the work brought when nobody waited any more."""
    waited: float
    """From the cancellation on, s."""


async def cancel(work: Coroutine[Any, Any, str], *after: float) -> Ended:
    """Await ``work`` and be cancelled after these times, s."""
    loop = asyncio.get_running_loop()
    late: list[str | BaseException] = []
    remains: Remains[str] = Remains(late.append)
    caller = asyncio.create_task(bounded(work, remains))
    for seconds in after:
        await asyncio.sleep(seconds)
        caller.cancel()
    cancelled = loop.time()
    await asyncio.wait([caller])
    assert caller.cancelled()
    return Ended(remains, late, loop.time() - cancelled)


async def willing() -> str:
    await asyncio.sleep(WORK_S)
    return "done"


async def cleaning_up(seconds: float, then: str | Exception | None = None) -> str:
    """Takes ``seconds`` to end once it is cancelled, and then returns or raises what is given."""
    try:
        await asyncio.sleep(WORK_S)
    except asyncio.CancelledError:
        await asyncio.sleep(seconds)
        if isinstance(then, Exception):
            raise then from None
        if then is None:
            raise
        return then
    return "done"


def test_undisturbed_work_brings_what_it_brings() -> None:
    assert run(bounded(willing())) == "done"


def test_undisturbed_work_raises_what_it_raises() -> None:
    async def broken() -> str:
        raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        run(bounded(broken()))


def test_work_that_lets_go_is_over_at_once_and_brings_nothing() -> None:
    ended = run(cancel(willing(), 0.5))
    assert (ended.waited, ended.remains.let_go, ended.remains.found, ended.late) == (0.0, True, None, [])


def test_the_caller_waits_while_work_cleans_up_within_the_grace() -> None:
    ended = run(cancel(cleaning_up(GRACE_S / 2), 0.5))
    assert ended.waited == pytest.approx(GRACE_S / 2)
    assert (ended.remains.let_go, ended.remains.found) == (True, None)


def test_what_work_brings_within_the_grace_is_kept_and_not_returned() -> None:
    ended = run(cancel(cleaning_up(GRACE_S / 2, "just in time"), 0.5))
    assert (ended.remains.let_go, ended.remains.found, ended.late) == (True, "just in time", [])


def test_an_error_in_the_clean_up_is_kept_and_not_raised() -> None:
    fault = ValueError("broken")
    ended = run(cancel(cleaning_up(GRACE_S / 2, fault), 0.5))
    assert (ended.remains.let_go, ended.remains.found) == (True, fault)


def test_work_that_ends_in_the_moment_of_its_cancellation_loses_nothing() -> None:
    async def work() -> None:
        remains: Remains[str] = Remains()
        gate: asyncio.Future[None] = asyncio.get_running_loop().create_future()

        async def gated() -> str:
            await gate
            caller.cancel()  # the caller has not heard of its end yet
            return "done"

        caller = asyncio.create_task(bounded(gated(), remains))
        await asyncio.sleep(0)
        gate.set_result(None)
        await asyncio.wait([caller])
        assert caller.cancelled()
        assert (remains.let_go, remains.found) == (True, "done")

    run(work())


def test_nobody_waits_longer_than_the_grace_for_work_that_does_not_let_go() -> None:
    ended = run(cancel(cleaning_up(60.0), 0.5))
    assert ended.waited == pytest.approx(GRACE_S)
    assert (ended.remains.let_go, ended.remains.found, ended.late) == (False, None, [])


@pytest.mark.parametrize("brings", ["late", ValueError("broken")], ids=["a result", "an error"])
def test_what_comes_after_the_grace_is_told_once_and_goes_nowhere_else(brings: str | Exception) -> None:
    async def work() -> None:
        ended = await cancel(cleaning_up(60.0, brings), 0.5)
        assert ended.late == []
        await asyncio.sleep(60.0)
        assert ended.late == [brings]
        assert (ended.remains.let_go, ended.remains.found) == (False, None)

    run(work())


def test_work_that_is_cancelled_in_the_end_has_nothing_to_tell() -> None:
    async def work() -> None:
        ended = await cancel(cleaning_up(60.0), 0.5)
        await asyncio.sleep(60.0)
        assert ended.late == []

    run(work())


def test_a_second_cancellation_ends_the_grace() -> None:
    async def work() -> None:
        ended = await cancel(cleaning_up(GRACE_S / 2, "late"), 0.5, GRACE_S / 4)
        assert (ended.waited, ended.remains.let_go, ended.late) == (0.0, False, [])
        await asyncio.sleep(GRACE_S)
        assert ended.late == ["late"]

    run(work())


def test_work_that_cancels_itself_is_a_fault_and_no_interruption() -> None:
    async def confused() -> str:
        raise asyncio.CancelledError

    with pytest.raises(RuntimeError, match="cancelled itself"):
        run(bounded(confused()))
