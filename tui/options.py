"""The settings that a person changes in the console: their values as people read and write them.

What a setting means and what may stand there is said by the schema; here stands only which of them are shown, and
which take effect at once.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from tui.shown.facts import printable
from tui.words import strings

if TYPE_CHECKING:
    from config.changing import Layers
    from config.editing import Value

SHOWN: Final = (
    "console.theme",
    "console.language",
    "console.fps",
    "console.camera",
    "console.camera_graphics",
    "console.motion",
    "console.notify",
    "voice.when",
    "voice.volume",
    "audio.device",
    "wake.words",
    "planner.profile",
)
"""Those that are changed most, which stand first."""
LIVE: Final = frozenset(
    {
        "console.theme",
        "console.language",
        "console.fps",
        "console.camera",
        "console.motion",
        "console.notify",
        "voice.volume",
    }
)
"""Those that need no restart; of the engine's own, which are read once, those that it is told by a command."""


@dataclass(frozen=True, slots=True)
class Option:
    """One setting in force."""

    key: str
    """Dotted name."""
    value: Any
    about: str
    """What it means, in the words of the schema."""
    choices: tuple[str, ...]
    """What may stand there, where that is a list; one may write anything else elsewhere."""
    origin: str
    """File and line, variable or option; empty: what sayso comes with."""
    over: str
    """What goes before the user's files: a variable, an option, a file that was given; empty where they hold."""

    @property
    def group(self) -> str:
        """Under which heading it stands: its section, or ``usual``."""
        return "usual" if self.key in SHOWN else self.path[0]

    @property
    def name(self) -> str:
        """What people call it; for what only few change, its name in the file."""
        return strings.SETTING_NAMES.get(self.key) or self.key

    @property
    def live(self) -> bool:
        """It takes effect at once."""
        return self.key in LIVE

    @property
    def path(self) -> tuple[str, ...]:
        """Its keys from the top."""
        return tuple(self.key.split("."))


def options(layers: Layers, themes: Sequence[str]) -> tuple[Option, ...]:
    """All that there are. Takes as long as the disk does. Raises ``ConfigError``."""
    from config.changing import choices, described, is_packaged, overriding

    found = layers.explain()
    lists = {"console.theme": tuple(themes), "planner.profile": tuple(layers.load().profiles)}
    listed = []
    for key in every():
        setting, path = found[key], tuple(key.split("."))
        may = lists.get(key) or choices(path)
        origin = "" if is_packaged(setting) else setting.origin
        listed.append(Option(key, setting.value, described(path), may, origin, overriding(setting, layers)))
    return tuple(listed)


def every() -> tuple[str, ...]:
    """The names of all settings: the usual ones, and then the others, section by section. What has a name of one's own
    (places, platforms, skills, keys) is written in the file."""
    from config.allowed import settings

    others = dict.fromkeys(settings())
    sections = {name.partition(".")[0]: None for name in others}
    return (
        *SHOWN,
        *(name for part in sections for name in others if name.startswith(f"{part}.") and name not in SHOWN),
    )


def found(options: Sequence[Option], typed: str) -> tuple[Option, ...]:
    """Those in whose names, sections or meanings every word that was typed occurs."""
    wanted = typed.casefold().split()
    return tuple(
        option
        for option in options
        if all(word in f"{option.key} {option.name} {option.about} {about(option)}".casefold() for word in wanted)
    )


def about(option: Option) -> str:
    """What it means: in the words of the console, or else in those of the schema, which are English."""
    return strings.SETTING_ABOUTS.get(option.key) or option.about


def shown(value: Any) -> str:
    """A value as people write it."""
    if value is None:
        return strings.NO_VALUE
    if isinstance(value, list | tuple):
        return printable(", ".join(map(str, value))) or strings.NO_ENTRY
    if isinstance(value, bool):
        return str(value).lower()  # as in a file
    return f"{value:g}" if isinstance(value, float) else printable(str(value))


def written(value: Any) -> str:
    """What stands in the line in which it is changed."""
    return "" if value is None or value in ([], ()) else shown(value)


def origin_of(option: Option) -> str:
    """Where it comes from, for people."""
    if not option.origin:
        return strings.FROM_DEFAULT
    home = os.path.expanduser("~")  # noqa: PTH111 - a home that cannot be told is none
    where = option.origin.replace(f"{home}/", "~/", 1) if home != "/" else option.origin
    return printable(where)


def kept(name: str, file: str) -> str:
    """That a setting of this name is kept in ``file``; empty: that it is as sayso comes with it."""
    return (strings.SETTING_KEPT if file else strings.SETTING_BACK).format(name=name, file=file)


def overridden(option: Option) -> str:
    """What goes before the file in which it was set, for people."""
    return strings.SETTING_OVER.format(origin=printable(option.over), value=shown(option.value))


def value_of(option: Option, text: str) -> Value:
    """What was written there; whether it may be that, the schema says."""
    text = text.strip()
    if option.key == "wake.words" and text == "auto":
        return text
    if option.key == "wake.words" or isinstance(option.value, list | tuple):
        return [word.strip() for word in text.split(",") if word.strip()]
    if isinstance(option.value, bool) and text in option.choices:
        return text == shown(True)
    if option.choices:
        return text
    if not text or text == strings.NO_VALUE:
        return None
    from config.errors import Where
    from config.source import SourceError, parse_value

    try:
        value = parse_value(text, Where(option.key)).value
    except SourceError:
        return text
    return text if isinstance(value, list | dict) else value
