"""Random conversations, ten thousand steps of them: see ``tests.session.machine``."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.stateful import run_state_machine_as_test

from tests.session.machine import SessionMachine, counts

STEPS = 10_000
LENGTH = 60
"""Steps of one conversation; some are shorter."""


@pytest.fixture(autouse=True)
def _little_to_look_through() -> Iterator[None]:
    """Every conversation ends with a look for what it has left behind; what all other tests have loaded, hundreds of
    megabytes of it, need not be looked through each time."""
    gc.collect()
    gc.freeze()
    yield
    gc.unfreeze()


@pytest.mark.timeout(600)  # it only computes, which may take a busy machine this long
def test_ten_thousand_random_steps_break_no_rule_of_interruption() -> None:
    counts.clear()
    while counts["steps"] < STEPS:
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
    assert counts["pauses"] > 20, counts
    assert counts["added"] > 20, counts
    for outcome in ("ok", "failed", "interrupted", "uncertain"):
        assert counts[f"actions {outcome}"] > 20, counts
