"""A few seconds from the microphone, for commands; one that is open and sends nothing is not waited for without end."""

from __future__ import annotations

import asyncio
from typing import Final

from engine.audio.microphone import Microphone
from engine.audio.satellite_microphone import SatelliteMicrophone
from engine.audio.source import FRAME_S, Frame
from engine.errors import DeviceError

PATIENCE_S: Final = 5.0
"""How much longer than it lasts a recording may take, s."""


async def recorded(microphone: Microphone | SatelliteMicrophone, seconds: float) -> list[Frame]:
    """What a microphone that is open hears from now on. Raises ``DeviceError``."""
    wanted, frames = round(seconds / FRAME_S), list[Frame]()
    try:
        async with asyncio.timeout(seconds + PATIENCE_S):
            async for frame in microphone:
                frames.append(frame)
                if len(frames) == wanted:
                    return frames
    except TimeoutError:
        pass  # it is told like one that has ended
    hint = "Is it muted, or does it wait for a wake word or a voice of its own? Let it stream all the time."
    raise DeviceError(f"{microphone.name} sent {len(frames) * FRAME_S:.1f} s of sound, of {seconds:g} s.", hint=hint)
