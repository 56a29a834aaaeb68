"""The three ways into a graph, each with what has to run for it and with a peer behind it.

All of them stay on this machine: ROS discovers on loopback only, and bridge and router listen on 127.0.0.1.
"""

from __future__ import annotations

import socket
import sys
from pathlib import Path
from typing import Protocol

from engine.ros.door import Door
from engine.ros.opening import open_door
from tests.ros import environment
from tests.ros.lines import Program
from tests.ros.peers import DoorPeer, Peer, RosPeer
from tests.ros.remote import RemoteDoor
from tests.rosbridge import free_port
from tests.zenoh_router import Router


class Way(Protocol):
    """One of them, running."""

    name: str
    peer: Peer

    def open(self) -> Door:
        """A new door."""
        ...

    def new_peer(self) -> None:
        """Another peer, in place of one that has died."""
        ...

    def cut(self) -> None:
        """Kill what is between the door and the graph."""
        ...

    def mend(self) -> None:
        """Start it again."""
        ...

    def close(self) -> None: ...


class ByRclpy:
    """Nothing is between: the door is a node itself, in the Python that has rclpy."""

    name = "rclpy"

    def __init__(self) -> None:
        self._surroundings = environment.surroundings(free_domain())
        self.new_peer()

    def open(self) -> Door:
        return RemoteDoor("rclpy", environment.PYTHON, self._surroundings)

    def new_peer(self) -> None:
        self.peer: Peer = RosPeer(environment.PYTHON, self._surroundings)

    def cut(self) -> None:
        raise NotImplementedError

    def mend(self) -> None:
        raise NotImplementedError

    def close(self) -> None:
        self.peer.close()


class ByRosbridge:
    """A published rosbridge is between, and rosapi beside it."""

    name = "rosbridge"

    def __init__(self) -> None:
        self.surroundings = environment.surroundings(free_domain())
        self._port = free_port()
        self._rosapi = self._start("rosapi")
        self.mend()
        self.new_peer()

    @property
    def address(self) -> str:
        """As a setting writes it."""
        return f"ws://127.0.0.1:{self._port}"

    def open(self) -> Door:
        return open_door(self.address)

    def new_peer(self) -> None:
        self.peer: Peer = RosPeer(environment.PYTHON, self.surroundings)

    def cut(self) -> None:
        self._bridge.kill()

    def mend(self) -> None:
        self._bridge = self._start("websocket", str(self._port))

    def close(self) -> None:
        self.peer.close()
        self._bridge.kill()
        self._rosapi.kill()

    def _start(self, *what: str) -> Program:
        suite = environment.bridge()
        assert suite is not None
        command: list[str | Path] = [environment.PYTHON, "-m", "tests.ros.bridge", suite, *what]
        return Program(command, self.surroundings, None)


class ByZenoh:
    """A router of zenoh is between."""

    name = "zenoh"

    def __init__(self) -> None:
        self._router = Router()
        self._surroundings = environment.surroundings(0)
        self.mend()
        self.new_peer()

    def open(self) -> Door:
        return open_door(self._door)

    def new_peer(self) -> None:
        self.peer: Peer = DoorPeer(RemoteDoor(self._door, Path(sys.executable), self._surroundings))

    def cut(self) -> None:
        self._router.kill()

    def mend(self) -> None:
        self._router.start()

    def close(self) -> None:
        self.peer.close()
        self._router.kill()

    @property
    def _door(self) -> str:
        return f"zenoh://127.0.0.1:{self._router.port}"


def free_domain() -> int:
    """A ROS domain in which there is no node yet, by the ports of UDP that its nodes would have (source: the DDS-RTPS
    standard, 9.6.1.1)."""
    for domain in range(20, 100):
        if all(_is_free(7410 + 250 * domain + 2 * participant) for participant in range(12)):
            return domain
    raise AssertionError("there are nodes in all domains")


def _is_free(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
        return True
