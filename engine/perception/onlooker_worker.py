"""The perception process: ``python -m engine.perception.onlooker_worker``, started by
:class:`engine.perception.onlooker.Onlooker`.

It understands one picture after the other until the engine goes. What goes wrong ends it, and is told with its last
words.
"""

from __future__ import annotations

import argparse
import contextlib
import signal
import sys
from multiprocessing.connection import Connection

from engine.perception.perceive import perceive
from engine.perception.sighting import Sighting, TagSighting
from engine.robot.camera import Picture
from engine.robot.floor_map import FloorMap

Asked = tuple[Picture, FloorMap | None]
"""What is to be understood, and what is fixed in the house, if that is not the same as the last time."""
Found = tuple[tuple[Sighting, ...], tuple[TagSighting, ...]]
"""The objects and the tags of a ``Sight``."""


def main(argv: list[str]) -> int:
    program = "python -m engine.perception.onlooker_worker"
    parser = argparse.ArgumentParser(prog=program, description="Internal to sayso.")
    parser.add_argument("--link", type=int, required=True, help="an inherited file descriptor")
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the engine's business
    link: Connection[Found, Asked] = Connection(parser.parse_args(argv).link)
    house: FloorMap | None = None
    with contextlib.suppress(EOFError, ConnectionError):
        while True:
            picture, other = link.recv()
            house = other or house
            assert house is not None, "it comes with the first picture"
            sight = perceive(picture, house)
            link.send((sight.objects, sight.tags))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
