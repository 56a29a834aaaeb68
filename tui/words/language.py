"""The language of the console: English, or Chinese where somebody wants that.

Words stand in ``tui.words.strings``; those of another language are put in their place, and its file is read only then,
so that English costs nothing. A process draws one console, and so the language is that of the process. What the engine
says on a screen goes through :func:`told`; events, logs and files stay English.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Final, Literal, Protocol, runtime_checkable

from tui.words import strings

Language = Literal["en", "zh"]
Telling = Callable[[str], str]
"""A sentence of the engine's, a name or a call of a skill, in the language of the console as far as that is known."""

_ENGLISH: Final = {name: word for name, word in vars(strings).items() if name.isupper()}
_MESSAGES: Final = ("LC_ALL", "LC_MESSAGES", "LANG")
"""The first of these that is set names the language of messages (POSIX, Environment Variables)."""
_KEPT: Final = 2000  # sentences: each is told again with every frame


@runtime_checkable
class Wordy(Protocol):
    """A screen that shows words."""

    def reword(self) -> None:
        """They are in another language now."""


class _Spoken:
    """What the console speaks at present."""

    language: Language = "en"
    wording: Telling | None = None
    told: Telling | None = None  # the same with a memory


def of_environment(environ: Mapping[str, str]) -> Language:
    """The language of this terminal's user."""
    said = next(filter(None, (environ.get(name) for name in _MESSAGES)), "")
    return "zh" if said[:2].lower() == "zh" and not said[2:3].isalpha() else "en"


def chosen(
    setting: Literal["auto"] | Language, requests: Literal["auto"] | Language, environ: Mapping[str, str]
) -> Language:
    """The language by the settings: ``setting`` is the console's; where that is auto, Chinese if ``requests`` are, or
    else that of the environment."""
    if setting != "auto":
        return setting
    return "zh" if requests == "zh" else of_environment(environ)


def speak(language: Language, wording: Telling | None = None) -> bool:
    """All words are in this language from now on, those of the engine by ``wording``; False where they are already.

    Whoever shows some has to show them anew (``SaysoApp.speak``).
    """
    if language == "en":
        wording = None
    if (language, wording) == (_Spoken.language, _Spoken.wording):
        return False
    words = _ENGLISH
    if language == "zh":
        from tui.words import strings_zh

        words = _ENGLISH | {name: word for name, word in vars(strings_zh).items() if name.isupper()}
    vars(strings).update(words)
    _Spoken.language, _Spoken.wording = language, wording
    _Spoken.told = lru_cache(_KEPT)(wording) if wording is not None else None
    return True


def told(text: str) -> str:
    """What the engine says, as the console shows it."""
    return _Spoken.told(text) if _Spoken.told is not None else text
