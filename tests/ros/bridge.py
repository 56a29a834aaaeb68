"""The published rosbridge: ``.ros/bin/python -m tests.ros.bridge SUITE websocket PORT`` or ``… SUITE rosapi``, where
SUITE is a folder with rosbridge_server, rosbridge_library and rosapi. It is no wheel, so it is run from its sources.

rosapi uses a few functions of the command line tools of ROS, which are no wheels either. Those that it needs to tell
what is there stand below; what needs others fails.
"""

from __future__ import annotations

import os
import runpy
import sys
import threading
from pathlib import Path
from types import ModuleType
from typing import Any


def main(suite: Path, what: str, port: str = "") -> None:
    """Run one of its programs until standard input ends: it would outlive a test that is killed."""
    threading.Thread(target=lambda: (sys.stdin.read(), os._exit(0)), daemon=True).start()
    sys.path[:0] = [str(suite / name / "src") for name in ("rosbridge_server", "rosbridge_library", "rosapi")]
    sys.argv = [what, "--ros-args", "--disable-stdout-logs", "--disable-external-lib-logs"]
    if what == "rosapi":
        stand_in()
        runpy.run_path(str(suite / "rosapi/scripts/rosapi_node"), run_name="__main__")
        return
    sys.argv += ["-p", f"port:={port}", "-p", "address:=127.0.0.1", "-p", "retry_startup_delay:=0.2"]
    runpy.run_path(str(suite / "rosbridge_server/scripts/rosbridge_websocket.py"), run_name="__main__")


def stand_in() -> None:
    """Put those functions where rosapi imports them from."""

    def topics(*, node: Any, include_hidden_topics: bool = False) -> Any:
        return [known for known in node.get_topic_names_and_types() if include_hidden_topics or "/_" not in known[0]]

    def services(*, node: Any, include_hidden_services: bool = False) -> Any:
        return [
            known for known in node.get_service_names_and_types() if include_hidden_services or "/_" not in known[0]
        ]

    def names(known: Any) -> Any:
        return lambda **told: [name for name, _ in known(**told)]

    put("ros2topic.api", get_topic_names=names(topics), get_topic_names_and_types=topics)
    put("ros2service.api", get_service_names=names(services), get_service_names_and_types=services)
    node = ("get_node_names", "get_publisher_info", "get_service_server_info", "get_subscriber_info")
    put("ros2node.api", **dict.fromkeys(node, missing), get_absolute_node_name=lambda name: f"/{name.lstrip('/')}")
    put("ros2param.api", call_get_parameters=missing, call_set_parameters=missing)
    put("rosidl_runtime_py", get_interface_path=missing)


def put(name: str, **functions: Any) -> None:
    """Make a module."""
    parent, _, own = name.rpartition(".")
    module = sys.modules[name] = ModuleType(name)
    vars(module).update(functions)
    if parent:
        put(parent, **{own: module})


def missing(*told: Any, **named: Any) -> Any:
    raise NotImplementedError


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
