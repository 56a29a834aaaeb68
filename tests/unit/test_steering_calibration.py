"""How much a robot pulls to a side, by drives ahead and back."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from engine.robot.calibration.steering import Drive, pull_of
from engine.robot.description import Description, described


def driven(pull: float, drift: float = 0.0) -> tuple[Drive, Drive]:
    """A metre ahead and one back, on which a robot turns by ``pull`` and its gyroscope drifts by ``drift``, rad."""
    return Drive(1.0, pull + drift), Drive(-1.0, -pull + drift)


def test_the_pull_is_the_turn_over_the_way() -> None:
    found = pull_of([driven(0.05), driven(0.07), driven(0.06)])
    assert found.mean == pytest.approx(0.06)
    assert found.spread == pytest.approx(0.01)
    assert pull_of([(Drive(0.5, 0.02), Drive(-0.5, -0.02))] * 2).mean == pytest.approx(0.04)


def test_a_gyroscope_that_drifts_is_no_pull() -> None:
    assert pull_of([driven(0.0, drift=0.03), driven(0.0, drift=0.02)]).mean == pytest.approx(0)


def test_a_trim_has_bounds_and_is_none_where_nothing_is_said() -> None:
    x3 = described("x3")
    assert x3.trim == 0
    with pytest.raises(ValidationError, match="trim"):
        Description.model_validate({**x3.model_dump(), "trim": 0.6})
