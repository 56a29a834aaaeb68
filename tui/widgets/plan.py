"""What the planner made of the words: the goal, the steps in words, and where they came from; or why there is none."""

from __future__ import annotations

from typing import Final

from textual.content import Content

from tui.shown.facts import Plan
from tui.shown.model import ConsoleModel
from tui.widgets.lines import Drawn, Lines
from tui.words import strings
from tui.words.language import told

_MARKS: Final = {
    "thinking": ("◌ ", "$text-primary"),
    "made": ("◆ ", "$text-primary"),
    "rejected": ("✗ ", "$text-error"),
    "refused": ("⊘ ", "$text-error"),
    "question": ("? ", "$text-warning"),
}


class PlanView(Lines[tuple[str, str, str, str]]):
    """The plan of the current request."""

    def update_from(self, model: ConsoleModel, waits: str = "") -> None:
        """``waits``: what has to be loaded before it goes on, for people."""
        self.show(plan_items(model.plan, waits), matters=0)

    def drawn(self, item: tuple[str, str, str, str]) -> Drawn:
        kind, sign, text, aside = item
        if kind in _MARKS:
            mark, style = _MARKS[kind]
            # on one line: the conversation has all of it, and a small pane must have room for the steps
            return Drawn(Content.styled(mark, style), Content.styled(text, "bold"), _muted(aside), nowrap=True)
        return Drawn(_muted(sign), Content.styled(text, "$foreground" if kind == "step" else "$foreground 60%"))


def plan_items(plan: Plan | None, waits: str = "") -> list[tuple[str, str, str, str]]:
    """Lines of a plan as (kind, sign, text, aside)."""
    if plan is None:
        return [("hint", "", strings.NO_PLAN, "")]
    asides = {
        "thinking": strings.THINKING,
        "made": strings.PLAN_BY.get(plan.source, plan.source),
        "rejected": strings.NO_PLAN_CAME,
        "refused": strings.REFUSED,
        "question": strings.QUESTION if plan.open else strings.NO_ORDER,
    }
    if waits:
        asides |= dict.fromkeys(("thinking", "made"), strings.WAITS_FOR.format(parts=waits))
    items: list[tuple[str, str, str, str]] = [(plan.stage, "", plan.goal, asides[plan.stage])]
    if plan.message:
        items.append(("step", "  ", told(plan.message), ""))
    items += [("step", f"{number:>3} ", told(step), "") for number, step in enumerate(plan.steps or plan.actions, 1)]
    items += [("hint", "  → ", told(suggestion), "") for suggestion in plan.suggestions]
    return items


def _muted(text: str) -> Content:
    return Content.styled(text, "$foreground 60%")
