"""A map from elsewhere: ``map.pgm`` with the YAML file beside it, as Nav2 and ROS 1 save it.

A pixel is a cell; dark ones are occupied, light ones free, and grey ones unknown, which nobody drives into. Cell [0, 0]
of the map is the lower left pixel. (Source: https://docs.nav2.org, *map_server*.)
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine import yaml_file
from engine.errors import SceneError
from engine.robot.floor_map import FloorMap
from engine.yaml_file import BadFile, read_bytes

UNKNOWN = 205
"""What both save where nothing was seen. Under Nav2's own ``free_thresh`` it would count as free when it is read."""
MOST_BYTES = 64_000_000
MOST_CELLS = 16_000_000
"""Of a map that is read: 200 m × 200 m at 5 cm."""


class _Saved(BaseModel):
    """The YAML file; what else stands there means nothing here."""

    model_config = ConfigDict(allow_inf_nan=False)

    image: str
    resolution: float = Field(gt=0.005, le=1)
    origin: tuple[float, float, float]
    negate: bool = False
    occupied_thresh: float = Field(default=0.65, gt=0, lt=1)
    free_thresh: float = Field(default=0.196, ge=0, lt=1)
    mode: Literal["trinary", "scale", "raw"] = "trinary"


def read_map(path: Path) -> FloorMap:
    """Read the map that this YAML file describes. Raises :class:`SceneError` that names the file and the key."""
    hint = "robot.map names the YAML file of a map as Nav2 saves it (ros2 run nav2_map_server map_saver_cli)."
    try:
        saved = _Saved.model_validate(yaml_file.read(path))
    except FileNotFoundError as error:
        raise SceneError(f"The map {path} cannot be read: there is none.", hint=hint) from error
    except BadFile as error:
        raise SceneError(f"The map {path} cannot be read: {error}.", hint=hint) from error
    except ValidationError as error:
        fault = error.errors()[0]
        key = ".".join(map(str, fault["loc"])) or "the file"
        raise SceneError(f"The map {path} is wrong: {key}: {fault['msg']}.", hint=hint) from error
    x, y, yaw = saved.origin
    if yaw:
        turned = f"The map {path} is turned by {math.degrees(yaw):.3g}° (origin)."
        raise SceneError(turned, hint="Save it with an origin of yaw 0.")
    if saved.mode == "raw":
        raise SceneError(f"The map {path} is saved raw (mode).", hint="Save it with --mode trinary.")
    grey = _picture(path.parent / saved.image)
    dark = grey / 255.0 if saved.negate else 1.0 - grey / 255.0
    taken = (dark > saved.free_thresh) | (grey == UNKNOWN)
    return FloorMap(saved.resolution, (x, y), np.flipud(taken).copy())


def _picture(path: Path) -> np.ndarray:
    """Grey values 0…255, shape (rows, columns)."""
    import cv2

    try:
        data = np.frombuffer(read_bytes(path, MOST_BYTES), dtype=np.uint8)
    except FileNotFoundError as error:
        raise SceneError(f"The picture of the map, {path}, cannot be read: there is none.") from error
    except BadFile as error:
        raise SceneError(f"The picture of the map, {path}, cannot be read: {error}.") from error
    try:
        grey = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    except cv2.error:
        grey = None
    if grey is None:
        raise SceneError(f"The picture of the map, {path}, is none that can be read.", hint="PGM and PNG can.")
    if grey.size > MOST_CELLS:
        raise SceneError(f"The map {path} has {grey.size} cells; {MOST_CELLS} are read at most.")
    found: np.ndarray = grey
    return found
