"""PortAudio, for the two processes that use it: the recorder (``engine.audio.recorder``) and the sounder.

It looks for devices once, when it is initialised, and terminating it closes every stream of its process: whoever waits
for a device has a process of its own, and looks again in it. Neither PortAudio nor, in a way that all systems share,
anybody else tells of new devices.
"""

from __future__ import annotations

import sys
import time
from typing import Any, Final, Literal

from engine.errors import DeviceError

LOOK_S, SELDOM_S = 1.0, 3.0
"""Between two looks for a device that is not there, s: at first, and once it has been away for long. A look costs
PortAudio up to 20 ms of work."""

LOOKS: Final = 60
"""After so many looks it has been away for long."""


class Unusable(DeviceError):
    """No device of the kind can be used here, whatever is plugged in."""


def load(no_library: Unusable, no_package: Unusable) -> Any:
    """The module sounddevice. Raises one of the two where it is not to be had."""
    try:
        import sounddevice
    except OSError as error:
        raise no_library from error
    except ImportError as error:
        raise no_package from error
    return sounddevice


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
        sounddevice._initialize()
