"""A picture for terminals with kitty's graphics protocol: PNG, as large as so many characters.

The terminal scales it, so the size of a character does not matter, and keeps it until it is told to remove it. Each is
told to answer nothing. (https://sw.kovidgoyal.net/kitty/graphics-protocol/)
"""

from __future__ import annotations

import base64
import struct
import zlib
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from tui.graphics.pixels import Indexed
    from tui.graphics.tiles import Extent

MOST_COLOURS: Final = 256
CHUNK: Final = 4096
"""Most characters of a picture in one sequence."""
_LEVEL: Final = 9


def shown(picture: Indexed, size: Extent, number: int) -> str:
    """Shows the picture with its upper left corner at the cursor, which stays there. ``number`` tells it from others;
    one with the same number is replaced."""
    data = base64.standard_b64encode(png(picture)).decode()
    chunks = [data[at : at + CHUNK] for at in range(0, len(data), CHUNK)]
    about = f"a=T,f=100,i={number},p=1,q=2,C=1,c={size.columns},r={size.rows},"
    return "".join(
        f"\x1b_G{'' if at else about}m={int(at < len(chunks) - 1)};{chunk}\x1b\\" for at, chunk in enumerate(chunks)
    )


def removed(number: int) -> str:
    """Takes the picture away, and what the terminal keeps of it."""
    return f"\x1b_Ga=d,d=I,i={number},q=2\x1b\\"


def png(picture: Indexed) -> bytes:
    """The picture as a PNG file with a palette."""
    height, width = picture.pixels.shape
    lines = b"".join(b"\0" + row.tobytes() for row in picture.pixels)  # no filter: colours are names
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in (
            (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)),
            (b"PLTE", picture.colours.tobytes()),
            (b"IDAT", zlib.compress(lines, _LEVEL)),
            (b"IEND", b""),
        )
    )
