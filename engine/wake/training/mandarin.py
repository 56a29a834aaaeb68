"""How Chinese text is said, in the signs that Kokoro reads: those of misaki (https://github.com/hexgrad/misaki, zh.py),
in which an arrow behind the vowel is the tone.

eSpeak NG knows how characters and pinyin are read; its own names for sounds are turned into those signs, syllable by
syllable. Its IPA will not do: there two tones look the same.
"""

from __future__ import annotations

import re
from typing import Final

VOICE: Final = "cmn-latn-pinyin"
"""eSpeak's Chinese voice that reads Latin letters as pinyin; plain ``cmn`` takes them for English."""

_ONSETS: Final = {
    "ts.h": "ꭧʰ", "ts.": "ꭧ", "tsh": "ʦʰ", "ts": "ʦ", "tS;h": "ʨʰ", "tS;": "ʨ", "s.": "ʂ", "z.": "ɻ", "S;": "ɕ",
    "ph": "pʰ", "p": "p", "th": "tʰ", "t": "t", "kh": "kʰ", "k": "k", "m": "m", "f": "f", "n": "n", "l": "l", "X": "x",
    "s": "s",
}  # fmt: skip
_RIMES: Final = {
    "A": "a", "a": "a", "o": "wo", "o-": "ɤ", "@": "ɤ", "ai": "ai", "ei": "ei", "Au": "au", "ou": "ou", "@r": "ɚ",
    "i": "i", "i.": "ɨ", "i[": "ɨ", "iA": "ja", "iE": "je", "jAu": "jau", "iou": "jou", "ji": "i", "jiA": "ja",
    "jiE": "je", "jiou": "jou", "u": "u", "wu": "u", "ua": "wa", "wA": "wa", "wa": "wa", "uo": "wo", "wo": "wo",
    "uai": "wai", "wai": "wai", "uei": "wei", "wei": "wei", "y": "y", ";y": "y", "jy": "y", "yE": "ɥe", "jyE": "ɥe",
    "ong": "ʊ", "jong": "jʊ",
}  # fmt: skip
_RIMES_BEFORE_A_NASAL: Final = {
    "@": "ə", "o-": "ə", "i.": "i", "i[": "i", "iE": "jɛ", "jiE": "jɛ", "u@": "wə", "wu@": "wə", "wo-": "wə",
    "y&": "ɥɛ", "jy&": "ɥɛ", "y@": "y", ";y@": "y", "jy@": "y", "yi": "y", "yu": "jʊ",
}  # fmt: skip
_TONES: Final = {"55": "→", "35": "↗", "21": "↓", "214": "↓", "51": "↘", "53": "↘"}
"""The others are unstressed, and have none."""
_NASALS: Final = {"n": "n", "N": "ŋ", "": ""}
_SYLLABLE: Final = re.compile(
    rf"({'|'.join(map(re.escape, sorted(_ONSETS, key=len, reverse=True)))})?([^\d]+?)(\d+)(N|n(?![aAeiouy@]))?"
)
"""eSpeak 1.52 writes nothing between the syllables of a word that it knows: there an n before a vowel begins one."""
_WORD: Final = re.compile(f"(?:{_SYLLABLE.pattern})+")


def signs(mnemonics: str) -> str:
    """The signs for what ``espeak-ng -x`` prints. What is no Chinese syllable is left out."""
    words = []
    for word in mnemonics.split():
        parts = re.sub("[',]", "", word).strip("_|").split("_|")
        found = (match for part in parts if _WORD.fullmatch(part) for match in _SYLLABLE.finditer(part))
        words.append("".join(_signs(*match.groups()) for match in found))
    return " ".join(filter(None, words))


def _signs(onset: str | None, rime: str, tone: str, nasal: str | None) -> str:
    if nasal == "N" and (rime == "y" or (rime == "u" and onset == "tS;h")):
        vowel: str | None = "jʊ"
    elif nasal:
        vowel = _RIMES_BEFORE_A_NASAL.get(rime) or _RIMES.get(rime)
    else:
        vowel = _RIMES.get(rime)
    if vowel is None:
        return ""
    ending = "ŋ" if rime in ("ong", "jong") else _NASALS[nasal or ""]
    return f"{_ONSETS[onset] if onset else ''}{vowel}{_TONES.get(tone, '')}{ending}"
