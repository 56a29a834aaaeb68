"""Words for colours: those of things, and those of the robot's light."""

from __future__ import annotations

import re
from typing import Final, get_args

from engine.perception.sighting import Colour

COLOURS: Final = {**{colour: colour for colour in get_args(Colour)}, "gray": "grey", "violet": "purple"}
"""The colours of things, as people write them and as perception calls them."""
IN_CHINESE: Final = {
    "red": "红", "orange": "橙", "yellow": "黄", "green": "绿", "blue": "蓝", "purple": "紫", "white": "白",
    "grey": "灰", "black": "黑", "pink": "粉", "brown": "棕", "cyan": "青",
}  # fmt: skip
_OF_LIGHT: Final = {
    "off": r"\b(?:off|out|dark)\b|关|灭",
    "white": r"\b(?:on|white|bright)\b|开|亮|白",
    "purple": r"\b(?:violet|magenta|purple)\b|紫",
    "cyan": r"\b(?:turquoise|cyan)\b|青",
}
"""What says a colour of the light, where that is more than its name."""


def of_light(colour: str) -> re.Pattern[str]:
    """What says this colour of the light."""
    return re.compile(_OF_LIGHT.get(colour, rf"\b{re.escape(colour)}\b|{IN_CHINESE.get(colour, colour)}"))
