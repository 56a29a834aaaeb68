"""PortAudio, for the two processes that use it: the recorder (``engine.audio.recorder``) and the sounder.

It looks for devices once, when it is initialised, and terminating it closes every stream of its process: whoever waits
for a device has a process of its own, and looks again in it. Neither PortAudio nor, in a way that all systems share,
anybody else tells of new devices.
"""

from __future__ import annotations

import contextlib
import os
import select
import shutil
import socket
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, Literal

from engine.errors import DeviceError

LOOK_S, SELDOM_S = 1.0, 3.0
"""Between two looks for a device that is not there, s: at first, and once it has been away for long. A look costs
PortAudio up to 20 ms of work."""

LOOKS: Final = 60
"""After so many looks it has been away for long."""

_OTHERS_S: Final = 2.0
"""How long it is waited for other processes that initialise PortAudio, s; each takes 0.2, unless a driver hangs."""
_MEMORY: Final = Path("/dev/shm")  # noqa: S108 - not ours
"""Where JACK's server, its clients and its data base meet (jack2 on Linux)."""


class Unusable(DeviceError):
    """No device of the kind can be used here, whatever is plugged in."""


def load(no_library: Unusable, no_package: Unusable) -> Any:
    """The module sounddevice. Raises one of the two where it is not to be had."""
    try:
        with _alone():
            import sounddevice
    except OSError as error:
        raise no_library from error
    except ImportError as error:
        raise no_package from error
    return sounddevice


@contextmanager
def _alone() -> Iterator[None]:
    """For initialising PortAudio, which asks JACK for a server.

    JACK's library opens a data base for that, and a process that is killed meanwhile leaves it locked: everybody after
    it would wait for ever. So it is taken away first; by one process at a time, because taking it away from somebody
    who opens it would break it.
    """
    if sys.platform != "linux":
        yield
        return
    import fcntl

    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):  # somebody else's, or no room: without it then
            flags = os.O_CREAT | os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC
            lock = os.open(f"{tempfile.gettempdir()}/sayso-portaudio-{os.getuid()}.lock", flags, 0o600)
            stack.callback(os.close, lock)
            until = time.monotonic() + _OTHERS_S
            while time.monotonic() < until:
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    time.sleep(0.02)
                else:
                    unlock_jack()
                    break
        yield


def unlock_jack(memory: Path = _MEMORY) -> None:
    """Take away JACK's data base (Berkeley DB, ``jack_db-UID``) where no server runs: it holds nothing then."""
    user = os.getuid()
    if not any(_answers(file) for file in memory.glob(f"jack_*_{user}_*")):
        shutil.rmtree(memory / f"jack_db-{user}", ignore_errors=True)


def _answers(file: Path) -> bool:
    """Whether this is the socket of a server that runs."""
    with socket.socket(socket.AF_UNIX) as link:
        try:
            link.connect(str(file))
        except OSError:
            return False
    return True


def leave_with(link: socket.socket) -> None:
    """End this process when the other end of ``link`` is closed, also while PortAudio or a driver hangs."""
    threading.Thread(target=_follow, args=(link.fileno(),), name="end of the link", daemon=True).start()


def _follow(link: int) -> None:
    if sys.platform == "darwin":  # its poll sees no end unless it is to see all that comes as well
        end = select.kqueue()
        end.control([select.kevent(link, select.KQ_FILTER_READ, select.KQ_EV_ADD | select.KQ_EV_CLEAR)], 0)
        while not any(event.flags & select.KQ_EV_EOF for event in end.control(None, 1)):
            pass
    else:
        hang_up = select.poll()
        hang_up.register(link, 0)  # 0: nothing but the end
        hang_up.poll()
    os._exit(0)  # closing a stream whose driver has gone can hang; the kernel closes it as well


def choices(sounddevice: Any, kind: Literal["input", "output"], setting: str) -> str:
    """What ``setting`` could be, as a sentence; empty where there is nothing."""
    names = [
        f"{index}: {device['name']}"
        for index, device in enumerate(sounddevice.query_devices())
        if device[f"max_{kind}_channels"] > 0
    ]
    return f"Set {setting} to one of: {'; '.join(names)}." if names else ""


def look_again(look: int) -> None:
    """Wait a little, then forget which devices there were, so that the next look sees those that are there now; ends
    every stream. ``look``: how many there were."""
    time.sleep(LOOK_S if look < LOOKS else SELDOM_S)
    sounddevice = sys.modules.get("sounddevice")
    if sounddevice is not None:
        sounddevice._terminate()  # private by name, yet documented, and there is no other way
        with _alone():
            sounddevice._initialize()
