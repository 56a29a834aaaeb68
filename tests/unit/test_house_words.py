"""What the names of a house mean: its inventory in words of perception."""

from __future__ import annotations

import pytest

from engine.planner.worlds.house import _looks
from engine.robot.home import Thing

INVENTORY = (
    Thing("cup", "white cup", "tableware"), Thing("bowl", "blue cup", "tableware"), Thing("orange", "orange ball"),
    Thing("orange juice", "orange bottle"), Thing("ball", "red ball"), Thing("crowbar", "crowbar"),
)  # fmt: skip


@pytest.mark.parametrize(
    ("name", "looks"),
    [
        ("cup", "white cup"),  # and not the bowl, which is one as well
        ("bowl", "blue cup"),
        ("orange", "orange ball"),
        ("orange juice", "orange bottle"),
        ("ball", "red ball"),
        ("crowbar", ""),
    ],
)
def test_a_name_is_the_one_thing_that_is_called_so(name: str, looks: str) -> None:
    assert _looks(next(thing for thing in INVENTORY if thing.name == name), INVENTORY) == looks


def test_a_kind_of_which_there_is_one_is_any_of_it() -> None:
    """Its colour may look different in another light."""
    assert _looks(INVENTORY[0], INVENTORY[:1]) == "cup"
