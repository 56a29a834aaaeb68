"""How the bytes of a keyboard are read, whichever terminal they come from."""

from __future__ import annotations

from typing import Final

ESCAPE: Final = b"\x1b"
"""The escape key, and the beginning of every escape sequence."""
READ_BYTES: Final = 4096
IDLE_S: Final = 0.1
"""How often the reading thread looks whether it is to end."""
SEQUENCE_S: Final = 0.03
"""How long to wait for the rest of a sequence, which is not much longer than Textual's parser does."""
