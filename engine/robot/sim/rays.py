"""The camera without a graphics library: one ray per pixel, cast in the simulation, with simple shading.

``mj_multiRay`` gives distance, geom and normal of what every pixel shows. Colour comes from the geom or its texture;
the light is that of the scene, a sun and a lamp on the camera, as OpenGL would reckon it without shadows. That is all
a colour detector or a tag reader needs. What cannot be in view is left out, and the rays are shared by two threads.
"""

from __future__ import annotations

import copy
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from engine.robot.camera import Lens
from engine.robot.sim.body import CAMERA
from engine.robot.sim.textures import UPRIGHT_FACE

CAMERA_RANGE = 12.0
"""m, along a ray."""
SKY = (196, 206, 220)
OUT_OF_VIEW = 5
"""A geom group that no scene uses, and no camera sees."""
_GROUPS = np.array([1, 1, 1, 1, 1, 0], dtype=np.uint8)  # which ones the rays meet


@dataclass(frozen=True, slots=True, eq=False)
class Exposure:
    """What a camera catches: see :class:`engine.robot.camera.Picture` for the shapes and units."""

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    labels: NDArray[np.int32] | None  # geom ids, −1 for none


class View:
    """Keeps a camera from what cannot be in its picture: most of a house, which takes most of the time."""

    def __init__(self, model: Any, lens: Lens) -> None:
        self._model = model
        self._edges = np.array([lens.width / 2 / lens.fx, lens.height / 2 / lens.fy])
        # A plane has no radius: it may be anywhere.
        self._radii = np.where(model.geom_rbound > 0, model.geom_rbound, np.inf)
        self._groups = model.geom_group.copy()

    def narrow(self, data: Any, position: NDArray[np.float64], axes: NDArray[np.float64]) -> None:
        """Put into the group ``OUT_OF_VIEW`` all whose sphere does not meet the pyramid of sight; ``axes`` are those of
        the camera, which looks along −z."""
        middles = (data.geom_xpos - position) @ axes
        ahead = -middles[:, 2]
        aside = (np.abs(middles[:, :2]) - self._edges * ahead[:, None]) / np.sqrt(1 + self._edges**2)
        in_view = (ahead > -self._radii) & (aside < self._radii[:, None]).all(axis=1)
        self._model.geom_group[:] = np.where(in_view, self._groups, OUT_OF_VIEW)

    def widen(self) -> None:
        """Put everything back into its group."""
        self._model.geom_group[:] = self._groups


class RayCamera:
    """Takes pictures of a model through its camera; the state is brought along by whoever asks."""

    def __init__(self, model: Any, lens: Lens) -> None:
        self._model = model = copy.copy(model)  # a model that collides needs its bounding volumes as they are
        _widen(model)
        self._lens = lens
        self._camera = model.camera(CAMERA).id
        grid = lens.grid()
        self._rays = grid * np.array([1.0, -1.0, -1.0])  # MuJoCo's cameras look along −z, with y up
        self._count = len(grid)
        self._geoms = np.empty(self._count, dtype=np.int32)
        self._distances = np.empty(self._count)
        self._normals = np.empty((self._count, 3))
        self._second = ThreadPoolExecutor(1, thread_name_prefix="rays")
        self._view = View(model, lens)
        self._colours = _colours(model)
        self._textures = _textures(model)

    def take(self, data: Any, *, labels: bool = True) -> Exposure:
        """A picture of ``data``, whose positions must be up to date (``mj_kinematics``, ``mj_camlight``)."""
        lens = self._lens
        position, axes = data.cam_xpos[self._camera], data.cam_xmat[self._camera].reshape(3, 3)
        directions = self._rays @ axes.T
        self._view.narrow(data, position, axes)
        half = self._count // 2
        other = self._second.submit(self._cast, data, position, directions, slice(0, half))
        self._cast(data, position, directions, slice(half, self._count))
        other.result()
        self._view.widen()
        # The rays have z = 1, so the distance in lengths of the ray is the depth along the line of sight.
        hit = self._geoms >= 0
        depth = np.where(hit, self._distances, np.inf)
        colours = np.where(hit[:, None], self._colours[self._geoms], np.array(SKY))
        points = position + directions * np.where(hit, self._distances, 0.0)[:, None]
        self._paint(data, colours, points, depth, axes[:, 2])
        colours[hit] *= self._light(axes[:, 2])[hit]
        shape = (lens.height, lens.width)
        return Exposure(
            np.clip(colours, 0, 255).astype(np.uint8).reshape(*shape, 3),
            depth.astype(np.float32).reshape(shape),
            self._geoms.reshape(shape).copy() if labels else None,
        )

    def _cast(self, data: Any, position: NDArray[np.float64], directions: NDArray[np.float64], part: slice) -> None:
        mujoco.mj_multiRay(
            self._model,
            data,
            position,
            directions[part].reshape(-1),
            _GROUPS,
            True,
            -1,
            self._geoms[part],
            self._distances[part],
            self._normals[part].reshape(-1),
            part.stop - part.start,
            CAMERA_RANGE,
        )

    def _light(self, towards_lamp: NDArray[np.float64]) -> NDArray[np.float64]:
        """What falls on every pixel, by colour: ambient light, the lamp on the camera and the scene's own lights, which
        all shine in one direction each."""
        model = self._model
        lamp = model.vis.headlight
        light: NDArray[np.float64] = lamp.ambient + np.outer(np.clip(self._normals @ towards_lamp, 0, 1), lamp.diffuse)
        for direction, diffuse in zip(model.light_dir, model.light_diffuse, strict=True):
            light += np.outer(np.clip(self._normals @ -direction, 0, 1), diffuse)
        return light.clip(max=1.0)

    def _paint(
        self,
        data: Any,
        colours: NDArray[np.float64],
        points: NDArray[np.float64],
        depth: NDArray[np.float64],
        ahead: NDArray[np.float64],
    ) -> None:
        """Put the pictures of textured boxes on what shows them. All six faces carry the same one, upright."""
        for geom, levels in self._textures.items():
            shown = np.flatnonzero(self._geoms == geom)
            if not len(shown):
                continue
            axes, half = data.geom_xmat[geom].reshape(3, 3), self._model.geom_size[geom]
            local = (points[shown] - data.geom_xpos[geom]) @ axes / half
            face = np.abs(local).argmax(axis=1)
            each = np.arange(len(shown))
            side = np.sign(local[each, face])
            x, y, z = local.T
            right = np.choose(face, (side * y, -side * x, x))
            up = np.choose(face, (z, z, side * y))
            # What a pixel covers of the face, in pixels of the finest picture; a slant stretches it one way.
            slant = np.clip(np.abs(self._normals[shown] @ ahead), 0.1, 1)
            covered = depth[shown] / self._lens.fx / np.sqrt(slant) * len(levels[0]) / (2 * half.max())
            level = np.clip(np.rint(np.log2(covered)), 0, len(levels) - 1)
            for index, picture in enumerate(levels):
                here = np.flatnonzero(level == index)
                colours[shown[here]] = _sample(picture, (1 + right[here]) / 2, (1 - up[here]) / 2)


