"""The question about what a request leaves open, as it is put to whoever made it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from engine.errors import ExitCode
from engine.planner.gaps.kinds import Known
from engine.planner.gaps.left_open import LeftOpen
from engine.planner.phrases.phrases import Matched, PhrasePlanner
from engine.planner.request import Language, NoPlan, PlanRequest
from engine.planner.sentences import SAID
from engine.planner.stages.knowledge import Knowledge
from engine.planner.validation import which_of
from engine.skills.vocabulary import Vocabulary

_PUTS: Final = frozenset({"place_object", "place_in_bin", "putdown"})
_TAKES: Final = frozenset({"pick_object", "carry", "grasp_obj"})


class AskingBack:
    """Asks where a plan could only be guessed."""

    def __init__(
        self, phrases: Callable[[Language], PhrasePlanner], vocabulary: Vocabulary, knowledge: Knowledge
    ) -> None:
        self._phrases = phrases
        self._knowledge = knowledge
        self._left_open = LeftOpen(vocabulary)

    def question(
        self, request: PlanRequest, text: str, language: Language, *, understood: bool = False
    ) -> NoPlan | None:
        """What to ask about ``text``; None where nothing is open. ``understood``: phrases have made something of it,
        which is only wrong where it cannot be right."""
        before = Known(bool(request.happened), request.holding, request.seen)
        found = self._left_open.of(text, language, before, understood=understood)
        if found is None or self._knowledge.facts_for(text, 1):  # the user may have written down what "the usual" is
            return None
        if found.names:
            return which_of(text, found.names, language)
        gap = found.gap
        asked = SAID[language]["unfinished"] if gap == "unfinished" else gap and self._phrases(language).question(gap)
        return NoPlan(text, "incomplete" if gap else "ambiguous", asked or found.question, ExitCode.CLARIFY)


def needs_held(match: Matched) -> bool:
    """Whether it puts something where it was told, and has not picked it up before."""
    names = [call.name for call in match.calls]
    put = next((at for at, name in enumerate(names) if name in _PUTS), None)
    return match.kind == "plan" and put is not None and names != ["putdown"] and not _TAKES & set(names[:put])
