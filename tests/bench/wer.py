"""Word error rate, after writing differences are taken out: case, punctuation, digits, and British spelling."""

from __future__ import annotations

import re

_ONES = (
    "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
    "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen",
)  # fmt: skip
_TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_SPELLING = {"meter": "metre", "meters": "metres", "gray": "grey", "mr": "mister", "okay": "ok"}


def normalised(text: str) -> list[str]:
    """The words of ``text`` as they are spoken: ``Turn 90°.`` becomes turn, ninety, degrees."""
    spoken = text.casefold().replace("°", " degrees").replace("%", " percent").replace("’", "'")
    spoken = re.sub(r"\d+(?:\.\d+)?", lambda found: f" {_spoken(found[0])} ", spoken)
    words = re.findall(r"[^\W_]+(?:'[^\W_]+)*", spoken)
    return [_SPELLING.get(word, word) for word in words]


def errors(reference: list[str], hypothesis: list[str]) -> int:
    """Words to insert, delete or replace (Levenshtein)."""
    row = list(range(len(hypothesis) + 1))
    for i, wanted in enumerate(reference, 1):
        diagonal, row[0] = row[0], i
        for j, found in enumerate(hypothesis, 1):
            diagonal, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, diagonal + (wanted != found))
    return row[-1]


def _spoken(number: str) -> str:
    whole, _, fraction = number.partition(".")
    value = int(whole)
    if value >= 1000:
        words = " ".join(_ONES[int(digit)] for digit in whole)
    else:
        hundreds, rest = divmod(value, 100)
        parts = [f"{_ONES[hundreds]} hundred"] if hundreds else []
        if rest >= 20:
            parts.append(_TENS[rest // 10 - 2] + (f" {_ONES[rest % 10]}" if rest % 10 else ""))
        elif rest or not hundreds:
            parts.append(_ONES[rest])
        words = " ".join(parts)
    return f"{words} point {' '.join(_ONES[int(digit)] for digit in fraction)}" if fraction else words
