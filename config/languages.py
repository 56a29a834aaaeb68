"""The languages that Whisper knows, and which one is meant by what people and services call one.

(https://github.com/openai/whisper/blob/main/whisper/tokenizer.py) Services name the language of what they heard by its
code, with a region or a script ("zh-CN", "en_US"), by another standard's code ("cmn") or by its name ("english").
"""

from __future__ import annotations

import re
from typing import Final

_NAMES: Final = (
    "af afrikaans, am amharic, ar arabic, as assamese, az azerbaijani, ba bashkir, be belarusian, bg bulgarian, "
    "bn bengali, bo tibetan, br breton, bs bosnian, ca catalan, cs czech, cy welsh, da danish, de german, el greek, "
    "en english, es spanish, et estonian, eu basque, fa persian, fi finnish, fo faroese, fr french, gl galician, "
    "gu gujarati, ha hausa, haw hawaiian, he hebrew, hi hindi, hr croatian, ht haitian, hu hungarian, hy armenian, "
    "id indonesian, is icelandic, it italian, ja japanese, jw javanese, ka georgian, kk kazakh, km khmer, kn kannada, "
    "ko korean, la latin, lb luxembourgish, ln lingala, lo lao, lt lithuanian, lv latvian, mg malagasy, mi maori, "
    "mk macedonian, ml malayalam, mn mongolian, mr marathi, ms malay, mt maltese, my myanmar, ne nepali, nl dutch, "
    "nn nynorsk, no norwegian, oc occitan, pa punjabi, pl polish, ps pashto, pt portuguese, ro romanian, ru russian, "
    "sa sanskrit, sd sindhi, si sinhala, sk slovak, sl slovenian, sn shona, so somali, sq albanian, sr serbian, "
    "su sundanese, sv swedish, sw swahili, ta tamil, te telugu, tg tajik, th thai, tk turkmen, tl tagalog, tr turkish, "
    "tt tatar, uk ukrainian, ur urdu, uz uzbek, vi vietnamese, yi yiddish, yo yoruba, yue cantonese, zh chinese"
)
CODES: Final = tuple(entry.split()[0] for entry in _NAMES.split(", "))
"""All that Whisper knows; most of them are ISO 639-1."""
_MEANT: Final = {name: code for code, name in (entry.split() for entry in _NAMES.split(", "))} | {
    **dict.fromkeys(("cantonese", "chi", "cmn", "cn", "mandarin", "yue", "zho"), "zh"),  # which is written alike
    **{"deu": "de", "eng": "en", "fra": "fr", "fre": "fr", "ger": "de", "ita": "it", "jp": "ja", "jpn": "ja"},
    **{"jv": "jw", "kor": "ko", "kr": "ko", "nb": "no", "por": "pt", "rus": "ru", "spa": "es"},
    **{"burmese": "my", "castilian": "es", "flemish": "nl", "haitian creole": "ht"},
}
_MORE: Final = re.compile(r"[-_,;(]")
"""What comes before a region, a script or a dialect."""


def code_of(language: str) -> str:
    """The code of what somebody calls a language, without a region or a script; what nobody knows as it stands."""
    name = _MORE.split(language.casefold())[0].strip()
    return _MEANT.get(name, name)
