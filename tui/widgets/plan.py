"""What the planner made of the words: the goal, the steps in words, and where they came from; or why there is none."""

from __future__ import annotations

from typing import Final

from textual.content import Content

from tui import strings
from tui.facts import Plan
from tui.model import ConsoleModel
from tui.widgets.lines import Drawn, Lines

_MARKS: Final = {
    "thinking": ("◌ ", "$text-primary"),
    "made": ("◆ ", "$text-primary"),
    "rejected": ("✗ ", "$text-error"),
    "refused": ("⊘ ", "$text-error"),
    "question": ("? ", "$text-warning"),
}


class PlanView(Lines[tuple[str, str, str, str]]):
    """The plan of the current request."""

    def update_from(self, model: ConsoleModel) -> None:
        self.show(plan_items(model.plan), matters=0)

    def drawn(self, item: tuple[str, str, str, str]) -> Drawn:
        kind, sign, text, aside = item
        if kind in _MARKS:
            mark, style = _MARKS[kind]
            return Drawn(Content.styled(mark, style), Content.styled(text, "bold"), _muted(aside))
        return Drawn(_muted(sign), Content.styled(text, "$foreground" if kind == "step" else "$foreground 60%"))


def plan_items(plan: Plan | None) -> list[tuple[str, str, str, str]]:
    """Lines of a plan as (kind, sign, text, aside)."""
    if plan is None:
        return [("hint", "", strings.NO_PLAN, "")]
    asides = {
        "thinking": strings.THINKING,
        "made": strings.PLAN_BY.get(plan.source, plan.source),
        "rejected": strings.NO_PLAN_CAME,
        "refused": strings.REFUSED,
        "question": strings.QUESTION,
    }
    items: list[tuple[str, str, str, str]] = [(plan.stage, "", plan.goal, asides[plan.stage])]
    if plan.message:
        items.append(("step", "  ", plan.message, ""))
    items += [("step", f"{number:>3} ", step, "") for number, step in enumerate(plan.steps or plan.actions, 1)]
    items += [("hint", "  → ", suggestion, "") for suggestion in plan.suggestions]
    return items


def _muted(text: str) -> Content:
    return Content.styled(text, "$foreground 60%")
