"""Driving tasks of the suite, done by a robot behind a bridge of ROS 2: by velocities, and where it finds its way."""

from __future__ import annotations

import pytest

from tests.eval.runner import Through, run
from tests.eval.tasks import tasks, trial


@pytest.mark.parametrize(("kind", "through"), [("closed door", "ros"), ("way round something moved", "nav2")])
def test_a_driving_task_is_done_behind_a_bridge(kind: str, through: Through) -> None:
    verdict = run(trial(kind, tasks()[kind], seed=0), speed="real", through=through)
    assert verdict.ok, verdict.reason
