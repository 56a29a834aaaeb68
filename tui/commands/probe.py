"""``sayso robot probe ros2``: what a robot of ROS 2 has, and a first description of it."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import yaml

from engine.errors import ExitCode, StorageError, UsageError
from tui.output import data, json_line, say

if TYPE_CHECKING:
    from config.schema import Settings
    from engine.robot.ros2.probing import GridMap

PROBE_S = 4.0
"""How long it is listened to, s."""


def robot_probe(settings: Settings, kind: str | None, name: str, *, json: bool = False) -> int:
    """Look what there is behind ``robot.door``, and write it down as the robot ``name``. Nothing moves. Raises
    ``UsageError``, ``DeviceError`` or ``StorageError``."""
    from config import paths
    from engine.robot.ros2.probing import probe
    from engine.ros.opening import FORMS, open_door

    if kind != "ros2":
        raise UsageError("Only a robot of ROS 2 tells what it has.", hint="sayso robot probe ros2")
    if not settings.robot.door:
        raise UsageError("robot.door does not say how to get to it.", hint=f"--set robot.door=…: {FORMS}.")
    if not name.isprintable() or not name or "/" in name or name.startswith("."):
        raise UsageError(f"{name!r} is no name for a robot.")
    target = paths().robots / f"{name}.yaml"
    there = target.with_name(f"{name}-map.yaml")
    for file in (target, there, there.with_suffix(".pgm")):
        if os.path.lexists(file):
            raise UsageError(f"{file} is there already.", hint="--as gives the new robot another name.")
    door = open_door(settings.robot.door)
    try:
        found = probe(door, PROBE_S)
    finally:
        door.close()
    remarks = "".join(f"# - {remark}\n" for remark in found.remarks)
    text = f"# To be looked through:\n{remarks}{yaml.safe_dump(found.description, sort_keys=False, allow_unicode=True)}"
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _write(target, text.encode())
        if found.map is not None:
            _write_map(found.map, there)
    except OSError as error:
        raise StorageError(f"{target.parent} cannot be written: {error.strerror}.") from error
    if json:
        about = {"file": str(target), "map": str(there) if found.map is not None else None}
        json_line({**about, "description": found.description, "remarks": found.remarks})
        return int(ExitCode.DONE)
    data(text.rstrip("\n"))
    if found.graph.why:
        say(f"sayso: {found.graph.why}: what has none of the usual names was not found.")
    say(f"sayso: this is in {target} now. Look it through, then:")
    chosen = ["robot.kind=ros2", f"robot.door={settings.robot.door}", f"robot.model={name}"]
    chosen += [f"robot.map={there}"] if found.map is not None else []
    say("  " + shlex.join(["sayso", *(word for setting in chosen for word in ("--set", setting))]))
    return int(ExitCode.DONE)


def _write_map(found: GridMap, target: Path) -> None:
    """As Nav2's map_saver does: dark where something stands, light where nothing does, grey where nobody knows."""
    grey = np.full(found.cells.shape, 205, np.uint8)
    grey[(found.cells >= 0) & (found.cells <= 25)] = 254
    grey[found.cells >= 65] = 0
    rows, columns = len(grey), len(grey[0])
    picture = target.with_suffix(".pgm")
    _write(picture, f"P5\n{columns} {rows}\n255\n".encode() + np.flipud(grey).tobytes())
    about = {"image": picture.name, "mode": "trinary", "resolution": found.resolution}
    about |= {"origin": [*found.origin, 0.0], "negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.196}
    _write(target, yaml.safe_dump(about, sort_keys=False).encode())


def _write(target: Path, data: bytes) -> None:
    """A new file; nothing that is there, and nothing that a link leads to, is written over."""
    with target.open("xb") as file:
        file.write(data)
