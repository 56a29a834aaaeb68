"""What written sentences cover, and which lines are wrong:

    python -m engine.understanding.training.coverage FILES

Without files: all sentences that the reader learns from."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from engine.understanding.acts import ACTS, CONDITIONS
from engine.understanding.meaning import meaning_of
from engine.understanding.notation import STRUCTURE, Example, NotationError, Step, read
from engine.understanding.symbols import DONE, MAX_STEPS, ROLE_NAMES, Grammar
from engine.understanding.training.examples import SENTENCES, language_of, lines

KINDS: Final = {
    "about": "spoken about", "retract": "taken back", "not": "forbidden", "instead": "corrected", "if": "condition",
    "until": "until", "repeat": "repeated",
}  # fmt: skip
"""The kind of a sentence whose meaning holds such a symbol; the first one counts."""
_FEW: Final = 40
"""An act with fewer sentences in a language is named in the report."""


def wrong(example: Example) -> str:
    """What the grammar has against an example; empty where nothing."""
    if len(example.steps) >= MAX_STEPS:
        return "too much in one sentence"
    try:
        meaning_of(example.text, example.steps)
    except ValueError as error:
        return str(error)
    grammar = Grammar()
    for step in example.steps:
        allowed = grammar.allowed()
        if step.symbol not in allowed:
            return f"{step.symbol} may not stand here"
        if step.symbol in ROLE_NAMES and step.start >= step.end:
            return f"the {step.symbol} has no words"
        grammar.feed(step.symbol)
    return "" if DONE in grammar.allowed() else "something is not closed"


def kind_of(steps: Sequence[Step]) -> str:
    """What kind of sentence it is."""
    symbols = [step.symbol for step in steps if step.start < 0]
    for symbol, kind in KINDS.items():
        if symbol in symbols:
            return kind
    return "one act" if len(symbols) == 1 else "several acts"


def checked(files: Iterable[Path]) -> tuple[list[Example], list[str]]:
    """The examples of some files, and what is wrong with other lines."""
    examples, errors = list[Example](), list[str]()
    for file in files:
        known = set[str]()
        for number, line in lines(file):
            try:
                example = read(line)
                why = wrong(example)
            except NotationError as error:
                why = str(error)
            else:
                if not why and example.text.casefold() in known:
                    why = "stands twice"
                known.add(example.text.casefold())
                if not why:
                    examples.append(example)
            if why:
                errors.append(f"{file.name}:{number}: {why}: {line}")
    return examples, errors


def report(examples: Sequence[Example]) -> str:
    """How many sentences there are of each language and kind, and what is rare."""
    kinds = Counter((language_of(example.text), kind_of(example.steps)) for example in examples)
    uses = Counter((language_of(example.text), step.symbol) for example in examples for step in example.steps)
    table = [f"{'':12}{'English':>9}{'Chinese':>9}"]
    table += [f"{kind:12}{kinds['en', kind]:>9}{kinds['zh', kind]:>9}" for kind in dict.fromkeys(k for _, k in kinds)]
    of = Counter(language_of(example.text) for example in examples)
    table.append(f"{'all':12}{of['en']:>9}{of['zh']:>9}")
    for language in ("en", "zh"):
        rare = [f"{name} {uses[language, name]}" for name in (*STRUCTURE, *CONDITIONS, *ACTS)
                if uses[language, name] < _FEW]  # fmt: skip
        table.append(f"fewer than {_FEW} in {language}: {', '.join(rare) or 'none'}")
    return "\n".join(table)


def main() -> int:
    files = [Path(name) for name in sys.argv[1:]] or sorted(SENTENCES.glob("*/*.txt"))
    examples, errors = checked(files)
    sys.stdout.write("".join(f"{error}\n" for error in errors) + report(examples) + "\n")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
