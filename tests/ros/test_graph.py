"""What each door finds in the graph."""

from __future__ import annotations

import queue
import time

from engine.ros.door import Door, Graph
from tests.ros.conftest import LIMIT_S
from tests.ros.peers import FIBONACCI
from tests.ros.ways import Way


def test_the_graph_is_known(way: Way, door: Door) -> None:
    way.peer.publish("/peer/says", "std_msgs/msg/String", {"data": "here"})
    end = time.monotonic() + LIMIT_S
    while True:
        found: queue.SimpleQueue[Graph] = queue.SimpleQueue()
        door.graph(found.put)
        graph = found.get(timeout=LIMIT_S)
        if "/peer/says" in graph.topics or time.monotonic() > end:
            break
    assert not graph.why
    assert graph.topics["/peer/says"] == "std_msgs/msg/String"
    untold = "" if way.name == "rosbridge" else None  # rosapi lists services and actions without their types
    assert graph.services["/peer/set"] in ("std_srvs/srv/SetBool", untold)
    assert graph.actions["/peer/slow"] in (FIBONACCI, untold)
    assert not [name for name in (*graph.topics, *graph.services) if "_action/" in name]
