"""What a request may mean, other than word by word: each reading is the request in plainer words.

Something was taken back, steps are told in another order, several things are named at once, a clause goes round about,
a story comes first, or words were misheard. A reading is only a proposal: whoever asks for it knows whether it makes a
command. Each kind was measured on commands that nobody here had seen, and what gained
nothing is gone; the learned reader is to replace the others.
"""

from __future__ import annotations

from collections.abc import Iterator

from engine.planner.readings.background import Background
from engine.planner.readings.conditions import conditional
from engine.planner.readings.corrections import corrected
from engine.planner.readings.first_look import CONDITION
from engine.planner.readings.misheard import Misheard
from engine.planner.readings.order import in_order
from engine.planner.readings.roundabout import Roundabout
from engine.planner.readings.several import Several
from engine.planner.request import Language
from engine.skills.vocabulary import Vocabulary


class Readings:
    """Knows the words of one house. Thread-safe."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        self._several = Several(vocabulary)
        self._background = Background(vocabulary, self._several.thing)
        self._misheard = Misheard(vocabulary)
        self._roundabout = Roundabout(vocabulary)

    def of(self, text: str, language: Language, *, understood: bool) -> Iterator[str]:
        """The readings of ``text``, the likeliest first. Where it is ``understood`` already, only what was taken back
        matters."""
        yield from self._as_written(text, language, understood=understood)
        if language == "en" and not understood:
            for plain in self._roundabout.of(text):
                yield plain
                yield from self._as_written(plain, language, understood=False)
            for meant in self._misheard.meant(text):
                yield meant
                yield from self._as_written(meant, language, understood=False)

    def heard(self, text: str) -> Iterator[str]:
        """What was said, where it was written down otherwise."""
        return self._misheard.meant(text)

    def _as_written(self, text: str, language: Language, *, understood: bool) -> Iterator[str]:
        depends = CONDITION.search(text) is not None or conditional(text) is not None  # "…, beep, if no, dance"
        if not depends:
            yield from corrected(text, language)
        if understood:
            return
        for sequence in in_order(text, language) if not depends else ():
            yield sequence
            if language == "en":
                yield from self._several.one_by_one(sequence)
        if language != "en":
            return
        yield from self._several.one_by_one(text)
        yield from self._background.requests(text)
        for request in self._background.without_reasons(text):
            yield request
            yield from self._background.requests(request)
