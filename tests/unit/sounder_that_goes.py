"""A sounder whose device goes at once: it wants a block, says what happened, and ends before it gets any."""

from __future__ import annotations

import socket
import sys
from typing import Final

from engine.audio.sounder import SOUGHT, Failed, Opened, Wanted
from engine.messages import packed

GONE: Final = "The loudspeaker is gone."

if __name__ == "__main__":
    with socket.socket(fileno=int(sys.argv[1].removeprefix("--link="))) as link:
        sys.stderr.write("a driver's own words\n")
        for report in (Opened("loudspeaker", 16_000), Wanted(0.0), Failed(GONE, SOUGHT)):
            link.sendall(packed(report))
