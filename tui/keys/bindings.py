"""The console's keys as Textual wants them. The tables themselves (:mod:`tui.keys.keys`) know no Textual, so that a
command without a screen can read them."""

from __future__ import annotations

from typing import Final

from textual.binding import Binding, BindingType

from tui.keys.keys import DOCTOR_KEYS, HAND_KEYS, KEYS, LOG_KEYS, MAP_KEYS, QUEUE_KEYS, SETTING_KEYS, TURN_KEYS

BINDINGS: Final[list[BindingType]] = [
    Binding(key.key, key.action, key.word or key.about, show=False, priority=key.ahead, id=key.id) for key in KEYS
]

MAP_BINDINGS: Final[list[BindingType]] = [
    Binding(key.key, key.action, key.about, show=False, id=key.id) for key in MAP_KEYS
]

QUEUE_BINDINGS: Final[list[BindingType]] = [
    Binding(key.key, key.action, key.about, show=False, id=key.id) for key in QUEUE_KEYS
]

LOG_BINDINGS: Final[list[BindingType]] = [
    Binding(key.key, key.action, key.about, show=False, id=key.id) for key in LOG_KEYS
]

TURN_BINDINGS: Final[list[BindingType]] = [
    Binding(key.key, key.action, key.about, show=False, id=key.id) for key in TURN_KEYS
]

DOCTOR_BINDINGS: Final[list[BindingType]] = [
    Binding(key.key, key.action, key.about, show=False, id=key.id) for key in DOCTOR_KEYS
]

HAND_BINDINGS: Final[list[BindingType]] = [
    Binding(key.key, key.action, key.about, show=False, id=key.id) for key in HAND_KEYS
]

SETTING_BINDINGS: Final[list[BindingType]] = [
    Binding(key.key, key.action, key.about, show=False, id=key.id) for key in SETTING_KEYS
]
