"""What of somebody shows: legs alone are no small person."""

from __future__ import annotations

import numpy as np
import pytest

from engine.perception import figure
from engine.perception.figure import Body


def legs(high: float) -> Body:
    """Two grey legs 1.5 m ahead, of which ``high`` m show below something that hides the rest."""
    z, y = np.meshgrid(
        np.arange(0.0, high, 0.02), np.concatenate((np.arange(-0.16, -0.02, 0.02), np.arange(0.04, 0.18, 0.02)))
    )
    z, y = z.ravel(), y.ravel()
    points = np.column_stack((np.full(len(z), 1.5), y, z))
    rows, columns = np.round((high - z) / 0.02).astype(int) + 20, np.round((y + 0.2) / 0.02).astype(int)
    hsv = np.tile((0.0, 0.0, 0.5), (len(z), 1))
    everywhere = np.zeros(len(z))
    return Body(points, everywhere, rows, columns, hsv, 0.02, False, False, np.ones(len(z), dtype=np.bool_))


@pytest.mark.parametrize("high", [0.5, 0.62, 0.8])
def test_legs_below_something_are_nobodys_shirt(high: float) -> None:
    body = legs(high)
    built = figure.build(body, None)
    assert figure.clothes(body, built) == (None, "grey")
    assert not built.measured
