"""Which of the goals that a server has taken is ours, as far as a bridge lets anybody know."""

from __future__ import annotations

import asyncio
from typing import Any

from engine.ros.rosbridge.goals import Goal, Id, Statuses

ACCEPTED, EXECUTING, CANCELING, SUCCEEDED = 1, 2, 3, 4


class Expected(Goal):
    """A goal that writes down what it is told."""

    def __init__(self) -> None:
        super().__init__("/act", "a/action/B", {}, lambda message: None, None, lambda act: act(), lambda order: None)
        self.told: list[tuple[str, int]] = []

    def seen(self, id: Id, stamp: int) -> None:
        self.told.append(("seen", id[0]))
        super().seen(id, stamp)

    def over(self, id: Id) -> None:
        self.told.append(("over", id[0]))
        super().over(id)


def status(*goals: tuple[int, int]) -> dict[str, Any]:
    """The first byte of each id, which also says when it was taken, and its state."""
    return {
        "status_list": [
            {
                "goal_info": {"goal_id": {"uuid": [id] + [0] * 15}, "stamp": {"sec": id, "nanosec": 0}},
                "status": state,
            }
            for id, state in goals
        ]
    }


def test_what_is_taken_while_one_is_expected_may_be_that_one() -> None:
    statuses, goal = Statuses(), Expected()
    statuses.hear(status((1, EXECUTING)))
    statuses.expect(goal)
    statuses.hear(status((1, EXECUTING), (2, ACCEPTED), (3, CANCELING), (4, SUCCEEDED)))
    assert goal.told == [("seen", 2)], "the others were there before, or end"
    statuses.forget(goal)
    statuses.hear(status((1, EXECUTING), (2, EXECUTING), (5, ACCEPTED)))
    assert goal.told == [("seen", 2)]


def test_the_newest_is_the_likeliest_and_one_that_ends_was_none_of_ours() -> None:
    asyncio.run(_newest())


async def _newest() -> None:
    statuses, goal = Statuses(), Expected()
    statuses.expect(goal)
    statuses.hear(status((7, EXECUTING), (6, EXECUTING)))
    assert max(goal._server_ids.values()) == 7 * 10**9
    statuses.hear(status((7, SUCCEEDED), (6, EXECUTING)))
    assert list(goal._server_ids) == [(6, *[0] * 15)]
    assert goal._taken
    statuses.hear(status())
    assert not goal._taken
    assert goal._accept_by > asyncio.get_running_loop().time(), "it may be taken yet"


def test_of_several_each_gets_one() -> None:
    statuses, first, second = Statuses(), Expected(), Expected()
    statuses.expect(first)
    statuses.expect(second)
    statuses.hear(status((2, ACCEPTED)))
    statuses.hear(status((2, EXECUTING), (3, ACCEPTED)))
    assert [first.told, second.told] == [[("seen", 2)], [("seen", 3)]]


def test_what_makes_no_sense_is_nothing() -> None:
    statuses, goal = Statuses(), Expected()
    statuses.expect(goal)
    for wrong in ({}, {"status_list": 3}, {"status_list": [{}]}, {"status_list": [{"status": 1, "goal_info": None}]}):
        statuses.hear(wrong)
    assert goal.told == []
