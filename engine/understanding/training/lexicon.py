"""Writes the list of words that the reader learns from:

    python -m engine.understanding.training.lexicon

Words that stand only once in all sentences are left out: most are slips, sounds and names."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import Final

from engine.understanding.lexicon import WORDS, words_in, written
from engine.understanding.training.examples import ASSETS, SENTENCES
from engine.understanding.training.examples import written as examples

LEAST: Final = 2
"""How often a word has to stand in the sentences."""
_LETTERS: Final = frozenset({"a", "i", "o"})
"""Single letters that are words."""


def made() -> str:
    """The file as the sentences of now make it."""
    counts: Counter[str] = Counter()
    for example in examples(sorted(SENTENCES.glob("*/*.txt"))):
        counts.update(words_in(example.text))
    words = (word for word, count in counts.items() if count >= LEAST)
    return written([word for word in words if len(word) > 1 or word in _LETTERS])


def main() -> int:
    (Path(ASSETS) / WORDS).write_text(made(), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
