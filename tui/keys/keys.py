"""The keys of the console: one row per action, with the action's id, which settings and help refer to.

An action's id never changes; its key may (Textual's key map replaces keys by binding id).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Final

from tui.words import strings


@dataclass(frozen=True, slots=True)
class Key:
    """One action of the console and the key that does it. Its words stand in ``tui.words.strings`` by its id."""

    id: str
    """Name of the action in key maps; the app has a method ``action_<id>``."""
    key: str
    """Default key, as Textual spells it."""
    _: KW_ONLY
    everywhere: bool = False
    """Acts before whatever has the focus sees the key: it cannot be typed."""
    reserved: bool = False
    """No map, page or hand may have its key; only a line goes before it, for what is typed there or edits."""
    does: str = ""
    """The method with its arguments where it is not ``action_<id>``."""

    @property
    def action(self) -> str:
        """What it does, as Textual writes it."""
        return self.does or self.id

    @property
    def ahead(self) -> bool:
        """Acts before the keys behind it are dealt out: these go to wherever the keyboard is then."""
        return self.everywhere or self.reserved

    @property
    def word(self) -> str:
        """One word for the status line; empty: not shown there."""
        return strings.KEY_WORDS.get(self.id, "")

    @property
    def about(self) -> str:
        """A sentence for the help page."""
        return strings.ABOUT_KEYS[self.id]


KEYS: Final = (
    Key("interrupt", "escape", everywhere=True),
    Key("back", "backspace,ctrl+g", reserved=True),
    Key("wake", "space"),
    Key("end_task", "e"),
    Key("type", "slash", reserved=True),
    Key("add", "ctrl+j", everywhere=True),
    Key("estop", "ctrl+x", everywhere=True),
    Key("release", "ctrl+o,R"),
    Key("by_hand", "g"),
    Key("speed_down", "minus", does="speed(-1)"),
    Key("speed_up", "plus,equals_sign", does="speed(1)"),
    Key("help", "question_mark,f1"),
    Key("resume", "k"),
    Key("undo", "u"),
    Key("again", "a"),
    Key("leave", "q"),
    Key("leave_now", "ctrl+c", everywhere=True),
    Key("log", "l"),
    Key("map", "m"),
    Key("camera", "c"),
    Key("timeline", "t"),
    Key("turn_back", "left_square_bracket"),
    Key("turn_on", "right_square_bracket"),
    Key("turn", "enter"),
    Key("palette", "ctrl+p", everywhere=True),
    Key("recall", "ctrl+r", everywhere=True),
    Key("pane_next", "tab", does="next_pane(1)"),
    Key("pane_previous", "shift+tab", does="next_pane(-1)"),
    Key("pane_conversation", "1", does="pane('conversation')"),
    Key("pane_plan", "2", does="pane('plan')"),
    Key("pane_actions", "3", does="pane('actions')"),
    Key("pane_map", "4", does="pane('map')"),
    Key("pane_log", "5", does="pane('log')"),
    Key("pane_turns", "6", does="pane('turns')"),
    Key("pane_camera", "7", does="pane('camera')"),
    Key("zoom", "z"),
    Key("border_left", "less_than_sign", does="border(-1)"),
    Key("border_right", "greater_than_sign", does="border(1)"),
    Key("copy", "y"),
    Key("save", "S"),
    Key("link", "i"),
    Key("settings", "o"),
    Key("doctor", "d"),
    Key("older", "pageup", everywhere=True),
    Key("newer", "pagedown", everywhere=True),
    Key("newest", "end"),
    Key("line_up", "up", does="scroll_line(-1)"),
    Key("line_down", "down", does="scroll_line(1)"),
)

IN_ONE_LINE: Final = frozenset([
    "interrupt", "back", "wake", "end_task", "type", "estop", "release", "speed_down", "speed_up", "resume", "undo",
    "again", "leave", "leave_now", "copy", "save", "add",
])  # fmt: skip
"""The actions that need neither panes nor pages."""

MAP_KEYS: Final = (
    Key("map_nearer", "plus,equals_sign", does="map_zoom(1)"),
    Key("map_farther", "minus", does="map_zoom(-1)"),
    Key("map_whole", "0"),
    Key("map_follow", "f"),
    Key("map_legend", "L"),
    Key("map_point_left", "left", does="map_cursor(-1, 0)"),
    Key("map_point_right", "right", does="map_cursor(1, 0)"),
    Key("map_point_up", "up", does="map_cursor(0, 1)"),
    Key("map_point_down", "down", does="map_cursor(0, -1)"),
    Key("map_left", "shift+left,h", does="map_pan(-1, 0)"),
    Key("map_right", "shift+right,l", does="map_pan(1, 0)"),
    Key("map_up", "shift+up,k", does="map_pan(0, 1)"),
    Key("map_down", "shift+down,j", does="map_pan(0, -1)"),
    Key("map_next", "tab", does="map_next(1)"),
    Key("map_previous", "shift+tab", does="map_next(-1)"),
    Key("map_go", "enter"),
    Key("map_here", "p", does="map_here(0)"),
    Key("map_turn_left", "comma", does="map_here(1)"),
    Key("map_turn_right", "full_stop", does="map_here(-1)"),
)
"""Those of the map, while it has the focus; they go before the console's own. Their actions are the map's."""


QUEUE_KEYS: Final = (
    Key("queue_up", "up", does="choose(-1)"),
    Key("queue_down", "down", does="choose(1)"),
    Key("queue_drop", "x", does="drop"),
    Key("queue_earlier", "K,shift+up", does="move(-1)"),
    Key("queue_later", "J,shift+down", does="move(1)"),
    Key("queue_change", "enter", does="change"),
)
"""Those of the actions, while requests wait and it has the focus; they go before the console's own. Their actions are
that pane's."""
LOG_KEYS: Final = (
    Key("log_level", "v"),
    Key("log_part", "p"),
    Key("log_all", "0"),
    Key("log_find", "s"),
    Key("log_trouble_before", "n", does="log_trouble(-1)"),
    Key("log_trouble_after", "N", does="log_trouble(1)"),
    Key("log_turn", "enter"),
    Key("log_follow", "f,end"),
)
"""Those of the log, while it has the focus; they go before the console's own. Their actions are the log's."""


