"""What the robot of the packaged settings can do, and the words of its house, as the engine tells them."""

from __future__ import annotations

from functools import cache

from config import load
from engine.offer import Offer, offered
from engine.planner.build import build_registry
from engine.planner.worlds.house import build_vocabulary


@cache
def offer() -> Offer:
    """Of the packaged scene."""
    settings = load()
    names = tuple(place.name for place in settings.places.values())
    return offered(build_registry(settings), build_vocabulary(settings), names)
