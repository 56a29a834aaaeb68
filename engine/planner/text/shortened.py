"""What people shorten when they type in a hurry: "pls go 2 ur dock n dont beep"."""

from __future__ import annotations

import re
from typing import Final

_NOT: Final = "do|does|did|is|are|was|were|ca|wo|has|have|had|should|would|could|must|need|ai"
_BEING: Final = "how|he|she|someone|somebody|anyone|anybody|nobody|everyone|everybody"
_STATE: Final = (
    r"there|not|on|in|at|by|under|behind|near|next|still|already|gone|empty|free|full|a|an|the|too|so|just|really|all|"
    r"been|waiting|sitting|standing|lying|left|around|home|up|out|my|your|\w+ing"
)
_WORDS: Final = {
    "u": "you", "ya": "you", "n": "and", "pls": "please", "plz": "please", "plse": "please", "thx": "thanks",
    "ty": "thank you", "cuz": "because", "coz": "because", "bc": "because", "b4": "before", "rn": "right now",
    "em": "them", "any1": "anyone", "some1": "someone", "every1": "everyone", "no1": "no one", "nvm": "never mind",
    "abt": "about", "smth": "something", "sth": "something", "ppl": "people", "youre": "you're", "theyre": "they're",
    "ive": "I've", "youve": "you've", "theyve": "they've", "weve": "we've", "im": "I'm", "w/": "with", "w": "with",
}  # fmt: skip
_SHORT: Final = re.compile(
    rf"(?<![\w'])(?:(?P<word>{'|'.join(sorted(_WORDS, key=len, reverse=True))})"
    r"|(?P<to>(?<=[a-z] )2)(?= (?:the|my|ur|your|me|us|u)\b)"
    rf"|(?P<it>it)s(?= (?:there|not|still|already|gone|empty|free)\b)"
    rf"|(?P<negated>{_NOT})nt"
    rf"|(?P<being>{_BEING})s(?= (?:{_STATE})\b)|(?P<is>that|what|where|who|let|here|there)s"
    rf"|(?P<are>r)(?= (?:u|you|we|they|there)\b)"
    r"|(?P<ur>ur)(?P<doing>(?= (?:at|in|on|done|so|not|free|back|there|here|ready|finished|near|a|the|\w+ing)\b))?)"
    r"(?![\w'])",
    re.IGNORECASE,
)


def written_in_full(text: str) -> str:
    """The text with what is shortened written in full; "N" and "W" are names, or points of the compass."""
    return _SHORT.sub(_in_full, text) if " " in text.strip() else text


def _in_full(found: re.Match[str]) -> str:
    said = found[0]
    if said in ("N", "W"):
        return said
    if found["word"]:
        return _WORDS[said.casefold()]
    if found["negated"]:
        return f"{found['negated']}n't"
    if being := found["being"] or found["is"] or found["it"]:
        return f"{being}'s"
    if found["are"]:
        return "are"
    if found["to"]:
        return "to"
    return "you're" if found["doing"] is not None else "your"