TURN_KEYS: Final = (
    Key("unfold", "j"),
    Key("lines_up", "up"),
    Key("lines_down", "down"),
)
"""Those of the page of one turn, where they go before the console's own. Their actions are the page's."""


DOCTOR_KEYS: Final = (Key("examine", "r"),)
"""Those of the page of the doctor, where they go before the console's own. Their actions are the page's."""


HAND_KEYS: Final = (
    Key("hand_ahead", "up,w", does="hand(1, 0, 0)"),
    Key("hand_back", "down,s", does="hand(-1, 0, 0)"),
    Key("hand_left", "left,a", does="hand(0, 0, 1)"),
    Key("hand_right", "right,d", does="hand(0, 0, -1)"),
    Key("hand_aside_left", "comma", does="hand(0, 1, 0)"),
    Key("hand_aside_right", "full_stop", does="hand(0, -1, 0)"),
    Key("hand_faster", "plus,equals_sign", does="hand_speed(1)"),
    Key("hand_slower", "minus", does="hand_speed(-1)"),
)
"""Those of driving by hand, while it goes on; they go before the console's own. Their actions are that line's."""


SETTING_KEYS: Final = (
    Key("setting_up", "up", does="step(-1)"),
    Key("setting_down", "down", does="step(1)"),
    Key("setting_before", "left", does="turn(-1)"),
    Key("setting_after", "right", does="turn(1)"),
    Key("setting_take", "enter", does="take"),
    Key("setting_default", "d", does="default"),
    Key("setting_find", "s", does="find"),
)
"""Those of the page of the settings, where they go before the console's own. Their actions are the page's."""

LINE_KEYS: Final = (
    Key("send", "enter", does="submit"),
    Key("earlier", "up", does="recall(-1)"),
)
"""Of the keys of a line that is typed in, which nobody changes, those that hints name. Their actions are the line's."""

_SCROLLED: Final = ("older", "newer", "newest", "line_up", "line_down", "zoom", "copy")
PANE_KEYS: Final[Mapping[str, tuple[str, ...]]] = {
    "conversation": _SCROLLED,
    "plan": _SCROLLED,
    "actions": _SCROLLED,
    "log": (*_SCROLLED, "border_left", "border_right"),
    "turns": (*_SCROLLED, "border_left", "border_right", "turn_back", "turn_on", "turn"),
    "camera": ("camera", "zoom"),
    "map": ("map", "zoom"),
    "line": ("add", "wake", "recall", "palette", "pane_next", "back"),
}
"""The console's own keys that matter most where the keyboard is: in a pane, or in the line."""

ALL_KEYS: Final = (*KEYS, *MAP_KEYS, *QUEUE_KEYS, *LOG_KEYS, *TURN_KEYS, *DOCTOR_KEYS, *HAND_KEYS, *SETTING_KEYS)
BY_ID: Final[Mapping[str, Key]] = {key.id: key for key in (*ALL_KEYS, *LINE_KEYS)}


EVERYWHERE: Final = frozenset(key.id for key in KEYS if key.everywhere)
"""The actions whose keys act while one types, too."""
PUNCTUATION: Final = {
    "!": "exclamation_mark", '"': "quotation_mark", "#": "number_sign", "$": "dollar_sign", "%": "percent_sign",
    "&": "ampersand", "'": "apostrophe", "(": "left_parenthesis", ")": "right_parenthesis", "*": "asterisk",
    "+": "plus", ",": "comma", "-": "minus", ".": "full_stop", "/": "slash", ":": "colon", ";": "semicolon",
    "<": "less_than_sign", "=": "equals_sign", ">": "greater_than_sign", "?": "question_mark", "@": "at",
    "[": "left_square_bracket", "\\": "backslash", "]": "right_square_bracket", "^": "circumflex_accent",
    "_": "underscore", "`": "grave_accent", "{": "left_curly_bracket", "|": "vertical_line",
    "}": "right_curly_bracket", "~": "tilde", " ": "space",
}  # fmt: skip
"""What is typed, and Textual's names for it."""
EDITING: Final = frozenset(
    ["enter", "tab", "shift+tab", "backspace", "delete", "home", "end", "up", "down", "left", "right"]
)
"""What a line that is typed in needs for itself."""


def all_shown(keys: Mapping[str, str]) -> dict[str, str]:
    """Keys by action, several of them separated by commas, as they are listed for people."""
    return {action: "/".join(map(shown, written.split(","))) for action, written in keys.items()}


def first_shown(keys: Mapping[str, str]) -> dict[str, str]:
    """The first key of each action, as people read it."""
    return {action: shown(written.partition(",")[0]) for action, written in keys.items()}


def command_in_line(key: str, keys: Mapping[str, str]) -> str:
    """The action, with its arguments, of a key in an empty line: it is one of the console's, and no request begins with
    it. Letters and digits are text. Empty: there is none."""
    if key not in PUNCTUATION.values():
        return ""
    return next((action.action for action in KEYS if key in keys[action.id].split(",")), "")


def shown(key: str) -> str:
    """How a key is written for people: ``escape`` is ``esc``, ``question_mark`` is ``?``."""
    if key in strings.KEY_NAMES:
        return strings.KEY_NAMES[key]
    from textual.keys import format_key  # which a command without a screen does not need

    return format_key(key)