def _sample(picture: NDArray[np.float64], right: NDArray[np.float64], down: NDArray[np.float64]) -> NDArray[np.float64]:
    """Colours at places on a picture, 0…1 from its upper left corner, between the nearest four pixels."""
    last = len(picture) - 1
    column, row = np.clip(right * len(picture) - 0.5, 0, last), np.clip(down * len(picture) - 0.5, 0, last)
    left, top = np.minimum(column.astype(int), last - 1), np.minimum(row.astype(int), last - 1)
    u, v = (column - left)[:, None], (row - top)[:, None]
    upper = picture[top, left] * (1 - u) + picture[top, left + 1] * u
    lower = picture[top + 1, left] * (1 - u) + picture[top + 1, left + 1] * u
    found: NDArray[np.float64] = upper * (1 - v) + lower * v
    return found


def _widen(model: Any) -> None:
    """Let the bounding volume of every body hold all of its geoms. MuJoCo has left out those that cannot collide, but
    ``mj_multiRay`` casts no ray at a body past its volume: bottles would have no caps. It also takes the middle of a
    volume as if the body were not turned, so the volumes are made to have theirs where the body's is: people who look
    west would have no hand to point with."""
    for body in np.flatnonzero(model.body_bvhnum):
        axes = _axes(model.body_iquat[body])
        reach = np.zeros(3)
        for geom in np.flatnonzero(model.geom_bodyid == body):
            turned = axes.T @ _axes(model.geom_quat[geom])
            middle = axes.T @ (model.geom_pos[geom] - model.body_ipos[body]) + turned @ model.geom_aabb[geom, :3]
            half = np.abs(turned) @ model.geom_aabb[geom, 3:]
            reach = np.maximum(reach, np.abs(middle) + half)
        model.bvh_aabb[model.body_bvhadr[body]] = (0, 0, 0, *reach)


def _axes(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    found = np.empty(9)
    mujoco.mju_quat2Mat(found, quaternion)
    return found.reshape(3, 3)


def _colours(model: Any) -> NDArray[np.float64]:
    """Of every geom, 0…255, shape (n, 3); what carries a flat texture has its mean colour."""
    found: NDArray[np.float64] = model.geom_rgba[:, :3] * 255.0
    for geom in range(model.ngeom):
        if (picture := _picture(model, geom, mujoco.mjtTexture.mjTEXTURE_2D)) is not None:
            found[geom] = picture.reshape(-1, 3).mean(axis=0)
    return found


def _textures(model: Any) -> dict[int, list[NDArray[np.float64]]]:
    """The upright face of the cube textures, by geom: the picture, and the same in a half, a quarter… of its size."""
    found = {}
    for geom in range(model.ngeom):
        if (picture := _picture(model, geom, mujoco.mjtTexture.mjTEXTURE_CUBE)) is not None:
            size = picture.shape[1]
            levels = [picture[UPRIGHT_FACE * size : (UPRIGHT_FACE + 1) * size]]
            while (size := len(levels[-1])) % 2 == 0 and size > 4:
                levels.append(levels[-1].reshape(size // 2, 2, size // 2, 2, 3).mean(axis=(1, 3)))
            found[geom] = levels
    return found


def _picture(model: Any, geom: int, kind: Any) -> NDArray[np.float64] | None:
    """The texture of a geom if it has one of this kind: rows, columns, RGB."""
    material = model.geom_matid[geom]
    if material < 0:
        return None
    texture = model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB]
    if texture < 0 or model.tex_type[texture] != kind:
        return None
    height, width, channels = (
        int(model.tex_height[texture]),
        int(model.tex_width[texture]),
        int(model.tex_nchannel[texture]),
    )
    start = int(model.tex_adr[texture])
    flat = model.tex_data[start : start + height * width * channels]
    pixels: NDArray[np.float64] = flat.reshape(height, width, channels)[:, :, :3].astype(np.float64)
    return pixels
