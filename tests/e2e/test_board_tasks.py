"""Tasks of the suite, done through the frames of an emulated board: driving, the arm, and a camera on it."""

from __future__ import annotations

import pytest

from tests.eval.runner import run
from tests.eval.tasks import tasks, trial


@pytest.mark.parametrize("kind", ["fetch", "follow a line", "go and come back"])
def test_a_task_is_done_through_a_board(kind: str) -> None:
    verdict = run(trial(kind, tasks()[kind], seed=0), through="board")
    assert verdict.ok, verdict.reason
