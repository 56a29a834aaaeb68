"""Who takes part in a ROS 2 graph over zenoh, from the liveliness tokens of all peers."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from typing import Final

from engine.ros.door import Graph
from engine.ros.zenoh.wire import Entity, Kind

SEND_GOAL: Final = "/_action/send_goal"
"""What the name of the service ends with that takes an action's goals."""

_HIDDEN: Final = "/_action/"  # in the names of an action's topics and services
_PARTNERS: Final[Mapping[Kind, Kind]] = {"MP": "MS", "MS": "MP", "SS": "SC", "SC": "SS"}
_DOES: Final[Mapping[Kind, str]] = {"MP": "publishes", "MS": "subscribes to", "SS": "serves", "SC": "calls"}


class Tokens:
    """The tokens that there are now. Thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._by_name: dict[str, dict[str, Entity]] = {}

    def add(self, token: str) -> str:
        """Returns the name of the topic or service that it is about; empty where it makes no sense, or is a node's."""
        entity = Entity.parse(token)
        if entity is None or entity.endpoint is None:
            return ""
        with self._lock:
            self._by_name.setdefault(entity.endpoint.name, {})[token] = entity
        return entity.endpoint.name

    def remove(self, token: str) -> None:
        entity = Entity.parse(token)
        if entity is not None and entity.endpoint is not None:
            with self._lock:
                self._by_name.get(entity.endpoint.name, {}).pop(token, None)

    def all(self) -> list[Entity]:
        with self._lock:
            return [entity for entities in self._by_name.values() for entity in entities.values()]

    def of(self, name: str, kind: Kind) -> list[Entity]:
        """All that take part in one topic or service in one way."""
        with self._lock:
            return [entity for entity in self._by_name.get(name, {}).values() if entity.kind == kind]

    def mismatches(self, ours: Iterable[Entity]) -> dict[str, str]:
        """Topics, services and actions of ours in which a peer takes part with another type, and how, in words."""
        found: dict[str, str] = {}
        for entity in ours:
            if entity.endpoint is None:
                continue
            for peer in self.of(entity.endpoint.name, _PARTNERS[entity.kind]):
                if words := mismatch(entity, peer):
                    found[entity.endpoint.name.partition(_HIDDEN)[0]] = words
        return found


def mismatch(ours: Entity, theirs: Entity) -> str:
    """How the types of two differ that have the same name, in words; empty where they do not."""
    here, there = ours.endpoint, theirs.endpoint
    if here is None or there is None or (here.type, here.hash) == (there.type, there.hash):
        return ""
    told = f"{theirs.node} {_DOES[theirs.kind]} it as {there.type}"
    if here.type != there.type:
        return f"{told}, and here it is {here.type}"
    return f"{told}, but with other fields than are known here (hash …{there.hash[-8:]}, here …{here.hash[-8:]})"


def graph_of(entities: Iterable[Entity], session: str) -> Graph:
    """What there is, by the tokens of all. That somebody of session ``session`` looks for a topic or a service does not
    make it be there."""
    topics: dict[str, str] = {}
    services: dict[str, str] = {}
    actions: dict[str, str] = {}
    for entity in entities:
        if entity.endpoint is None:
            continue
        name, type = entity.endpoint.name, entity.endpoint.type
        if entity.kind == "SS" and name.endswith(SEND_GOAL):
            actions[name.removesuffix(SEND_GOAL)] = type.removesuffix("_SendGoal")
        elif _HIDDEN in name:
            continue
        elif entity.kind == "SS":
            services[name] = type
        elif entity.kind == "MP" or (entity.kind == "MS" and entity.session != session):
            topics[name] = type
    return Graph(topics, services, actions)
