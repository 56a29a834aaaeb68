"""A sound server of the test's own, whose default input is a microphone into which the test speaks.

PulseAudio without hardware: what is played to a null sink is what the sink's monitor, the default input, records.
PortAudio gets there by ALSA's ``default``, as it does on a desktop.
"""

from __future__ import annotations

import ctypes.util
import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

PROGRAMS = ("pulseaudio", "paplay", "pactl")
SINKS = ("voice", "loudspeaker")
"""What is played to the first is what the microphone hears; to the second, what the robot says for itself."""

LIMIT_S = 20


def missing() -> str:
    """What a real virtual microphone needs and this machine does not have; empty: nothing."""
    found = [name for name in PROGRAMS if shutil.which(name) is None]
    found += ["PortAudio"] if ctypes.util.find_library("portaudio") is None else []
    found += [] if any(Path("/usr/lib").glob("**/libasound_module_pcm_pulse.so")) else ["ALSA's plugin for PulseAudio"]
    return f"{', '.join(found)} missing: `make test-audio` as root installs it" if found else ""


class SoundServer:
    """PulseAudio with a microphone and a loudspeaker. Nothing of it is left after the block; others are not touched."""

    def __init__(self, folder: Path) -> None:
        """``folder`` is for its socket and its state; it must be short, empty and private."""
        self._folder = folder
        self._process: subprocess.Popen[bytes] | None = None
        self.environment = {
            "XDG_RUNTIME_DIR": str(folder),
            "PULSE_RUNTIME_PATH": str(folder),
            "PULSE_STATE_PATH": str(folder),
            "PULSE_SERVER": f"unix:{folder / 'native'}",
        }
        """With it a program uses this server."""

    def __enter__(self) -> SoundServer:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.kill()

    def start(self) -> None:
        """Start it; returns when it takes sound."""
        argv = ["pulseaudio", "--daemonize=no", "--exit-idle-time=-1", "--disallow-exit", "-n", "--use-pid-file=no"]
        argv += [f"--load=module-native-protocol-unix auth-anonymous=1 socket={self._folder / 'native'}"]
        # norewinds: or the sink would take two seconds of sound at a time
        argv += [f"--load=module-null-sink sink_name={sink} rate=16000 channels=1 norewinds=1" for sink in SINKS]
        self._process = subprocess.Popen(argv, env=os.environ | self.environment, stderr=subprocess.PIPE)
        self._until_ready()
        for kind, name in (("sink", "loudspeaker"), ("source", "voice.monitor")):
            assert self._ask(f"set-default-{kind}", name).returncode == 0

    def kill(self) -> None:
        """End it as a crash does."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.communicate()

    def freeze(self) -> None:
        """It hangs, until it is killed or goes on."""
        assert self._process is not None
        self._process.send_signal(signal.SIGSTOP)

    def go_on(self) -> None:
        assert self._process is not None
        self._process.send_signal(signal.SIGCONT)

    def play(self, sound: Path, *, volume: float = 1.0) -> None:
        """Say a recording into the microphone; returns when it has been said."""
        argv = ["paplay", "--device=voice", f"--volume={round(65536 * volume)}", str(sound)]
        subprocess.run(argv, env=os.environ | self.environment, check=True, timeout=LIMIT_S, capture_output=True)

    def _until_ready(self) -> None:
        end = time.monotonic() + LIMIT_S
        while self._ask("info").returncode:
            assert self._process is not None
            assert self._process.poll() is None, self._process.communicate()[1].decode()
            assert time.monotonic() < end, "the sound server did not start"
            time.sleep(0.02)  # it has no way to tell when it is ready

    def _ask(self, *words: str) -> subprocess.CompletedProcess[bytes]:
        argv = ["pactl", *words]
        return subprocess.run(argv, env=os.environ | self.environment, check=False, capture_output=True)
