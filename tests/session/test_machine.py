"""Thousands of random steps of conversations: see ``tests.session.machine``; ``tests/bench/session.py`` has more."""

from __future__ import annotations

import gc

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.stateful import run_state_machine_as_test

from tests.session.machine import BUSY, SessionMachine, counts, planner

STEPS = 4_000
LENGTH = 60
"""Steps of one conversation; some are shorter."""


@pytest.fixture(autouse=True)
def _little_to_look_through() -> None:
    """Every conversation ends with a look for what it has left behind; what all other tests have loaded and the
    planners of these, hundreds of megabytes of it, need not be looked through each time."""
    for busy in BUSY:
        planner(busy)
    gc.collect()
    gc.freeze()


MOST_STEPS = 5 * STEPS
"""What is met less often is looked for so long: how often it comes, chance decides."""
ENDED = ("done", "interrupted", "replaced", "dropped", "rejected")
MET = (
    "drop taken",
    "move taken",
    "pauses",
    "added",
    "actions ok",
    "actions failed",
    "actions interrupted",
    "actions uncertain",
)


@pytest.mark.timeout(600)  # it only computes, which may take a busy machine this long
def test_thousands_of_random_steps_break_no_rule_of_interruption() -> None:
    counts.clear()
    while counts["steps"] < STEPS or (counts["steps"] < MOST_STEPS and _unmet()):
        run_state_machine_as_test(  # type: ignore[no-untyped-call]
            SessionMachine,
            settings=settings(
                max_examples=STEPS // LENGTH * 5 // 4,
                stateful_step_count=LENGTH,
                deadline=None,
                suppress_health_check=list(HealthCheck),
            ),
        )
    assert counts["interruptions"] > STEPS / 10, counts
    assert not _unmet(), counts


def _unmet() -> list[str]:
    """What has not come about often enough."""
    unmet = [f"requests {ended}" for ended in ENDED if not counts[f"requests {ended}"]]
    return unmet + [met for met in MET if counts[met] <= 8]
