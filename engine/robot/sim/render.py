"""The camera with OpenGL: MuJoCo's own renderer, off screen, through EGL or OSMesa.

mujoco takes that of the two which the environment names (``MUJOCO_GL``) when it is loaded. Colour and depth come from
one pass over the scene. Light, colours and what is invisible are those of the scene, as for rays; shadows are off.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from mujoco.gl_context import GLContext
from numpy.typing import NDArray

from engine.robot.camera import Lens
from engine.robot.sim.body import CAMERA
from engine.robot.sim.rays import CAMERA_RANGE, OUT_OF_VIEW, Exposure, View

_MAX_GEOMS = 4000
_OFF = (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION)
_BY_NUMBER = (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR)


class GlCamera:
    """Takes pictures of a model through its camera, in the thread that made it. Whatever a missing or broken graphics
    library raises comes out of the constructor."""

    def __init__(self, model: Any, lens: Lens) -> None:
        self._model = model
        self._lens = lens
        model.vis.global_.offwidth, model.vis.global_.offheight = lens.width, lens.height
        model.vis.quality.offsamples = 0  # several samples a pixel would each have a depth of their own
        model.vis.quality.numquads = 1  # lights that shine in one direction make a flat side the same all over
        self._gl = GLContext(lens.width, lens.height)
        self._gl.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._scene = mujoco.MjvScene(model, _MAX_GEOMS)
        for flag in _OFF:
            self._scene.flags[flag] = False
        self._options = mujoco.MjvOption()
        self._options.geomgroup[OUT_OF_VIEW] = False
        self._in_view = View(model, lens)
        self._view = mujoco.MjvCamera()
        self._view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._view.fixedcamid = model.camera(CAMERA).id
        self._frame = mujoco.MjrRect(0, 0, lens.width, lens.height)
        self._rgb = np.empty((lens.height, lens.width, 3), dtype=np.uint8)
        self._depth = np.empty((lens.height, lens.width), dtype=np.float32)
        # Which parts of a ray are within range, as depth along the line of sight.
        lengths = np.linalg.norm(lens.grid(), axis=1).reshape(lens.height, lens.width)
        self._reach = CAMERA_RANGE / lengths

    def take(self, data: Any, *, labels: bool) -> Exposure:
        """A picture of ``data``, whose positions must be up to date (``mj_kinematics``, ``mj_camlight``)."""
        everything, camera = mujoco.mjtCatBit.mjCAT_ALL, self._view.fixedcamid
        self._in_view.narrow(data, data.cam_xpos[camera], data.cam_xmat[camera].reshape(3, 3))
        mujoco.mjv_updateScene(self._model, data, self._options, None, self._view, everything, self._scene)
        self._render(self._depth)
        rgb = np.flipud(self._rgb).copy()  # OpenGL counts rows from the bottom
        depth = self._metres(np.flipud(self._depth))
        return Exposure(rgb, depth, self._labels(depth) if labels else None)

    def _render(self, depth: NDArray[np.float32] | None) -> None:
        mujoco.mjr_render(self._frame, self._scene, self._context)
        mujoco.mjr_readPixels(self._rgb, depth, self._frame, self._context)

    def _metres(self, buffer: NDArray[np.float32]) -> NDArray[np.float32]:
        """From the depth buffer, which is 1 at the near plane and 0 at the far one."""
        extent, clip = self._model.stat.extent, self._model.vis.map
        near, far = clip.znear * extent, clip.zfar * extent
        depth = near * far / (near + buffer.astype(np.float64) * (far - near))
        found: NDArray[np.float32] = np.where(depth < self._reach, depth, np.inf).astype(np.float32)
        return found

    def _labels(self, depth: NDArray[np.float32]) -> NDArray[np.int32]:
        """The geoms in a second pass, in which every one of them has its number for a colour."""
        for flag in _BY_NUMBER:
            self._scene.flags[flag] = True
        self._render(None)
        for flag in _BY_NUMBER:
            self._scene.flags[flag] = False
        colours = np.flipud(self._rgb).astype(np.int32)
        numbers = colours[:, :, 0] + (colours[:, :, 1] << 8) + (colours[:, :, 2] << 16)
        geoms = np.full(self._scene.ngeom + 1, -1, dtype=np.int32)
        for geom in self._scene.geoms[: self._scene.ngeom]:
            if geom.segid >= 0 and geom.objtype == mujoco.mjtObj.mjOBJ_GEOM:
                geoms[geom.segid + 1] = geom.objid
        shown = np.isfinite(depth) & (numbers < len(geoms))  # the sky has a colour that is no number
        found: NDArray[np.int32] = np.where(shown, geoms[np.where(shown, numbers, 0)], -1).astype(np.int32)
        return found
